"""Charts of studies: series as lines, marks or both on any two axes, with the legend inside, so that the picture also stands alone as a file.

Colour, dash and mark of a series all follow from its `style`, 0 to 5: told apart without colour too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from demverify.formats.atomic import atomic_write
from demverify.frames import Floats
from demverify.report.axes import Axis
from demverify.report.pictures import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, frame, line, places

_MARKS = (
    "M{x} {y}m-2.6 0a2.6 2.6 0 1 0 5.2 0a2.6 2.6 0 1 0 -5.2 0z",  # circle
    "M{x} {y}m-2.3 -2.3h4.6v4.6h-4.6z",  # square
    "M{x} {y}m0 -3.1l2.9 5h-5.8z",  # triangle
    "M{x} {y}m0 -3.3l3.3 3.3l-3.3 3.3l-3.3 -3.3z",  # diamond
    "M{x} {y}m-2.4 -2.4l4.8 4.8m0 -4.8l-4.8 4.8",  # cross
    "M{x} {y}m-3 0h6m-3 -3v6",  # plus
)
_DASHES = ("", "7 3", "2 2.5", "9 3 2 3", "4 2", "1 2")
_ROW, _LETTER = 16, 5.7  # height of a row of the legend, width of a letter
_RING = "M{x} {y}m-5.2 0a5.2 5.2 0 1 0 10.4 0a5.2 5.2 0 1 0 -10.4 0z"
_MARGIN = 6  # what may stick out of the axes: half a mark, or a ring

_STYLE = """<style>
:root { font-family: system-ui, sans-serif; font-size: 10.5px; background: #ffffff; color-scheme: light dark }
path { fill: none } .head { font-size: 12.5px; font-weight: 650; fill: #1b1f24 }
.unit, .tick { font-weight: 400; font-size: 10.5px; fill: #5c6670 } .tier { font-size: 9.5px; fill: #5c6670 }
.grid { stroke: #eceef0 } .axis { stroke: #8a949e }
.b0 { stroke: #0072b2 } .b1 { stroke: #d55e00 } .b2 { stroke: #009e73 } .b3 { stroke: #a9518a } .b4 { stroke: #b07d00 } .b5 { stroke: #1b1f24 }
@media (prefers-color-scheme: dark) {
:root { background: #181c21 } .head { fill: #e7eaed } .unit, .tick, .tier { fill: #9aa5b0 }
.grid { stroke: #252b31 } .axis { stroke: #77828d }
.b0 { stroke: #56b4e9 } .b1 { stroke: #ff9a4d } .b2 { stroke: #3fcb9f } .b3 { stroke: #e58fc5 } .b4 { stroke: #e6c04a } .b5 { stroke: #f2f4f5 }
}
</style>"""


@dataclass(frozen=True)
class Series:
    """One row of points. x, y: (k,); NaN breaks a line. style: 0 to 5. shown: what is drawn. An empty name is not in the legend.

    ringed: (k,) of bool, points with a ring around their mark; None: none."""

    name: str
    x: Floats
    y: Floats
    style: int
    shown: Literal["line", "marks", "both"] = "line"
    ringed: NDArray[np.bool_] | None = None


@dataclass(frozen=True)
class Rule:
    """A thin line of reference through points x, y, with its name at the last of them that lies in the picture."""

    name: str
    x: Floats
    y: Floats


def chart(
    title: str, label: str, series: Sequence[Series], axes: tuple[Axis, Axis], names: tuple[str, str], rules: Sequence[Rule] = ()
) -> str:
    """The picture as inline SVG. label: what is seen, for screen readers. names: of the x axis, below, and of the y axis, beside the title."""
    x_axis, y_axis = axes
    drawn = "".join(_drawn(one, x_axis, y_axis) for one in series)
    ruled = "".join(f'<path d="{_path(*_at(rule, x_axis, y_axis))}" class="axis" stroke-width="1" stroke-dasharray="5 3"/>' for rule in rules)
    named = "".join(_named(rule, x_axis, y_axis) for rule in rules)
    legend, height = _legend(series)
    return frame(title, label, x_axis, y_axis, _clipped(ruled + drawn) + named, *names, legend, height)


def standalone(svg: str) -> str:
    """The same picture as the text of a file: with its own colours, light and dark."""
    start, _, inner = svg.partition(">")
    _, _, box = start.partition('viewBox="0 0 ')
    width, height = (float(size) for size in box.split('"')[0].split())
    start = start.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    start = start.replace(f'viewBox="0 0 {box.split(chr(34))[0]}"', f'viewBox="-10 -10 {width + 20:g} {height + 16:g}"')
    return f"{start}>{_STYLE}{inner}\n"


def write_svg(path: Path, svg: str) -> None:
    """Writes the picture, whole or not at all. Raises InputError where the file cannot be."""
    with atomic_write(path) as part:
        part.write_text(standalone(svg), encoding="utf-8")


def _stroke(style: int) -> str:
    dash = f' stroke-dasharray="{_DASHES[style % 6]}"' if _DASHES[style % 6] else ""
    return f'class="b{style % 6}" stroke-width="1.6"{dash}'


def _mark(style: int, x: Floats, y: Floats) -> str:
    return _outlined(_MARKS[style % 6], style, x, y)


def _outlined(shape: str, style: int, x: Floats, y: Floats) -> str:
    path = "".join(shape.format(x=f"{a:.1f}", y=f"{b:.1f}") for a, b in zip(x, y, strict=True) if np.isfinite(a) and np.isfinite(b))
    return f'<path class="b{style % 6}" stroke-width="1.2" d="{path}"/>'


def _drawn(one: Series, x_axis: Axis, y_axis: Axis) -> str:
    parts = []
    if one.shown != "marks":
        parts.append(line(*places(one.x, one.y, x_axis, y_axis), _stroke(one.style)))
    if one.shown != "line":
        parts.append(_mark(one.style, *_at(one, x_axis, y_axis)))
    if one.ringed is not None and one.ringed.any():
        x, y = _at(one, x_axis, y_axis)
        parts.append(_outlined(_RING, one.style, x[one.ringed], y[one.ringed]))
    return "".join(parts)


def _at(points: Series | Rule, x_axis: Axis, y_axis: Axis) -> tuple[Floats, Floats]:
    """Where all the points lie, none left out."""
    x, y = np.asarray(points.x, dtype=float), np.asarray(points.y, dtype=float)
    return LEFT + (RIGHT - LEFT) * x_axis.place(x), BOTTOM - (BOTTOM - TOP) * y_axis.place(y)


def _path(x: Floats, y: Floats) -> str:
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))


def _clipped(inner: str) -> str:
    """What lies outside the axes is not seen: a nested svg cuts it off."""
    x, y, width, height = LEFT - _MARGIN, TOP - _MARGIN, RIGHT - LEFT + 2 * _MARGIN, BOTTOM - TOP + 2 * _MARGIN
    return f'<svg x="{x}" y="{y}" width="{width}" height="{height}" viewBox="{x} {y} {width} {height}">{inner}</svg>'


def _named(rule: Rule, x_axis: Axis, y_axis: Axis) -> str:
    """The name of a rule, beside where it leaves the picture."""
    steps = np.linspace(0.0, len(rule.x) - 1.0, 400)
    x, y = (np.interp(steps, np.arange(len(rule.x)), places) for places in _at(rule, x_axis, y_axis))
    seen = np.flatnonzero((x >= LEFT) & (x <= RIGHT) & (y >= TOP) & (y <= BOTTOM))
    if not len(seen):
        return ""
    a, b = x[seen[-1]], y[seen[-1]]
    anchor, dx = ("end", -4) if a > (LEFT + RIGHT) / 2 else ("start", 4)
    down = 11 if b < TOP + 12 else -4
    return f'<text class="tier" x="{a + dx:.1f}" y="{b + down:.1f}" text-anchor="{anchor}">{escape(rule.name)}</text>'


def _legend(series: Sequence[Series]) -> tuple[str, int]:
    """Marks and names in rows under the picture, and the height of the rows."""
    if len(series) < 2:
        return "", 0
    parts, x, y = [], 0.0, HEIGHT + 8.0
    for one in [one for one in series if one.name]:
        width = 34 + _LETTER * len(one.name)
        if x > 0 and x + width > WIDTH - 8:
            x, y = 0.0, y + _ROW
        parts += [f'<path d="M{x:.1f} {y}h22" {_stroke(one.style)}/>'] if one.shown != "marks" else []
        parts += [_mark(one.style, np.array([x + 11]), np.array([y]))] if one.shown != "line" else []
        parts.append(f'<text class="tick" x="{x + 27:.1f}" y="{y + 3.6}">{escape(one.name)}</text>')
        x += width + 12
    return "".join(parts), int(y + _ROW - 6 - HEIGHT)
