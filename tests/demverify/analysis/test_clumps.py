"""Rigid bodies from their members: what bodies are made, from what, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from demsolver.computes import Population, RigidBodies
from demsolver.computes.erotate_multisphere import erotate_multisphere
from demsolver.shapes.multisphere import Template
from demsolver.shapes.union import Solid, sum_of_spheres, union
from demverify.analysis.clump_inertia import diagnose, forecast, liggghts_slip
from demverify.analysis.clumps import rigid_bodies
from demverify.analysis.meanings import Meanings
from demverify.errors import InputError
from demverify.frames import Frame

Floats = NDArray[np.float64]
ROUNDING = 1e-12  # positions up to 5 in a box of 10, clumps of size 1, some hundred operations
CROOKED = Template(np.array([[0, 0, 0], [0.6, 0, 0], [0, 0.5, 0.3], [-0.2, 0.3, -0.4]]), np.array([0.5, 0.4, 0.3, 0.35]), 2.0, 1)
MIRRORED = Template(CROOKED.centre * [1, 1, -1], CROOKED.radius, 2.0, 2)
ROD = Template(np.array([[0.0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]]), np.array([0.4, 0.4, 0.3]), 3.0, 3)
PAIR = Template(np.array([[0.0, 0, 0], [0.5, 0, 0]]), np.array([0.4, 0.4]), 3.0, 4)
LIGGGHTS, LAMMPS = Meanings(dialect="liggghts"), Meanings(dialect="lammps")
BOX = np.array([[-5.0, 5.0]] * 3)


@dataclass(frozen=True)
class Law:
    """What rigid_bodies ought to find, (m, ...): energy 1/2 omega . I omega, inertia in space, v of the centre of mass."""

    energy: Floats
    inertia: Floats
    mass: Floats
    v: Floats


class Swarm:
    """Bodies of given templates, each somewhere in the box with its own omega and its own v of the template's origin; ids shuffled, free
    spheres between them. own, whole: the population with either engine's masses."""

    def __init__(self, templates: list[Template], seed: int = 1) -> None:
        rng = np.random.default_rng(seed)
        self.templates = templates
        self.turn = Rotation.random(len(templates), random_state=seed).as_matrix()
        self.at, self.v, self.omega = rng.uniform(-3, 3, (len(templates), 3)), *rng.normal(size=(2, len(templates), 3))
        parts = [self._members(i) for i in range(len(templates))]
        x, v, omega, radius, own, whole, body = (np.concatenate([part[i] for part in parts]) for i in range(7))
        n, free = len(x), 5
        rows = rng.permutation(n + free)
        body = np.concatenate([body, np.zeros(free, dtype=np.int64)])[rows]
        columns = [np.concatenate([each, np.ones((free, *each.shape[1:]))])[rows] for each in (own, radius, omega, x, v)]
        order = np.arange(1, n + free + 1)[rows]
        mass, radius, omega, x, v = columns
        self.own = Population(order, mass, radius, omega, x, v, body=body)
        self.whole = replace(self.own, mass=np.concatenate([whole, np.ones(free)])[rows])
        self.frame = frame("x")

    def _members(self, i: int) -> tuple[NDArray, ...]:
        template = self.templates[i]
        arms = template.centre @ self.turn[i].T
        k = len(arms)
        own = 4 / 3 * np.pi * template.radius**3 * template.density
        whole = np.full(k, union(template.centre, template.radius).volume * template.density)
        v = self.v[i] + np.cross(self.omega[i], arms)
        return self.at[i] + arms, v, np.tile(self.omega[i], (k, 1)), template.radius, own, whole, np.full(k, 10 * (i + 1))

    def law(self, solid: Callable[[Floats, Floats], Solid]) -> Law:
        """With volume, centroid and inertia of each template by `solid`."""
        solids = [solid(t.centre, t.radius) for t in self.templates]
        density = np.array([t.density for t in self.templates])
        inertia = np.array([d * q @ s.inertia @ q.T for d, q, s in zip(density, self.turn, solids, strict=True)])
        arms = np.array([q @ s.centroid for q, s in zip(self.turn, solids, strict=True)])
        energy = 0.5 * np.einsum("mi,mij,mj->m", self.omega, inertia, self.omega)
        return Law(energy, inertia, density * [s.volume for s in solids], self.v + np.cross(self.omega, arms))


def frame(prefix: str = "x", boundary: str = "ff", cell: Floats | None = None, *, mass: bool = True) -> Frame:
    """A frame as far as rigid_bodies looks at it: box, and names of columns."""
    names = {"x": "x y z", "xu": "xu yu zu"}[prefix] + " mass" * mass
    return Frame(0, BOX, (boundary, boundary, boundary), dict.fromkeys(names.split(), np.empty(0)), cell)


