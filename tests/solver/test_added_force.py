"""Forces that are formulas: the loop equals the reference, errors are loud, the energy closes, other scenes know nothing of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from demsolver import AddForce, Box, Freeze, Gravity, Neighbor, NveSphere, Scene, SetForce, Simulation, Slab, Sleep, Unstable, Viscous, Wall
from demsolver.expression import COLUMNS, FUNCTIONS, Call, Column, Expression, Number, call, value
from demsolver.reference import added
from demsolver.specialise import features, source
from demsolver.stability import contact_limits
from demsolver.stability_contacts import contacts_of
from tests.support.scenes import law, spheres

NOTHING = Number(0.0)
BOX = Box(np.full(3, -10.0), np.full(3, 10.0), ("ff", "ff", "ff"))
rng = np.random.default_rng(5)


def of(function: str, *arguments: Expression | float | str) -> Call:
    """A call; numbers and names become what they stand for."""
    given = [Number(a) if isinstance(a, float) else Column(a) if isinstance(a, str) else a for a in arguments]
    return Call(function, tuple(given))


def every_function() -> Expression:
    """A sum over all functions of the table, each of numbers within its range and times another factor."""
    inside = of("/", of("atan", "vx"), 2.0)  # within -0.79 .. 0.79
    arguments = {"sqrt": [of("abs", "vy")], "ln": [of("abs", "vy")], "log": [of("abs", "vz")], "asin": [inside], "acos": [inside], "exp": [inside]}
    arguments |= {"/": [Column("vx"), of("+", of("abs", "vy"), 0.1)], "%": [Column("vx"), Number(0.3)], "^": [of("abs", "vx"), Number(0.687)]}
    total: Expression = Number(0.0)
    for k, (name, (count, _)) in enumerate(FUNCTIONS.items()):
        total = of("+", total, of("*", 1.0 + 0.37 * k, of(name, *arguments.get(name, [Column(c) for c in ("vx", "y", "vz")[:count]]))))
    return total


def gas(x: np.ndarray, v: np.ndarray, *forces: object, dt: float = 1e-3) -> Scene:
    """Spheres far apart under forces alone."""
    p = spheres(x, np.full(len(x), 0.01), v=v)
    return Scene(BOX, p, 1, dt, forces=forces, integrate=(NveSphere(),), neighbor=Neighbor(0.1))  # type: ignore[arg-type]


def test_the_loop_equals_the_reference() -> None:
    """Law: every function and every column gives in the loop what it gives in Python, to the last digits, in group members alone."""
    n = 60
    x, v = rng.uniform(-5, 5, (n, 3)), rng.normal(0, 1, (n, 3))
    columns: Expression = Number(0.0)
    for k, name in enumerate(COLUMNS):
        columns = of("+", columns, of("*", 0.5 + k, name))
    scene = gas(x, v, AddForce((every_function(), columns, of("negate", "vz")), bit=1), AddForce((Number(0.25), NOTHING, of("*", -2.0, "vz"))))
    scene = replace(scene, particles=replace(scene.particles, mask=1 + 2 * (np.arange(n) % 2)))
    simulation = Simulation(scene)
    simulation.setup()
    expected = added(scene, x, v)
    assert np.abs(simulation.bodies.force - expected).max() < 1e-14 * np.abs(expected).max()
    assert (simulation.bodies.force[::2] == np.array([[0.25, 0.0, 0.0]]) + [0, 0, -2.0] * v[::2]).all()


def test_forces_see_the_velocities_of_the_half_step() -> None:
    """Law: after a step from set-up F = f(v0 + dt/2m f(v0)), as in the engines."""
    dt = 0.01
    scene = gas(np.zeros((1, 3)), np.array([[2.0, 0.0, 0.0]]), AddForce((of("*", -0.003, of("*", "vx", of("abs", "vx"))), NOTHING, NOTHING)), dt=dt)
    simulation = Simulation(scene)
    simulation.setup()
    simulation.advance(1)
    half = 2.0 - 0.5 * dt / scene.particles.mass[0] * 0.003 * 4.0
    assert simulation.bodies.force[0, 0] == pytest.approx(-0.003 * half * half, rel=1e-14)


def test_it_stands_in_its_place_among_the_fields() -> None:
    """Law: fields act in the order of the scene: what is added before setforce is overruled, what comes after is not."""
    one = AddForce((Number(1.0), Number(1.0), Number(1.0)))
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    scene = gas(x, np.zeros((2, 3)), one, SetForce((5.0, None, None)), one, Freeze(1))
    simulation = Simulation(replace(scene, particles=replace(scene.particles, mask=np.array([1, 3]))))
    simulation.setup()
    assert simulation.bodies.force.tolist() == [[6.0, 2.0, 2.0], [0.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("formula", "found"),
    [
        (of("/", 1.0, "vx"), math.nan),
        (of("sqrt", -1.0), math.nan),
        (of("ln", "vx"), math.nan),
        (of("exp", 1e3), math.nan),
        (of("^", "vx", -1.0), math.nan),
        (of("/", 1.0, of("/", 1.0, "vx")), math.nan),
        (of("<", of("/", 1.0, "vx"), 1.0), math.nan),
        (of("!", of("asin", 2.0)), math.nan),
        (of("^", of("sqrt", -1.0), 0.0), math.nan),
        (of("ternary", of("sqrt", -1.0), 1.0, 2.0), math.nan),
        (of("ternary", of("!=", "vx", 0.0), of("/", 1.0, "vx"), 7.0), 7.0),
    ],
)
def test_no_value_is_never_hidden(formula: Expression, found: float) -> None:
    """Law: what has no finite value has none in all that is made of it, but for the branch that ternary leaves; the loop says so too."""
    assert value(formula, {"vx": 0.0}) == pytest.approx(found, nan_ok=True)
    if math.isnan(found) and formula.function not in ("/", "ternary", "<"):
        return  # one compiled loop for each: three stand for all
    simulation = Simulation(gas(np.zeros((1, 3)), np.zeros((1, 3)), AddForce((formula, NOTHING, NOTHING))))
    if math.isnan(found):
        with pytest.raises(Unstable, match="forces became infinite by step 0: the formula of an added force has no finite value"):
            simulation.setup()
    else:
        simulation.setup()
        assert simulation.bodies.force[0, 0] == found


def test_no_value_in_mid_run_ends_the_run() -> None:
    """Law: among spheres that touch, a formula that loses its value after some steps ends in Unstable."""
    x = np.array([[0.0, 0.0, 0.0], [0.0199, 0.0, 0.0], [0.0, 0.0, 0.5]])
    until = AddForce((of("sqrt", of("-", 0.01, "z")), NOTHING, Number(0.001)), bit=1)
    scene = gas(x, np.zeros((3, 3)), until)
    scene = replace(scene, pair=law((1, 1)), particles=replace(scene.particles, mask=np.array([3, 1, 1])))
    simulation = Simulation(scene)
    simulation.setup()
    with pytest.raises(Unstable, match="formula of an added force"):
        simulation.advance(2000)


def test_the_budget_counts_its_work() -> None:
    """Law: held less driven stays put, with the square of the step: a drag of the square of the velocity under gravity."""
    square = of("*", -0.002, of("*", "vz", of("abs", "vz")))
    drift = []
    for dt in (4e-3, 2e-3):
        scene = gas(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.5]]), Gravity((0.0, 0.0, -9.81)), AddForce((Number(1e-3), NOTHING, square)), dt=dt)
        simulation = Simulation(scene, budget=True)
        simulation.setup()
        start = simulation.energy_budget()
        simulation.advance(round(0.8 / dt))
        end = simulation.energy_budget()
        assert abs(end.driven) > 0.05 * start.kinetic
        drift.append(abs(end.total - start.total) / start.kinetic)
    assert drift[0] < 1e-3
    assert math.log2(drift[0] / drift[1]) == pytest.approx(2.0, abs=0.2)


def test_a_linear_drag_is_viscous_drag() -> None:
    """Law: -gamma v as a formula takes what Viscous takes, limits the step as it does, and gives the same motion."""
    gamma, v = 0.004, np.array([[1.0, -2.0, 0.5]])
    formula = AddForce(tuple(of("*", -gamma, name) for name in ("vx", "vy", "vz")))  # type: ignore[arg-type]
    ends = []
    for force in (formula, Viscous(np.array([gamma]))):
        scene = gas(np.zeros((1, 3)), v, force)
        simulation = Simulation(scene, budget=True)
        simulation.setup()
        simulation.advance(300)
        budget = simulation.energy_budget()
        (limit,) = contact_limits(scene, contacts_of(scene))
        ends.append((simulation.bodies.x, budget.dragged - budget.driven, limit.combined))
    assert ends[0][0] == pytest.approx(ends[1][0], rel=1e-14)
    assert ends[0][1] == pytest.approx(ends[1][1], rel=1e-13)
    assert ends[0][2] == pytest.approx(ends[1][2], rel=1e-6)


def test_a_trap_limits_the_step_as_a_spring() -> None:
    """Law: -k x has the limit 2 sqrt(m/k); a constant force has none."""
    scene = gas(np.full((1, 3), 0.1), np.zeros((1, 3)), AddForce((of("*", -300.0, "x"), NOTHING, NOTHING)), AddForce((Number(1.0), NOTHING, NOTHING)))
    (limit,) = contact_limits(scene, contacts_of(scene))
    assert limit.combined == pytest.approx(2.0 * math.sqrt(scene.particles.mass[0] / 300.0), rel=1e-6)


def test_who_rests_under_it_sleeps() -> None:
    """Law: a force of the particle's own state lets who rests fall asleep: a sphere that a constant force presses on a floor."""
    p = spheres(np.array([[0.0, 0.0, 0.00999]]), np.array([0.01]))
    floor = Wall("floor", Slab(2, lo=0.0), law((1,)))
    scene = Scene(
        BOX, p, 1, 1e-4, walls=(floor,), forces=(AddForce((NOTHING, NOTHING, Number(-0.1))),), integrate=(NveSphere(),), neighbor=Neighbor(0.01)
    )
    simulation = Simulation(scene, sleep=Sleep(1e-3))
    simulation.setup()
    simulation.advance(5000)
    assert simulation.asleep.all()
    assert 0.01 - simulation.bodies.x[0, 2] == pytest.approx(1e-5, rel=0.05)  # F/kn


