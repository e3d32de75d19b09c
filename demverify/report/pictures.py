"""Pictures as inline SVG: no library, no script, colours from the page's CSS variables, so that they follow light and dark.

Engines that agree draw one line over the other. The first is therefore drawn broad and pale, the next narrower, the last
dashed and thin: where all are seen at one place, all agree. Width and dash tell them apart without colour.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from demverify.chaos import Envelope
from demverify.compare import Check, Tolerances
from demverify.frames import Floats
from demverify.report.axes import Axis, decades, linear, scientific, steps
from demverify.report.content import DifferenceCurve, EnergySeries

WIDTH, HEIGHT = 420, 250
LEFT, RIGHT, TOP, BOTTOM = 50, 400, 26, 212
LOWEST = -17  # below 10^-17 of its scale a difference is drawn as zero
_POINTS = 300  # points a line is thinned to
_STROKES = (("7", "", ".38"), ("3", "", ".95"), ("1.5", "5 3", "1"), ("1.5", "1.5 2.5", "1"))


def energy_picture(name: str, series: Mapping[str, EnergySeries]) -> str:
    """One energy over time, of every engine that has it."""
    shown = {engine: (s.time, s.values[name]) for engine, s in series.items() if name in s.values and len(s.time)}
    order = list(series)
    lines = [
        (times, values, _stroke(order.index(engine), f"e{order.index(engine)}")) for engine, (times, values) in shown.items()
    ]
    ends = "; ".join(f"{engine} from {values[0]:.4g} to {values[-1]:.4g}" for engine, (_, values) in shown.items())
    return lines_picture(name, f"{name} over time: {ends}", lines)


def budget_picture(engine: str, series: EnergySeries, names: Sequence[str]) -> str:
    """The energy budget of one engine: every share over time, each in a colour and dash of its own."""
    lines = [(series.time, series.values[name], budget_stroke(k)) for k, name in enumerate(names)]
    ends = "; ".join(f"{name} from {series.values[name][0]:.4g} to {series.values[name][-1]:.4g}" for name in names)
    return lines_picture("energy", f"energy budget of {engine} over time: {ends}", lines)


def budget_stroke(index: int) -> str:
    """The attributes of the line of the index-th share of a budget."""
    dashes = ("", "7 3", "2 2.5", "9 3 2 3", "4 2", "1 2")
    dash = dashes[index % len(dashes)]
    return f'class="b{index % 6}" stroke-width="2"' + (f' stroke-dasharray="{dash}"' if dash else "")


def engine_stroke(index: int) -> str:
    """The attributes of the line of the index-th engine."""
    return _stroke(index, f"e{index}")


def pair_stroke(index: int) -> str:
    """The attributes of the line of the index-th pair of engines."""
    width, dash = (("2.2", ""), ("1.8", "6 3"), ("1.8", "1.5 2.5"))[index % 3]
    return f'class="p{index % 3}" stroke-width="{width}"' + (f' stroke-dasharray="{dash}"' if dash else "")


def difference_picture(
    quantity: str,
    curves: Mapping[int, DifferenceCurve],
    envelope: DifferenceCurve | None,
    failed: Sequence[Check],
    tolerances: Tolerances,
) -> str:
    """Relative difference over time on a logarithmic axis: pairs of engines (by their index), the chaos envelope as a grey
    area, the limit as a line, and a cross at each of `failed`."""
    everything = [*curves.values(), *([envelope] if envelope else [])]
    first = min(float(c.step[0]) for c in everything)
    last = max(float(c.step[-1]) for c in everything) - first
    x_axis = steps(last)
    values = np.concatenate([c.value for c in curves.values()] + ([tolerances.chaos_factor * envelope.value] if envelope else []))
    peak = min(float(np.max(values, where=np.isfinite(values), initial=1e-6)), 1.0)
    y_axis = decades(LOWEST, int(np.ceil(np.log10(peak))))
    parts = [_area(*places(envelope.step - first, envelope.value, x_axis, y_axis))] if envelope else []
    parts.append(_limits(last, x_axis, y_axis, envelope, first, tolerances))
    for index, curve in curves.items():
        parts.append(line(*places(curve.step - first, curve.value, x_axis, y_axis), pair_stroke(index)))
    marks = (c for c in failed if np.isfinite(c.max_rel))
    parts += [_cross(*places(np.array([c.step - first]), np.array([c.max_rel]), x_axis, y_axis)) for c in marks]
    worst = "; ".join(f"{' and '.join(c.engines)} at most {scientific(float(np.max(c.value)))}" for c in curves.values())
    label = f"relative difference of {quantity} over the steps: {worst}"
    return frame(f"{quantity}", label, x_axis, y_axis, "".join(parts), "steps since the set-up", "relative difference")


def gauge(max_rel: float, tolerance: float, outcome: str) -> str:
    """A difference and its limit on one small logarithmic scale from 0 to 1 and beyond: a dot, and a bar at the limit."""
    if not np.isfinite(max_rel) or not np.isfinite(tolerance):
        return ""
    axis = decades(LOWEST, 0)
    at, limit = (float(4 + 112 * axis.place(np.array([value]))[0]) for value in (max_rel, tolerance))
    return (
        '<svg class="gauge" viewBox="0 0 120 14" aria-hidden="true">'
        f'<line class="track" x1="4" x2="116" y1="7" y2="7"/><line class="reach {outcome}" x1="4" x2="{at:.1f}" y1="7" y2="7"/>'
        f'<line class="limit" x1="{limit:.1f}" x2="{limit:.1f}" y1="1" y2="13"/>'
        f'<circle class="{outcome}" cx="{at:.1f}" cy="7" r="3.6"/></svg>'
    )


def swatch(stroke: str) -> str:
    """A short piece of a line, for a legend."""
    return f'<svg class="swatch" viewBox="0 0 34 10" aria-hidden="true"><path d="M2 5H32" {stroke}/></svg>'


def _stroke(index: int, colour: str) -> str:
    width, dash, opacity = _STROKES[index % len(_STROKES)]
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    return f'class="{colour}" stroke-width="{width}" stroke-opacity="{opacity}"{dashed}'


def lines_picture(title: str, label: str, lines: Sequence[tuple[Floats, Floats, str]], x_name: str = "time") -> str:
    """A picture of values over time on linear axes, (times, values, stroke) a line; energies start at zero. label: for screen readers."""
    times, values = (np.concatenate([line[k] for line in lines]) for k in (0, 1))
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    x_axis = linear(float(times.min()), float(times.max()))
    y_axis = linear(min(0.0, low * 1.06), max(0.0, high * 1.06))
    drawn = "".join(line(*places(t, v, x_axis, y_axis), stroke) for t, v, stroke in lines)
    return frame(title, label, x_axis, y_axis, drawn, x_name, "")


def frame(
    title: str, label: str, x_axis: Axis, y_axis: Axis, drawn: str, x_name: str, y_name: str, below_it: str = "", rows: int = 0
) -> str:
    """Axes, grid and names around what is drawn. below_it: more SVG under the picture, from HEIGHT on, `rows` units high."""
    grid = [f'<path class="grid" d="M{LEFT} {y:.1f}H{RIGHT}"/>' for y in (_y(place) for place, _ in y_axis.ticks)]
    left = [
        f'<text class="tick" x="{LEFT - 6}" y="{_y(p) + 3.6:.1f}" text-anchor="end">{text}</text>' for p, text in y_axis.ticks
    ]
    below = [
        f'<text class="tick" x="{_x(p):.1f}" y="{BOTTOM + 15}" text-anchor="middle">{text}</text>' for p, text in x_axis.ticks
    ]
    notches = [f'<path class="axis" d="M{_x(p):.1f} {BOTTOM}v4"/>' for p, _ in x_axis.ticks]
    named = f'<text class="unit" x="{(LEFT + RIGHT) / 2}" y="{HEIGHT - 6}" text-anchor="middle">{x_name} {x_axis.unit}</text>'
    heading = f'<text class="head" x="0" y="11">{escape(title)}<tspan class="unit" dx="6">{y_name} {y_axis.unit}</tspan></text>'
    body = "".join([*grid, drawn, f'<path class="axis" d="M{LEFT} {BOTTOM}H{RIGHT}"/>', *notches, *left, *below, named, heading, below_it])
    return f'<svg class="plot" role="img" aria-label="{escape(label)}" viewBox="0 0 {WIDTH} {HEIGHT + rows}">{body}</svg>'


def _limits(
    last: float, x_axis: Axis, y_axis: Axis, envelope: DifferenceCurve | None, first: float, tolerances: Tolerances
) -> str:
    """The limit over the run as a stair: tier 1 at the set-up, tier 2 after it, and from where chaos lifts it, that."""
    notch, end = 5.0, _x(float(x_axis.place(np.array([min(last, tolerances.tier2_steps)]))[0]))
    low, high = (_y(float(p)) for p in y_axis.place(np.array([tolerances.tier1, tolerances.tier2])))
    stair = f'<path class="limit" d="M{LEFT - notch} {low:.1f}H{LEFT + notch}V{high:.1f}H{end:.1f}"/>'
    named = f'<text class="tier" x="{LEFT + notch + 4}" y="{high - 4:.1f}">limit {scientific(tolerances.tier2)}</text>'
    if last <= tolerances.tier2_steps:
        return stair + named
    wall = f'<path class="wall" d="M{end:.1f} {TOP}V{BOTTOM}"/><text class="tier" x="{end + 4:.1f}" y="{TOP + 8}">tier 3</text>'
    return wall + stair + named + line(*_lifted(last, x_axis, y_axis, envelope, first, tolerances), 'class="limit late"')


def _lifted(
    last: float, x_axis: Axis, y_axis: Axis, envelope: DifferenceCurve | None, first: float, tolerances: Tolerances
) -> tuple[Floats, Floats]:
    """The limit of tier 3: that of tier 2, or the chaos factor times the envelope where that is larger."""
    if not envelope:
        since = np.array([tolerances.tier2_steps, last])
        return places(since, np.full(2, tolerances.tier2), x_axis, y_axis)
    steps_of = envelope.step - first
    since = np.unique([tolerances.tier2_steps, *steps_of[steps_of > tolerances.tier2_steps], last])
    grown = Envelope(steps_of.astype(np.int64), {envelope.quantity: envelope.value})
    chaos = [tolerances.chaos_factor * grown.at(envelope.quantity, int(step)) for step in since]
    return places(since, np.maximum(tolerances.tier2, chaos), x_axis, y_axis)


def places(x: Floats, y: Floats, x_axis: Axis, y_axis: Axis) -> tuple[Floats, Floats]:
    """Where points lie in the picture; NaN stays NaN."""
    x, y = thinned(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    return LEFT + (RIGHT - LEFT) * x_axis.place(x), BOTTOM - (BOTTOM - TOP) * y_axis.place(y)


def thinned(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """At most some 300 points: of each stretch of a longer line its smallest and its largest value, in their order; ends stay."""
    if len(x) <= _POINTS:
        return x, y
    keep = {0, len(x) - 1}
    for part in np.array_split(np.arange(len(x)), _POINTS // 2):
        known = part[np.isfinite(y[part])]
        keep |= {int(known[np.argmin(y[known])]), int(known[np.argmax(y[known])])} if len(known) else {int(part[0])}
    kept = np.array(sorted(keep))
    return x[kept], y[kept]


def line(x: Floats, y: Floats, stroke: str) -> str:
    """A line, broken where it is not finite; a single point is a dot."""
    known = np.isfinite(y)
    runs = [run for run in np.split(np.arange(len(x)), np.flatnonzero(np.diff(known)) + 1) if len(run) and known[run[0]]]
    path = "".join("M" + "L".join(f"{x[k]:.1f} {y[k]:.1f}" for k in run) for run in runs)
    dots = "".join(f"M{x[k]:.1f} {y[k]:.1f}h0" for k in np.flatnonzero(known)) if len(x) <= 1 else ""
    marked = f'<path d="{dots}" {stroke.split(" ", maxsplit=1)[0]} stroke-width="7" stroke-linecap="round"/>' if dots else ""
    return f'<path d="{path}" {stroke} stroke-linejoin="round"/>{marked}'


def _area(x: Floats, y: Floats) -> str:
    """The chaos envelope: grey from the foot up to the curve."""
    known = np.isfinite(y)
    if not known.any():
        return ""
    x, y = x[known], y[known]
    top = "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))
    return (
        f'<path class="envelope" d="M{x[0]:.1f} {BOTTOM}L{top}L{x[-1]:.1f} {BOTTOM}Z"/><path class="envelope-edge" d="M{top}"/>'
    )


def _cross(x: Floats, y: Floats) -> str:
    return f'<path class="cross" d="M{x[0] - 3.5:.1f} {y[0] - 3.5:.1f}l7 7m0 -7l-7 7"/>'


def _x(place: float) -> float:
    return LEFT + (RIGHT - LEFT) * place


def _y(place: float) -> float:
    return BOTTOM - (BOTTOM - TOP) * place
