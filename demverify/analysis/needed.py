"""Which columns of a dump the rotational energy needs; the others are not even parsed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from demverify.formats.reading import Reading

BODY = ("id_multisphere", "mol")
POSITIONS = (("xu", "yu", "zu"), ("x", "y", "z"), ("xsu", "ysu", "zsu"), ("xs", "ys", "zs"))
_ALWAYS = frozenset(
    ("id", "type", "mass", "density", "radius", "diameter", "quat1", "quat2", "quat3", "quat4", "blockiness1", "blockiness2",
     "roundness1", "roundness2", *(name + axis for name in ("v", "omega", "angmom", "shape") for axis in "xyz"))
)  # fmt: skip
_OF_CLUMPS = frozenset({*BODY, *(name for names in POSITIONS for name in names)})
_OF_BODIES = frozenset(
    ("masstotal", "clumptype", *(f"{name}[{i}]" for name in ("vcm", "omega", "angmom", "inertia") for i in (1, 2, 3)))
) | {f"quat[{i}]" for i in (1, 2, 3, 4)}
_OF_HALF_STEPS = frozenset(name + axis for name in ("tq", "f") for axis in "xyz")


@dataclass(frozen=True)
class NeededColumns(Reading):
    """Reading that keeps what the energies are made of. halfstep: torques and forces too. positions: of free particles too.
    seen: all columns of the last frame."""

    halfstep: bool = False
    positions: bool = False
    seen: list[str] = field(default_factory=list, compare=False)

    def wanted(self, names: Sequence[str]) -> Collection[str]:
        """Positions only where they are asked for, or particles may belong to bodies."""
        self.seen[:] = names
        kept = _ALWAYS | _OF_BODIES | (_OF_HALF_STEPS if self.halfstep else frozenset())
        return kept | _OF_CLUMPS if self.positions or any(name in names for name in BODY) else kept