def test_scenes_without_it_know_nothing_of_it() -> None:
    """Law: no line of a scene without an added force names one, and a component of zero is not in the loop either."""
    plain = gas(np.zeros((2, 3)), np.zeros((2, 3)), Gravity((0.0, 0.0, -9.81)))
    text = source(plain, features(plain)).partition("def field_forces")[2]
    assert "add(" not in text
    assert "expression" not in source(plain, features(plain))
    one = gas(np.zeros((2, 3)), np.zeros((2, 3)), AddForce((NOTHING, Number(2.0), NOTHING)))
    assert source(one, features(one)).partition("def field_forces")[2].count(" add(") == 1


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (Column("vq"), "column 'vq' is not one of x, y, z"),
        (of("cosh", 1.0), "function 'cosh' is not one of negate"),
        (of("+", 1.0), r"\+ takes 2 arguments, got 1"),
        (of("+", 1.0, math.inf), "a constant must be finite, got inf"),
    ],
)
def test_wrong_formulas_are_refused(wrong: Expression, message: str) -> None:
    """Law: a formula made by hand is checked before anything is compiled."""
    with pytest.raises(ValueError, match=message):
        Simulation(gas(np.zeros((1, 3)), np.zeros((1, 3)), AddForce((NOTHING, wrong, NOTHING))))


def test_functions_of_numbers() -> None:
    """Law: halves are rounded up, the remainder has the sign of the dividend, comparisons are 0 or 1."""
    assert [call("round", a) for a in (2.5, -2.5, -0.4)] == [3.0, -2.0, 0.0]
    assert [call("%", -3.0, 2.0), call("<", 1.0, 2.0), call("|^", 1.0, 2.0), call("sign", -0.1)] == [-1.0, 1.0, 0.0, -1.0]
