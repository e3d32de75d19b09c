"""The rules in which the engines differ, exchanged: the scene of a LAMMPS deck under LIGGGHTS' rules.

Where LAMMPS and LIGGGHTS differ, either their rules do, or the two decks do not describe the same scene. Put the LAMMPS deck under
LIGGGHTS' rules in the native solver: if it then does what the LIGGGHTS deck does, the scenes are the same and the rules explain all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demsolver.scene import ContactLaw, Cylinder, Particles, Rotation, Scene, Wall

FRICTION = {"classic_history": "liggghts_history", "rotated_history": "liggghts_history"}
"""The spring both have, under its other rules. Springs that one of them alone has (mindlin_rescale ...) are another scene, not another rule."""


def under_liggghts_rules(scene: Scene, other: Scene) -> Scene:
    """`scene`, of a LAMMPS deck, with LIGGGHTS' levers, friction and wall rules, and its members of clumps; list rebuilds, which end histories
    there, as in `other`."""
    rebuilt = replace(other.neighbor, exclude=scene.neighbor.exclude, exclude_types=scene.neighbor.exclude_types)
    return replace(
        scene,
        particles=_particles(scene.particles),
        pair=_law(scene.pair) if scene.pair else None,
        walls=tuple(_wall(wall) for wall in scene.walls),
        neighbor=rebuilt,
        history_outlives_contact=other.history_outlives_contact,
    )


def _particles(p: Particles) -> Particles:
    """Members of clumps carry the mass of the whole, and gravity pulls at the centre of that."""
    if p.clumps is None:
        return p
    mass = np.where(p.clumps.body >= 0, p.clumps.mass[p.clumps.body], p.mass)
    return replace(p, mass=mass, clumps=replace(p.clumps, members_weigh=False))


def _law(law: ContactLaw) -> ContactLaw:
    return replace(law, friction=FRICTION.get(law.friction, law.friction), surface_arm="contact", torque_arm="contact")


def _wall(wall: Wall) -> Wall:
    shape = _cylinder(wall.shape) if isinstance(wall.shape, Cylinder) else wall.shape
    return replace(wall, law=_law(wall.law), shape=shape, touch_closed=True)


def _cylinder(shape: Cylinder) -> Cylinder:
    rotation = Rotation(shape.rotation.rate, "center", rolls=False) if shape.rotation else None
    return replace(shape, effective_radius="flat", side="both", rotation=rotation)
