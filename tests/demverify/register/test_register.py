"""The register as data: each entry is shown by a test, malformed files are refused, a deck gets the entries that touch it."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from demverify.deck.setup import Atoms, DumpSpec, Setup, Spec
from demverify.errors import InputError, Place
from demverify.register import Features, applying, features_of, load
from tests.support import engines
from tests.support.deviations import assert_deviates, assert_nan

ROOT = Path(__file__).parents[3]
HERE = Place(Path("in.deck"), 7)
LEGACY = Features(
    pair_styles=frozenset({"gran/hooke/history"}), normal=frozenset({"hooke"}), damping=frozenset({"mass_velocity"}),
    tangential=frozenset({"history"}), friction=True,
)  # fmt: skip
GOOD = """[[entry]]
id = "a"
engine = "lammps"
version = "1"
what = "w"
size = "s"
how = "h"
link = "l"
kind = "defect"
applies = { wall_styles = ["hooke"], needs = ["friction"] }
"""


def names(dialect: str, features: Features, *engines: str) -> set[str]:
    """Ids of the entries that apply."""
    return {entry.id for entry in applying(dialect, features, engines)}  # type: ignore[arg-type]


def engine_tests() -> set[str]:
    """`file::function` of every test beside this file, this one left out."""
    files = sorted(path for path in Path(__file__).parent.glob("test_*.py") if path != Path(__file__))
    return {
        f"{path.relative_to(ROOT).as_posix()}::{node.name}"
        for path in files
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def test_every_entry_is_shown_by_a_test_and_every_test_shows_an_entry() -> None:
    """An entry without a test is hearsay; a test without an entry is a finding that no user hears of."""
    assert {entry.how for entry in load()} == engine_tests()


def test_entries_are_named_in_their_tests() -> None:
    """When an engine is mended, the failing test names the entry that must go."""
    sources = "".join(path.read_text() for path in Path(__file__).parent.glob("test_*.py"))
    unnamed = [entry.id for entry in load() if entry.id not in sources]
    assert not unnamed


def test_entries_carry_what_a_user_needs() -> None:
    """An id begins with its engine, the link is public, and the text is short."""
    for entry in load():
        assert entry.id.startswith(entry.engine + "-"), entry.id
        assert entry.link.startswith("https://"), entry.id
        assert entry.what.count(". ") <= 2 and len(entry.what) < 260, entry.id


def test_a_good_file_is_read(tmp_path: Path) -> None:
    """What is written is what is loaded."""
    (tmp_path / "r.toml").write_text(GOOD)
    (entry,) = load(tmp_path / "r.toml")
    assert (entry.id, entry.engine, entry.kind) == ("a", "lammps", "defect")
    assert entry.applies is not None
    assert entry.applies.lists == (("wall_styles", frozenset({"hooke"})),)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('engine = "lammps"', 'engine = "lamps"', "'lamps' is not one of lammps, liggghts, both"),
        ('kind = "defect"', 'kind = "bug"', "'bug' is not one of defect, convention, trap"),
        ('what = "w"\n', "", "what is missing"),
        ('what = "w"', 'what = ""', "what is missing"),
        ('what = "w"', "what = 3", "what is missing"),
        ('size = "s"', 'size = "s"\nsise = "s"', "key 'sise' is not one of"),
        ('needs = ["friction"]', 'needs = ["fricton"]', "'fricton' is not one of"),
        ('needs = ["friction"]', 'needs = "friction"', "must be a list of words"),
        ('needs = ["friction"]', "needs = []", "must be a list of words"),
        ("needs =", "need =", "key 'need' is not one of"),
        ('{ wall_styles = ["hooke"], needs = ["friction"] }', "{ }", "applies must be a table"),
        (GOOD, "", "no entries"),
        (GOOD, GOOD + GOOD, "two entries have the id 'a'"),
        ("[[entry]]", "[[entry", "no readable register"),
    ],
)
def test_malformed_files_are_refused(old: str, new: str, said: str, tmp_path: Path) -> None:
    """A misspelt word is an error in one line that names the file, never an entry that silently never applies."""
    (tmp_path / "r.toml").write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as error:
        load(tmp_path / "r.toml")
    assert said in str(error.value)
    assert "r.toml" in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_and_binary_files_are_refused(tmp_path: Path) -> None:
    """No file, and no text, are errors in one line too."""
    (tmp_path / "binary").write_bytes(bytes(range(128, 256)))
    for path in (tmp_path / "absent", tmp_path / "binary"):
        with pytest.raises(InputError, match="no readable register"):
            load(path)


def test_legacy_wall_gets_its_fault_only_with_friction() -> None:
    """An entry applies when all its conditions hold, and no sooner."""
    wall = replace(LEGACY, wall_styles=frozenset({"hooke/history"}))
    fault = "lammps-wall-hooke-history-kt"
    assert fault in names("lammps", wall, "native", "lammps")
    assert fault not in names("lammps", replace(wall, friction=False), "native", "lammps")
    assert fault not in names("lammps", LEGACY, "native", "lammps")
    assert fault not in names("lammps", replace(wall, wall_styles=frozenset({"granular"})), "native", "lammps")


def test_a_plain_deck_gets_no_entry() -> None:
    """Undamped, frictionless, wall-free spheres under full-precision dumps: nothing known lies between any two engines."""
    plain = Features(
        pair_styles=frozenset({"granular"}),
        normal=frozenset({"hooke"}),
        damping=frozenset({"none"}),
        tangential=frozenset({"off"}),
    )
    for dialect in ("lammps", "liggghts"):
        assert not names(dialect, plain, "native", "lammps", "liggghts", "law")
    assert not names("lammps", Features(), "lammps", "liggghts")


def test_a_convention_explains_only_engines_that_differ_in_it() -> None:
    """The native engine keeps the habits of the deck's dialect; an engine never differs from itself."""
    arm = "liggghts-contact-arm"
    assert arm in names("lammps", LEGACY, "lammps", "liggghts")
    assert arm in names("lammps", LEGACY, "native", "liggghts")
    assert arm not in names("lammps", LEGACY, "native", "lammps")
    assert arm not in names("liggghts", LEGACY, "native", "liggghts")
    assert arm not in names("liggghts", LEGACY, "liggghts", "liggghts")