def assert_law(swarm: Swarm, found: RigidBodies, solid: Callable[[Floats, Floats], Solid], tolerance: float = ROUNDING) -> None:
    """Numbers, energies, masses, velocities; and principal axes and moments make the tensor in space."""
    law = swarm.law(solid)
    assert_array_equal(found.id, 10 * np.arange(1, len(swarm.templates) + 1))
    assert_allclose(erotate_multisphere(found), law.energy, rtol=tolerance)
    assert_allclose(found.mass, law.mass, rtol=tolerance)
    assert_allclose(found.omega, swarm.omega, rtol=tolerance, atol=tolerance)
    assert_allclose(found.v, law.v, atol=10 * tolerance)
    axes = Rotation.from_quat(np.roll(found.quat, -1, axis=1)).as_matrix()
    assert_allclose(axes * found.inertia[:, None] @ np.swapaxes(axes, 1, 2), law.inertia, atol=tolerance * np.abs(law.inertia).max())


@pytest.mark.parametrize("templates", [(CROOKED, ROD, PAIR), ()], ids=["templates", "members alone"])
def test_union_as_liggghts(templates: tuple[Template, ...]) -> None:
    """Law: E = 1/2 omega . I omega with I of the union of the spheres, turned with the body; members carry the mass of the whole. The
    templates only name what the members show."""
    swarm = Swarm([CROOKED, ROD, CROOKED, PAIR, ROD])
    assert_law(swarm, rigid_bodies(swarm.whole, swarm.frame, replace(LIGGGHTS, templates=templates)), union)


def test_spheres_as_lammps() -> None:
    """Law: I is the sum of 2/5 m R^2 and m (r.r - r r^T), seed eq. (5); the masses of the members add up; v is that of the common
    centre of mass."""
    swarm = Swarm([CROOKED, ROD, CROOKED, PAIR])
    assert_law(swarm, rigid_bodies(swarm.own, swarm.frame, LAMMPS), sum_of_spheres)


def test_either_inertia_of_either_engine() -> None:
    """Law: with inertia of choice the mass stays that of the dump, spread over the union, or shared by the spheres by volume."""
    swarm = Swarm([CROOKED, ROD])
    for population, meanings, inertia, solid in (
        (swarm.whole, LIGGGHTS, "spheres", sum_of_spheres), (swarm.own, LAMMPS, "union", union),
    ):  # fmt: skip
        found = rigid_bodies(population, swarm.frame, meanings, inertia)
        law = swarm.law(solid)
        assert_allclose(erotate_multisphere(found), law.energy * found.mass / law.mass, rtol=ROUNDING)
        assert_allclose(found.mass, swarm.law(union if meanings is LIGGGHTS else sum_of_spheres).mass, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("found", "meanings", "convention"),
    [
        (frame(), LIGGGHTS, "whole"),
        (replace(frame(), dialect="liggghts"), Meanings(), "whole"),
        (replace(frame(), dialect="liggghts"), LAMMPS, "own"),
        (frame(), Meanings(rigid="multisphere"), "whole"),
        (frame(), Meanings(rigid="molecule"), "own"),
        (replace(frame(), columns=frame().columns | {"id_multisphere": np.empty(0)}), Meanings(), "whole"),
    ],
)
def test_whose_conventions(found: Frame, meanings: Meanings, convention: str) -> None:
    """Law: the engine that is named holds, then the one that the file shows, then the one whose columns these are."""
    swarm = Swarm([CROOKED])
    mass = rigid_bodies(getattr(swarm, convention), found, meanings).mass
    assert_allclose(mass, swarm.law(union if convention == "whole" else sum_of_spheres).mass, rtol=ROUNDING)


def test_without_masses() -> None:
    """Law: mass is density times volume: of the union (LIGGGHTS), of every sphere (LAMMPS); a density of the template goes first."""
    swarm = Swarm([CROOKED, ROD])
    unknown = frame(mass=False)
    assert_law(swarm, rigid_bodies(swarm.own, unknown, LIGGGHTS), union)
    assert_law(swarm, rigid_bodies(swarm.own, unknown, LAMMPS), sum_of_spheres)
    known = replace(LIGGGHTS, templates=(CROOKED, ROD))
    assert_law(swarm, rigid_bodies(replace(swarm.own, mass=None), unknown, known), union)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_across_periodic_faces(seed: int) -> None:
    """Law: images of the members change nothing, in a cuboid or a tilted cell, wherever the members are sorted into the box."""
    rng = np.random.default_rng(seed)
    swarm = Swarm([CROOKED, ROD, CROOKED], seed)
    cell = np.array([[10.0, 0, 0], [2.0, 10, 0], [-1.0, 3.0, 10]]) if seed % 2 else None
    periodic = frame(boundary="pp", cell=cell)
    images = rng.integers(-2, 3, swarm.whole.x.shape) @ periodic.edges
    assert_law(swarm, rigid_bodies(replace(swarm.whole, x=swarm.whole.x + images), periodic, LIGGGHTS), union, 10 * ROUNDING)


