"""The plane of K = k dt^2/m and H = eta dt/m: where a step holds and where a disturbance grows, with the boundary that theory draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from demsolver import Scene
from demverify.frames import Floats
from demverify.report.axes import linear as axis
from demverify.report.charts import Rule, Series, chart
from demverify.stability.held import GROWN, INTEGRATORS, MASS, NUDGE, OVERLAP, grown, longest, on_floor
from demverify.stability.limits import WALL, WITHIN, disturbed, jointed, with_drag
from demverify.studies import Claim, Figure, Finding, Progress

DT = 1e-4
HOW = (
    "A sphere on a floor whose spring and damper are chosen so that a step of 1e-4 s has the given K and H, disturbed along the normal: 2,000 steps, "
    "or until it has grown a thousandfold. Points on the boundary are bisected along rays of constant H/sqrt(K): one contact at many steps."
)
RAYS = (0.0, 0.05, 0.15, 0.3, 0.6, 1.0, 2.0, 5.0)  # H/sqrt(K): eta over sqrt(k m)


@dataclass(frozen=True)
class Plane:
    """What came out with one integrator. K, H: (k,) the points. holds: (k,) whether they do. edge: (r, 2) measured K and H of the boundary."""

    integrator: str
    K: Floats
    H: Floats
    holds: NDArray[np.bool_]
    edge: Floats

    @property
    def wrong(self) -> int:
        """Points that do not do what theory says."""
        return int((self.holds != (inside(self.K, self.H) > 0.0)).sum())

    @property
    def off(self) -> float:
        """Farthest that a bisected point is off the boundary, in the step."""
        return float(np.abs(_stretch(self.edge) - 1.0).max())


def inside(K: Floats, H: Floats) -> Floats:
    """Above zero where theory says that it holds."""
    return np.asarray(np.minimum(4.0 - K - 2.0 * H, 2.0 - H))


def _stretch(edge: Floats) -> Floats:
    """The step of points (K, H) over that of the boundary on their ray: K grows with its square, H with itself."""
    K, H = edge.T
    return np.asarray((H + np.sqrt(H**2 + 4.0 * K)) / 4.0)


def at(K: float, H: float, integrator: str, dt: float = DT) -> Scene:
    """A sphere on a floor of that K and H at a step of DT, run with dt."""
    stiffness, scene_law = K * MASS / DT**2, {"kn": K * MASS / DT**2, "gamman": H / DT}
    # out of place as well: a velocity alone is gone after one step of H = 1, where that is an eigenvalue of 0
    overlap = (1.0 + 0.3 * NUDGE) * OVERLAP
    scene = with_drag(on_floor(dt, jointed((1,), **scene_law), overlap=overlap, pull=stiffness * OVERLAP / MASS))
    return replace(disturbed(scene, "normal", WALL, NUDGE * OVERLAP), integrate=INTEGRATORS[integrator])


def points(quick: bool) -> tuple[Floats, Floats]:
    """A grid none of whose points lies within 0.05 of the boundary 4 - K - 2 H = 0."""
    across, up = (0.5, 0.4) if quick else (0.25, 0.2)
    K, H = np.meshgrid(np.arange(0.5 * across, 5.0, across), np.arange(0.25 * up, 2.6, up))
    K, H = K.ravel(), H.ravel()
    far = np.abs(inside(K, H)) > 0.04
    return K[far], H[far]


def measure(integrator: str, quick: bool, told: Progress) -> Plane:
    """Points and boundary of one integrator."""
    K, H = points(quick)
    holds = []
    for k, (a, b) in enumerate(zip(K.tolist(), H.tolist(), strict=True)):
        told(f"K = {a:.3g}, H = {b:.3g}, {integrator}", 0.8 * k / len(K))
        holds.append(grown(at(a, b, integrator)).size <= GROWN)
    edge = []
    for k, ratio in enumerate(RAYS):
        told(f"H/sqrt(K) = {ratio:g}, {integrator}", 0.8 + 0.2 * k / len(RAYS))
        found = longest(lambda dt: at(1.0, ratio, integrator, dt), DT * 4.0 / (ratio + np.sqrt(ratio**2 + 4.0)), to=5e-3 if quick else 1e-3)  # noqa: B023
        edge.append(((found.step / DT) ** 2, ratio * found.step / DT))
    return Plane(integrator, K, H, np.array(holds), np.array(edge))


def plane(quick: bool, progress: Progress) -> Finding:
    """The part."""
    planes = []
    for k, name in enumerate(INTEGRATORS):
        planes.append(measure(name, quick, lambda what, share: progress(what, (k + share) / len(INTEGRATORS))))  # noqa: B023
    return finding(planes)


def finding(planes: Sequence[Plane]) -> Finding:
    """Claims, a picture for each integrator, numbers."""
    claims = []
    for one in planes:
        claims += [
            Claim(f"By {one.integrator} a disturbance holds exactly where H < 2 and K + 2 H < 4.",
                  f"{len(one.K)} points, {one.wrong} of them do something else.", one.wrong == 0),
            Claim(f"By {one.integrator} the boundary is where K + 2 H = 4, within {WITHIN:.0%} in the step.",
                  f"{len(one.edge)} points of it bisected, {one.off:.2%} off at most.", one.off <= WITHIN),
        ]  # fmt: skip
    numbers = {one.integrator: {"K": one.K, "H": one.H, "holds": one.holds, "K, H of the boundary": one.edge} for one in planes}
    return Finding("The plane of spring and damper", tuple(claims), HOW, tuple(map(picture, planes)), (), numbers)


def picture(one: Plane) -> Figure:
    """Where it holds, where it grows, the boundary measured and of theory."""
    marks = [
        Series("holds", one.K[one.holds], one.H[one.holds], 0, "marks"),
        Series("grows", one.K[~one.holds], one.H[~one.holds], 4, "marks"),
        Series("boundary, bisected", one.edge[:, 0], one.edge[:, 1], 3, "marks"),
        Series("K + 2 H = 4", np.array([0.0, 4.0]), np.array([2.0, 0.0]), 5, "line"),
    ]
    svg = chart(
        one.integrator, f"Where a step holds and where a disturbance grows in the plane of k dt^2/m and eta dt/m, {one.integrator}", marks,
        (axis(0.0, 5.5), axis(0.0, 2.6)), ("K = k dt²/m", "H = eta dt/m"), [Rule("H = 2", np.array([0.0, 5.5]), np.array([2.0, 2.0]))],
    )  # fmt: skip
    stem = one.integrator.split()[-1].lower()
    return Figure(f"plane-{stem}", f"Held and growing steps by {one.integrator}, and the boundary K + 2 H = 4.", svg)