def test_a_shared_habit_explains_a_closed_form_and_no_engine() -> None:
    """What both engines do alike is no difference between them, but one to the textbook."""
    habit = "both-attractive-tail"
    assert habit in names("lammps", LEGACY, "lammps", "law")
    assert habit not in names("lammps", LEGACY, "native", "lammps", "liggghts")


def test_unknown_engines_are_refused() -> None:
    """A misspelt engine is an error, not an empty answer."""
    with pytest.raises(InputError, match="'lamps' is not one of native, lammps, liggghts, law"):
        applying("lammps", LEGACY, ("native", "lamps"))


def lammps_setup(*fixes: Spec, pair: str = "granular", coeff: str = "") -> Setup:
    """A LAMMPS deck with one pair_coeff line and these fixes."""
    setup = Setup("lammps", pair_style=tuple(pair.split()))
    if coeff:
        setup.pair_coeffs.append((tuple(coeff.split()), HERE))
    setup.fixes = {fix.id: fix for fix in fixes}
    return setup


def fix(name: str, style: str, args: str = "") -> Spec:
    """A fix of group all."""
    return Spec(name, "all", style, tuple(args.split()), HERE)


def test_features_of_a_legacy_deck() -> None:
    """kn kt gamma_n gamma_t mu dampflag: the third number is damping, the fifth friction, for pair and wall alike."""
    setup = lammps_setup(
        fix("w", "wall/gran", "hooke/history 1e5 NULL 0.0 NULL 0.5 0 zcylinder 0.03"),
        fix("b", "freeze"),
        pair="gran/hertz/history 1e5 NULL 50 NULL 0 1 limit_damping",
        coeff="* *",
    )
    setup.dumps["d"] = DumpSpec("d", "all", "custom", 1, "f", ("id",), HERE)
    found = features_of(setup, runs=2)
    assert found == Features(
        pair_styles=frozenset({"gran/hertz/history"}),
        wall_styles=frozenset({"hooke/history"}),
        normal=frozenset({"hooke", "hertz"}),
        damping=frozenset({"none", "viscoelastic"}),
        tangential=frozenset({"history"}),
        switches=frozenset({"limit_damping"}),
        cylinders=frozenset({"z"}),
        fixes=frozenset({"wall/gran", "freeze"}),
        friction=True,
        tangential_damping=True,  # of the pairs, gamma_t = gamma_n / 2; the wall has dampflag 0
        frozen=True,
        undamped_wall=True,
        short_dumps=True,
        runs=2,
    )