def test_a_body_as_long_as_half_the_box() -> None:
    """Law: beyond half a period the nearest image may be the wrong one: refused, unless positions are unwrapped or the axis is not periodic."""
    long = Template(np.outer(np.arange(10.0), [1.0, 0, 0]), np.full(10, 0.6), 2.0)  # 9 / sqrt(3) > 5 along some axis
    swarm = Swarm([long])
    with pytest.raises(InputError, match=r"body 10 reaches over half the periodic box.*xu yu zu"):
        rigid_bodies(swarm.whole, frame(boundary="pp"), LIGGGHTS)
    with pytest.raises(InputError, match=r"body 10 reaches over half the box, and the file does not tell whether that is periodic.*xu yu zu"):
        rigid_bodies(swarm.whole, frame(boundary="??"), LIGGGHTS)
    for fine in (frame("xu", "pp"), frame("x", "ff"), frame("x", "sm"), frame("xu", "??")):
        assert_law(swarm, rigid_bodies(swarm.whole, fine, LIGGGHTS), union)
    short = Swarm([CROOKED])
    assert_law(short, rigid_bodies(short.whole, frame(boundary="??"), LIGGGHTS), union)


@settings(max_examples=25, deadline=None)
@given(st.permutations(range(4)), st.permutations(range(4)))
def test_members_in_another_order_than_the_template(one: list[int], other: list[int]) -> None:
    """Law: radii and distances say which member is which sphere."""
    swarm = Swarm([CROOKED, CROOKED, CROOKED])
    ids = swarm.whole.id.copy()
    for body, order in ((10, one), (30, other)):
        mine = np.flatnonzero(swarm.whole.body == body)
        ids[mine] = ids[mine][order]
    assert_law(swarm, rigid_bodies(replace(swarm.whole, id=ids), swarm.frame, replace(LIGGGHTS, templates=(ROD, CROOKED))), union)


def test_equal_spheres_in_any_order() -> None:
    """Law: of a clump of equal spheres only distances tell them apart; its mirror image has the same."""
    rng = np.random.default_rng(3)
    spheres = Template(rng.normal(size=(9, 3)) * 0.5, np.full(9, 0.4), 2.0)
    swarm = Swarm([spheres] * 4)
    shuffled = replace(swarm.whole, id=rng.permutation(swarm.whole.id))
    twin = replace(spheres, centre=spheres.centre * [-1, 1, 1], kind=2)
    assert_law(swarm, rigid_bodies(shuffled, swarm.frame, replace(LIGGGHTS, templates=(spheres,))), union)
    assert_law(swarm, rigid_bodies(shuffled, swarm.frame, replace(LIGGGHTS, templates=(twin, spheres))), union)
    with pytest.raises(InputError, match="fit none of the templates"):
        rigid_bodies(shuffled, swarm.frame, replace(LIGGGHTS, templates=(twin,)))


def test_a_clump_is_not_its_mirror_image() -> None:
    """Law: a rotation never makes a clump its mirror image; each body gets the template that it is."""
    swarm = Swarm([CROOKED, MIRRORED, CROOKED])
    assert_law(swarm, rigid_bodies(swarm.whole, swarm.frame, replace(LIGGGHTS, templates=(MIRRORED, CROOKED))), union)
    with pytest.raises(InputError, match=r"body 20 has 4 spheres .* \(type 1 of 4 spheres, type 3 of 3 spheres\)"):
        rigid_bodies(swarm.whole, swarm.frame, replace(LIGGGHTS, templates=(CROOKED, ROD)))


def test_a_body_that_lacks_a_sphere() -> None:
    """Law: half a body has not half the energy: with templates it is refused, by number and count."""
    swarm = Swarm([CROOKED, CROOKED])
    there = swarm.whole
    gone = np.flatnonzero(there.body == 20)[2]
    fields = ("id", "mass", "radius", "omega", "x", "v", "body")
    fewer = replace(there, **{name: np.delete(getattr(there, name), gone, axis=0) for name in fields})
    with pytest.raises(InputError, match=r"body 20 has 3 spheres in this frame, which fit none of the templates \(type 1 of 4 spheres\)"):
        rigid_bodies(fewer, swarm.frame, replace(LIGGGHTS, templates=(CROOKED,)))


