"""The picture of rotational energy over time: one SVG file that stands alone, in light and dark."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from demverify.analysis.energies import Row
from demverify.formats.atomic import atomic_write
from demverify.report.pictures import HEIGHT, RIGHT, WIDTH, lines_picture

_STYLE = """<style>
svg { font-family: system-ui, sans-serif; font-size: 10.5px; background: #ffffff; color-scheme: light dark }
.plot path { fill: none }
.head { font-size: 12.5px; font-weight: 650; fill: #1b1f24 } .unit, .tick { font-weight: 400; font-size: 10.5px; fill: #5c6670 }
.grid { stroke: #eceef0 } .axis { stroke: #8a949e }
.total { stroke: #1b1f24 } .s0 { stroke: #0072b2 } .s1 { stroke: #d55e00 } .s2 { stroke: #009e73 } .s3 { stroke: #a9518a }
@media (prefers-color-scheme: dark) {
svg { background: #181c21 } .head { fill: #e7eaed } .unit, .tick { fill: #9aa5b0 } .grid { stroke: #252b31 } .axis { stroke: #77828d }
.total { stroke: #f2f4f5 } .s0 { stroke: #56b4e9 } .s1 { stroke: #ff9a4d } .s2 { stroke: #3fcb9f } .s3 { stroke: #e58fc5 }
}
</style>"""
_DASHES = ("", "7 3", "2 2.5", "9 3 2 3")


def erotate_picture(rows: Sequence[Row]) -> str:
    """Total rotational energy over time, and each shape that is there where there is more than one. rows: at least one."""
    timed = all(row.time is not None for row in rows)
    x = np.array([row.time if timed else row.step for row in rows], dtype=float)
    shapes = [name for name in rows[0].by_shape if any(row.by_shape[name] != 0.0 for row in rows)]
    lines = [("all", np.array([row.erotate for row in rows]), 'class="total" stroke-width="2.6" stroke-opacity=".45"')]
    if len(shapes) > 1:
        lines += [(name, np.array([row.by_shape[name] for row in rows]), _stroke(k)) for k, name in enumerate(shapes)]
    ends = "; ".join(f"{name} from {values[0]:.4g} to {values[-1]:.4g}" for name, values, _ in lines)
    label = f"rotational energy over time: {ends}"
    drawn = lines_picture("rotational energy", label, [(x, y, stroke) for _, y, stroke in lines], "time" if timed else "step")
    start, _, inner = drawn.partition(">")
    named = start.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    named = named.replace(f'viewBox="0 0 {WIDTH} {HEIGHT}"', f'viewBox="-10 -10 {WIDTH + 20} {HEIGHT + 16}"')
    return f"{named}>{_STYLE}{inner.removesuffix('</svg>')}{_legend(lines)}</svg>"


def write_picture(path: Path, rows: Sequence[Row]) -> None:
    """Writes the picture. Raises InputError when the file cannot be written."""
    with atomic_write(path) as part:
        part.write_text(erotate_picture(rows) + "\n", encoding="utf-8")


def _stroke(index: int) -> str:
    dash = _DASHES[index % len(_DASHES)]
    return f'class="s{index % 4}" stroke-width="1.6"' + (f' stroke-dasharray="{dash}"' if dash else "")


def _legend(lines: Sequence[tuple[str, np.ndarray, str]]) -> str:
    """Names of the lines, from the right, above the picture."""
    if len(lines) == 1:
        return ""
    parts, right = [], float(RIGHT)
    for name, _, stroke in reversed(lines):
        left = right - 5.6 * len(name)
        parts.append(f'<text class="tick" x="{left:.1f}" y="11">{escape(name)}</text><path d="M{left - 24:.1f} 7.5h19" {stroke}/>')
        right = left - 34
    return "".join(parts)