@pytest.mark.parametrize(
    ("law", "damping", "tangential", "friction"),
    [
        ("hooke 1e5 50 tangential linear_history 1e4 0 0.5 damping mass_velocity", "mass_velocity", "history", True),
        ("hertz 1e5 50 tangential mindlin NULL 1.0 0.0", "viscoelastic", "history", False),
        ("hertz/material 1e7 0.5 0.3 tangential linear_nohistory 1.0 0.4 damping tsuji", "tsuji", "no_history", True),
        ("hooke 1e5 0 tangential linear_nohistory 1.0 0.0 limit_damping", "none", "no_history", False),
        ("hooke 1e5 50", "viscoelastic", "off", False),
    ],
)
def test_features_of_granular_laws(law: str, damping: str, tangential: str, friction: bool) -> None:
    """The friction coefficient is the last number of the tangential model, for pairs and for walls."""
    for setup in (
        lammps_setup(coeff=f"* * {law}"),
        lammps_setup(fix("w", "wall/gran", f"granular {law} zplane 0 NULL"), pair="none"),
    ):
        found = features_of(setup, runs=1)
        assert (found.damping, found.tangential, found.friction) == (frozenset({damping}), frozenset({tangential}), friction)


def test_rolling_and_twisting_models_are_features() -> None:
    """What resists turning is named, and touches entries on springs that change sign; models that are switched off are not there."""
    setup = lammps_setup(coeff="* * hooke 1e4 0 tangential linear_nohistory 0 0 rolling sds 1 0 0.1 twisting none")
    setup.fixes["w"] = fix("w", "wall/gran", "granular hooke 1e4 0 tangential linear_nohistory 0 0 twisting marshall zplane 0 NULL")
    found = features_of(setup, runs=1)
    assert (found.rolling, found.twisting) == ({"sds"}, {"marshall"})
    entry = "lammps-turning-springs-change-sign"
    assert entry in names("lammps", found, "native", "lammps")
    assert entry not in names("lammps", replace(found, rolling=frozenset(), twisting=frozenset()), "native", "lammps")


STYLE = "gran model hooke tangential history cohesion off rolling_friction epsd limitForce on viscous off"


def test_features_of_a_liggghts_deck() -> None:
    """Model, tangential and switches stand in the style; friction is a property."""
    setup = Setup("liggghts", dimension=2, pair_style=tuple(STYLE.split()))
    wall = fix("w", "wall/gran", "model hertz/stiffness primitive type 1 ycylinder 0.1 0 0")
    integrator = fix("n", "nve/sphere")
    setup.fixes = {"w": wall, "n": integrator}
    frictionless = features_of(setup, runs=1)
    setup.fixes["m"] = fix("m", "property/global", "coefficientFriction peratomtypepair 2 0 0 0 0.5")
    setup.fixes["e"] = fix("e", "property/global", "coefficientRestitution peratomtypepair 2 1 1 1 1")
    elastic = features_of(setup, runs=1)
    setup.fixes["e"] = fix("e", "property/global", "coefficientRestitution peratomtypepair 2 1 0.5 0.5 1")
    found = features_of(setup, runs=1)
    assert (frictionless.friction, found.friction) == (False, True)
    assert (elastic.tangential_damping, found.tangential_damping) == (False, True)
    assert found.normal == {"hooke", "hertz/stiffness"}
    assert found.tangential == {"history", "off"}
    assert found.rolling == {"epsd"}
    assert found.switches == {"limit_damping"}
    assert found.cylinders == {"y"}
    assert found.discs
    assert {"liggghts-ycylinder-order", "liggghts-damping-outside-coulomb"} <= names(
        "liggghts", found, "native", "lammps", "liggghts"
    )


def test_one_particle_and_its_thermo_ke() -> None:
    """thermo ke is wrong for one particle in LAMMPS, and right for two."""

    def entries(count: int) -> set[str]:
        vectors, numbers = np.zeros((count, 3)), np.ones(count)
        ids = np.arange(1, count + 1)
        images = np.zeros((count, 3), dtype=np.int64)
        setup = lammps_setup(pair="none")
        setup.atoms = Atoms(ids, ids, vectors, vectors, vectors, numbers, numbers, ids, images, ids)
        setup.thermo.columns = ("step", "ke")
        return names("lammps", features_of(setup, runs=1), "native", "lammps")

    assert "lammps-thermo-ke-one-particle" in entries(1)
    assert "lammps-thermo-ke-one-particle" not in entries(2)