def test_a_template_of_another_size() -> None:
    """Law: a clump half as large again is another clump."""
    swarm = Swarm([CROOKED])
    larger = replace(CROOKED, centre=1.5 * CROOKED.centre, radius=1.5 * CROOKED.radius)
    with pytest.raises(InputError, match="fit none of the templates"):
        rigid_bodies(swarm.whole, swarm.frame, replace(LIGGGHTS, templates=(larger,)))


def test_six_digits() -> None:
    """Law: of a dump in %g the inertia is that of the template, so E is off by the digits of omega and mass alone: 5 numbers at 5e-6; without
    a template positions of 5 +- 5e-6 add twice their share of arms of 0.3: 1e-4."""
    swarm = Swarm([CROOKED, ROD, CROOKED, CROOKED])
    digits = np.vectorize(lambda value: float(f"{value:g}"))
    short = replace(swarm.whole, **{name: digits(getattr(swarm.whole, name)) for name in ("mass", "radius", "omega", "x", "v")})
    with_template = rigid_bodies(short, swarm.frame, replace(LIGGGHTS, templates=(CROOKED, ROD)))
    energy = swarm.law(union).energy
    assert_allclose(erotate_multisphere(with_template), energy, rtol=2.5e-5)
    assert_allclose(erotate_multisphere(rigid_bodies(short, swarm.frame, LIGGGHTS)), energy, rtol=1e-4)


def test_omega_from_velocities() -> None:
    """Law: v = V + omega × r at three points that are not in line tells omega."""
    swarm = Swarm([CROOKED, CROOKED])
    assert_law(swarm, rigid_bodies(replace(swarm.own, omega=None), swarm.frame, LAMMPS), sum_of_spheres)


@pytest.mark.parametrize("template", [ROD, PAIR, Template(np.zeros((1, 3)), np.ones(1), 1.0)])
def test_spin_that_velocities_do_not_tell(template: Template) -> None:
    """Law: points in one line move the same whatever the spin about it."""
    swarm = Swarm([template])
    with pytest.raises(InputError, match=r"body 10, which lie in one line, do not tell its spin.*omegax omegay omegaz"):
        rigid_bodies(replace(swarm.own, omega=None), swarm.frame, LAMMPS)


def test_points_do_not_carry_omega() -> None:
    """Law: LAMMPS gives the omega of a body to its spheres only; where some members are points the velocities tell it."""
    swarm = Swarm([CROOKED])
    point = np.isin(swarm.own.id, swarm.own.id[swarm.own.body > 0][:3])
    radius, omega = np.where(point, 0, swarm.own.radius), np.where(point[:, None], 0, swarm.own.omega)
    found = rigid_bodies(replace(swarm.own, radius=radius, omega=omega), swarm.frame, LAMMPS)
    assert_allclose(found.omega, swarm.omega, rtol=ROUNDING)
    with pytest.raises(InputError, match="body 10 has no radius above zero"):
        rigid_bodies(replace(swarm.own, radius=radius), swarm.frame, LAMMPS, "union")


def test_what_does_not_turn_as_one() -> None:
    """Law: a body has one angular velocity; molecules whose atoms turn each on its own are no bodies."""
    swarm = Swarm([CROOKED, CROOKED])
    rng = np.random.default_rng(2)
    with pytest.raises(InputError, match="body 10 turn at different angular velocities"):
        rigid_bodies(replace(swarm.own, omega=rng.normal(size=swarm.own.omega.shape)), swarm.frame, LAMMPS)


@pytest.mark.parametrize("omega", [True, False])
def test_what_does_not_move_as_one(omega: bool) -> None:
    """Law: v - omega × r is the same for all members; molecules whose atoms move each on its own are no bodies."""
    swarm = Swarm([CROOKED, CROOKED])
    moved = replace(swarm.own, v=np.random.default_rng(2).normal(size=swarm.own.v.shape))
    with pytest.raises(InputError, match="body 10 do not move as one"):
        rigid_bodies(moved if omega else replace(moved, omega=None), swarm.frame, LAMMPS)


