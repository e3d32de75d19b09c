"""The rules in which the engines differ, exchanged: the scene of a LAMMPS deck under LIGGGHTS' rules.

Where LAMMPS and LIGGGHTS differ, either their rules do, or the two decks do not describe the same scene. Put the LAMMPS deck under
LIGGGHTS' rules in the native solver: if it then does what the LIGGGHTS deck does, the scenes are the same and the rules explain all.
"""

from __future__ import annotations

from dataclasses import replace

from demsolver import contact
from demsolver.scene import ContactLaw, Cylinder, Scene, Wall

FRICTION = "liggghts_history"


def under_liggghts_rules(scene: Scene, other: Scene) -> Scene:
    """`scene`, of a LAMMPS deck, with LIGGGHTS' levers, friction and wall rules; list rebuilds, which end histories there, as in `other`."""
    rebuilt = replace(other.neighbor, exclude=scene.neighbor.exclude, exclude_types=scene.neighbor.exclude_types)
    return replace(
        scene,
        pair=_law(scene.pair) if scene.pair else None,
        walls=tuple(_wall(wall) for wall in scene.walls),
        neighbor=rebuilt,
        history_outlives_contact=other.history_outlives_contact,
    )


def _law(law: ContactLaw) -> ContactLaw:
    friction = FRICTION if law.friction != "none" and contact.memory("friction", law.friction) else law.friction
    return replace(law, friction=friction, surface_arm="contact", torque_arm="contact")


def _wall(wall: Wall) -> Wall:
    shape = replace(wall.shape, effective_radius="flat") if isinstance(wall.shape, Cylinder) else wall.shape
    return replace(wall, law=_law(wall.law), shape=shape, touch_closed=True)
