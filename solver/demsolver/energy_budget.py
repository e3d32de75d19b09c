"""Where the energy of a simulation is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class EnergyBudget:
    """Where the energy is, in units of the deck. Work taken out is positive.

    kinetic, rotational: of all particles. elastic_normal (cohesion included), elastic_tangential, elastic_rolling: in the contacts.
    gravitational: -sum m g.x, of unwrapped positions, relative to the origin. damped, rubbed, rolled, dragged: taken since the start by normal
    damping, by the tangential forces (their damping and their slip), by rolling and twisting torques, and by viscous drag, all of motion
    against the surface that is touched. driven: given by walls that move and by added forces, below zero where these brake. `total`, held plus
    taken less given, is what must stay put.
    """

    kinetic: float
    rotational: float
    elastic_normal: float
    elastic_tangential: float
    elastic_rolling: float
    gravitational: float
    damped: float
    rubbed: float
    rolled: float
    dragged: float
    driven: float

    @property
    def elastic(self) -> float:
        """What the contacts store."""
        return self.elastic_normal + self.elastic_tangential + self.elastic_rolling

    @property
    def mechanical(self) -> float:
        """What the scene holds now."""
        return self.kinetic + self.rotational + self.elastic + self.gravitational

    @property
    def total(self) -> float:
        """What it holds plus what it lost, less what it was given."""
        return self.mechanical + self.damped + self.rubbed + self.rolled + self.dragged - self.driven
