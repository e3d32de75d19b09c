"""What is made of a deck's scene: other normal laws and integrators; and the contenders that most scenes have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from demverify.bench._contenders import Contender

if TYPE_CHECKING:
    from demsolver import ContactLaw, Scene

VERLET, EULER, GRADIENT, MENDED = "velocity Verlet", "semi-implicit Euler", "discrete gradient", "P mended"


def euler(scene: Scene) -> Scene:
    """By semi-implicit Euler."""
    from demsolver import EulerSphere
    from demsolver.state import factor_of

    return replace(scene, integrate=tuple(EulerSphere(one.bit, factor_of(one)) for one in scene.integrate))


def gradient(scene: Scene) -> Scene:
    """With the linear spring as a discrete gradient."""
    return _with_normal(scene, "discrete_gradient")


def mended(scene: Scene) -> Scene:
    """With model P of Fujioka & Ushijima, mended, elastic, by semi-implicit Euler."""
    return euler(_with_normal(scene, "fujioka2006"))


def _with_normal(scene: Scene, normal: str) -> Scene:
    walls = tuple(replace(wall, law=_swapped(wall.law, normal)) for wall in scene.walls)
    return replace(scene, walls=walls, pair=_swapped(scene.pair, normal) if scene.pair else None)


def _swapped(law: ContactLaw, normal: str) -> ContactLaw:
    """Damping stays where there is any; of the tangential parts the dashpot goes, which no scene here has, and where nothing rubs all."""
    coefficients = {**law.coefficients, "restitution": np.ones_like(law.coefficients["kn"])}
    damped, rubs = (np.any(law.coefficients.get(name, 0.0)) for name in ("gamman", "mu"))
    return replace(
        law, normal=normal, damping=law.damping if damped else "none", coefficients=coefficients, tangential_damping="none",
        tangential_stiffness=law.tangential_stiffness if rubs else "none", friction=law.friction if rubs else "none",
    )  # fmt: skip


def engines(orders: Mapping[str, float], why: Mapping[str, str] | None = None, liggghts: Mapping[str, str] | None = None) -> tuple[Contender, ...]:
    """LAMMPS and LIGGGHTS, both of which step by velocity Verlet. liggghts: reasons of its own."""
    return (
        Contender("LAMMPS", 4, "lammps", orders=orders, why=why or {}),
        Contender("LIGGGHTS", 5, "liggghts", orders=orders, why={**(why or {}), **(liggghts or {})}),
    )