def test_an_empty_deck_has_no_features() -> None:
    """A deck that built nothing uses nothing."""
    assert features_of(Setup("lammps"), runs=0) == Features(runs=0)


def test_a_mended_engine_fails_its_test_by_name() -> None:
    """The register goes stale loudly: an engine that follows the law fails, and so does a test that could not tell."""
    assert_deviates("x-y", [2.0, 2.0], engine_rule=[2.0, 2.0], law=[1.0, 2.0], rtol=1e-3)
    with pytest.raises(AssertionError, match="register entry x-y is out of date"):
        assert_deviates("x-y", [1.0, 2.0], engine_rule=[2.0, 2.0], law=[1.0, 2.0], rtol=1e-3)
    with pytest.raises(AssertionError, match="x-y is out of date"):
        assert_deviates("x-y", np.nan, engine_rule=2.0, law=1.0, rtol=1e-3)
    with pytest.raises(AssertionError, match="cannot tell"):
        assert_deviates("x-y", 2.0, engine_rule=2.0, law=2.001, rtol=1e-3)
    with pytest.raises(AssertionError, match="x-y is out of date"):
        assert_nan("x-y", [np.nan, 1.0])


@pytest.mark.parametrize(("ci", "outcome"), [("", pytest.skip.Exception), ("true", pytest.fail.Exception)])
def test_a_missing_engine_skips_but_fails_in_ci(
    ci: str, outcome: type[BaseException], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A skipped engine is a convenience at a desk and a failure in CI."""
    monkeypatch.setenv("CI", ci)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(engines, "LMP", tmp_path / "lmp")
    for require in (engines.require_lammps, engines.require_liggghts):
        with pytest.raises(outcome):
            require()


@pytest.mark.parametrize(("wall", "both"), [("zplane 0.0 0.1", True), ("zplane 0.0 NULL", False), ("zplane NULL 0.1", False)])
def test_two_planes_of_one_fix(wall: str, both: bool) -> None:
    """Law: the entry on the nearer plane is for walls of two planes alone."""
    from demverify.register import _two_planes

    assert _two_planes(tuple(f"granular hooke 1e4 0.0 damping velocity {wall}".split())) is both
    assert not _two_planes(("model", "hooke", "primitive", "type", "1", "zplane", "0.0", "shear", "x"))


@pytest.mark.parametrize(
    ("wall", "axis", "turns"),
    [
        ("xcylinder 1 0 0 shear y 2", "x", True),
        ("zcylinder 1 0 0 shear z 2", "z", False),
        ("zcylinder 1 0 0", "z", False),
        ("zplane 0 shear x 1", "", False),
    ],
)
def test_cylinders_that_turn(wall: str, axis: str, turns: bool) -> None:
    """Law: shear across the axis turns a cylinder, shear along it and that of a plane does not."""
    setup = Setup("liggghts")
    setup.fixes["w"] = Spec("w", "all", "wall/gran", ("model", "hooke", "primitive", "type", "1", *wall.split()), Place(Path("in.case"), 1))
    found = features_of(setup, runs=1)
    assert (found.cylinders, found.turning) == (frozenset({axis} - {""}), turns)


@pytest.mark.parametrize(("dialect", "styles", "late"), [
    ("lammps", "gravity rigid/small", False), ("lammps", "rigid/small gravity", True), ("lammps", "gravity rigid/nve/small addforce", True),
    ("lammps", "rigid nve/sphere", False), ("lammps", "nve/sphere gravity", False),
    ("liggghts", "wall/gran multisphere gravity", False), ("liggghts", "multisphere wall/gran", True), ("liggghts", "multisphere addforce", True),
])  # fmt: skip
def test_forces_that_the_set_up_misses(dialect: Literal["lammps", "liggghts"], styles: str, late: bool) -> None:
    """The order of fixes counts where clumps are; LIGGGHTS' weight is an exception."""
    setup = Setup(dialect, fixes={style: fix(style, style) for style in styles.split()})
    assert features_of(setup, runs=1).late_forces is late