def test_a_member_that_is_off_for_half_a_step() -> None:
    """Law: where another fix moves members too (LIGGGHTS, nve/sphere for all), those without contact still carry their body's motion;
    more than half of them say what it is."""
    swarm = Swarm([CROOKED, CROOKED])
    one = np.flatnonzero(swarm.whole.body == 20)[1]
    v, omega = swarm.whole.v.copy(), swarm.whole.omega.copy()
    v[one] += [0.0, 0.3, 0.0]
    omega[one] *= 1.1
    assert_law(swarm, rigid_bodies(replace(swarm.whole, v=v, omega=omega), swarm.frame, LIGGGHTS), union)
    two = np.flatnonzero(swarm.whole.body == 20)[2]
    omega[two] *= 0.8
    with pytest.raises(InputError, match=r"body 20 turn at different.*nve/sphere"):
        rigid_bodies(replace(swarm.whole, v=v, omega=omega), swarm.frame, LIGGGHTS)


def test_members_of_one_body_with_different_masses() -> None:
    """Law: in LIGGGHTS' dumps each member has the mass of the body; other masses are another convention, or another column."""
    swarm = Swarm([CROOKED])
    with pytest.raises(InputError, match="expected the same mass for all spheres of body 10, got"):
        rigid_bodies(swarm.own, swarm.frame, LIGGGHTS)


@pytest.mark.parametrize(
    ("without", "says"),
    [
        (("radius",), "needs the columns radius of"),
        (("x",), "needs the columns x y z of"),
        (("omega", "v"), "needs the columns omegax omegay omegaz of"),
        (("mass",), "needs the column mass "),
    ],
)
def test_missing_columns(without: tuple[str, ...], says: str) -> None:
    """Law: what is missing is named, and what there is."""
    swarm = Swarm([CROOKED])
    for meanings in (LIGGGHTS, LAMMPS):
        with pytest.raises(InputError, match=says):
            rigid_bodies(replace(swarm.whole, **dict.fromkeys(without)), frame(mass="mass" not in without), meanings)


def test_without_velocities_and_without_members() -> None:
    """Law: omega is enough for the energy of rotation; a frame in which nothing belongs to a body has no bodies."""
    swarm = Swarm([CROOKED])
    found = rigid_bodies(replace(swarm.whole, v=None), swarm.frame, LIGGGHTS)
    assert found.v is None
    assert_allclose(erotate_multisphere(found), swarm.law(union).energy, rtol=ROUNDING)
    none = rigid_bodies(replace(swarm.whole, body=np.zeros_like(swarm.whole.body)), swarm.frame, LIGGGHTS)
    assert len(none.id) == len(erotate_multisphere(none)) == 0


def test_the_slip_and_what_is_said_of_it() -> None:
    """Law: moments of the union pass, of any density; with I_yz averaged with I_xz they are the known defect; others are unknown."""
    exact = union(CROOKED.centre, CROOKED.radius).inertia
    slip = liggghts_slip(exact)
    assert_allclose(slip - slip.T, 0)
    assert slip[1, 2] == 0.5 * (exact[1, 2] + exact[0, 2])
    assert_array_equal(np.delete(slip.ravel(), [5, 7]), np.delete(exact.ravel(), [5, 7]))
    law, wrong = np.linalg.eigvalsh(exact), np.linalg.eigvalsh(slip)
    assert diagnose(7.0 * law[::-1], CROOKED) is None
    assert diagnose(np.array([law, law * [1.003, 1, 1]]), CROOKED) is None
    finding = diagnose(np.array([wrong, 2 * wrong[::-1]]), CROOKED)
    assert finding is not None
    assert f"{np.abs(wrong / law - 1).max():.1%}" in finding
    assert "known defect of LIGGGHTS 3.8.0 with clumps that are not symmetric about z = 0 of their file" in finding
    assert "another template?" in (diagnose(law * [1.2, 1, 1], CROOKED) or "")
    share = (wrong / wrong.sum()) / (law / law.sum())
    assert f"off by up to {np.abs(share - 1).max():.1%}" in (forecast(CROOKED) or "")


def test_a_mirror_plane_hides_the_slip() -> None:
    """Law: with a plane of symmetry z = 0 I_xz = I_yz = 0, and there is nothing to average."""
    flat = Template(CROOKED.centre * [1, 1, 0], CROOKED.radius)
    exact = union(flat.centre, flat.radius).inertia
    assert_allclose(liggghts_slip(exact), exact, atol=1e-15)
    assert diagnose(np.linalg.eigvalsh(exact), flat) is None
    assert forecast(flat) is None


def test_as_many_bodies_as_there_are() -> None:
    """Law: every body gets its own energy, also where bodies of several sizes come in turn."""
    kinds = [CROOKED, ROD, PAIR] * 100
    swarm = Swarm(kinds, seed=4)
    found = rigid_bodies(swarm.whole, swarm.frame, replace(LIGGGHTS, templates=(PAIR, ROD, CROOKED)))
    assert all(a < b for a, b in pairwise(found.id))
    assert_law(swarm, found, union)
