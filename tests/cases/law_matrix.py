"""Every contact law that the native solver shares with an engine, as a deck on 1,000 spheres of two materials.

States: "bed" is periodic in x and y above a floor; "silo" stands in a cylinder of radius 0.05 m on a floor. The numbers keep the
overlaps near those of the state, which was settled with 1e4 N/m (some 1e-5 m, contact radius 2e-4 m), and a contact 60 steps.
LAMMPS' walls are of style `granular`, for its older wall styles are faulty (see the register).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Literal

from demverify.deck.setup import Dialect

State = Literal["bed", "silo"]
STATES: tuple[State, ...] = ("bed", "silo")
STEPS = 200
DATA = Path(__file__).parents[2] / "inputs" / "bed"
BOUNDARY = {"bed": "p p f", "silo": "f f f"}
HEAD: dict[Dialect, str] = {
    "lammps": "atom_style sphere\ncomm_modify vel yes",
    "liggghts": "atom_style granular\natom_modify map array\ncommunicate single vel yes",
}
SHAPES: dict[tuple[Dialect, State], tuple[str, ...]] = {
    ("lammps", "bed"): ("zplane 0.0 NULL",),
    ("lammps", "silo"): ("zplane 0.0 NULL", "zcylinder 0.05"),
    ("liggghts", "bed"): ("primitive type 2 zplane 0.0",),
    ("liggghts", "silo"): ("primitive type 2 zplane 0.0", "primitive type 1 zcylinder 0.05 0.0 0.0"),
}


@dataclass(frozen=True)
class Law:
    """A contact law of one dialect. style: the row of the table it belongs to. options: its other words, each with its value.

    lines: material and pairs. wall: what stands before and behind the shape in `fix wall/gran`.
    """

    dialect: Dialect
    style: str
    options: tuple[str, ...]
    lines: tuple[str, ...]
    wall: tuple[str, str]

    @property
    def name(self) -> str:
        """Style and options."""
        return " ".join((self.dialect, self.style, *self.options))

    @property
    def chatters(self) -> bool:
        """Whether spins at rest turn round at every step, so that rounding grows to the size of the torques."""
        return self.style.endswith(ROLLING[0])

    @property
    def turns_round(self) -> bool:
        """Whether LAMMPS turns springs round when a pair crosses a periodic face and the list is renewed (see the register)."""
        return bool(set(RESISTANCE) & set(self.options))


def deck(law: Law, state: State, steps: int = STEPS) -> str:
    """The deck of a law on a state; a short skin, so that the list is rebuilt on the way, unless the engine then errs."""
    before, behind = law.wall
    shapes = SHAPES[law.dialect, state]
    walls = [f"fix w{k} all wall/gran {before} {shape} {behind}".rstrip() for k, shape in enumerate(shapes)]
    lines = (
        "units si",
        HEAD[law.dialect],
        f"boundary {BOUNDARY[state]}",
        "newton off",
        f"read_data {DATA / state}.data",
        f"neighbor {1e-3 if law.turns_round and state == 'bed' else 1e-4} bin",
        "neigh_modify delay 0",
        *law.lines,
        *walls,
        "fix g all gravity 9.81 vector 0 0 -1",
        "fix n all nve/sphere",
        "timestep 1e-5",
        f"thermo {steps}",
        f"run {steps}",
    )
    return "\n".join(lines) + "\n"


# LAMMPS -------------------------------------------------------------------------------------------------------------------

CLASSIC = {  # pair style -> kn kt gamma_n gamma_t; the wall's words, with kt and gamma_t/gamma_n
    "gran/hooke": ("1e4 NULL 400 NULL", "granular hooke 1e4 400 damping mass_velocity tangential linear_nohistory {xt} 0.2"),
    "gran/hooke/history": (
        "1e4 3e3 400 NULL",
        "granular hooke 1e4 400 damping mass_velocity tangential linear_history 3e3 {xt} 0.2",
    ),
    "gran/hertz/history": ("4e7 3e7 2e6 NULL", "granular hertz 4e7 2e6 damping viscoelastic tangential mindlin 3e7 {xt} 0.2"),
}
NORMAL = {  # word -> numbers of type 1 and of type 2 around the damping number
    "hooke": ("1e4 {}", "2e4 {}"),
    "hertz": ("4e7 {}", "8e7 {}"),
    "hertz/material": ("5e7 {} 0.3", "1.2e8 {} 0.22"),
}
DAMPING = {
    "velocity": ("0.4", "0.6"),
    "mass_velocity": ("400", "600"),
    "viscoelastic": ("2e6", "3e6"),
    "tsuji": ("0.5", "0.7"),
    "coeff_restitution": ("0.5", "0.7"),
}
TANGENTIAL = {
    "linear_nohistory": ("0.5 0.2", "0.7 0.3"),
    "linear_history": ("3e3 0.5 0.2", "5e3 0.7 0.3"),
    "mindlin": ("3e7 0.5 0.2", "5e7 0.7 0.3"),
    "mindlin NULL": ("0.5 0.2", "0.7 0.3"),
}
LIMIT = {"limit_damping": "limit_damping", "unlimited": ""}


def classic(style: str, dampflag: int, limit: str) -> Law:
    """A gran/* style, one material for all types."""
    numbers, wall = CLASSIC[style]
    pair = f"pair_style {style} {numbers} 0.2 {dampflag} {LIMIT[limit]}".rstrip()
    wall = f"{wall.format(xt=0.5 * dampflag)} {LIMIT[limit]}".rstrip()
    return Law("lammps", style, (f"dampflag {dampflag}", limit), (pair, "pair_coeff * *"), (wall, ""))


def granular(normal: str, damping: str, tangential: str, limit: str) -> Law:
    """Coefficients of both types; those between them are mixed by either side; walls with the numbers of type 1."""
    models = [
        f"granular {numbers.format(eta)} damping {damping} tangential {tangential} {rubbing} {LIMIT[limit]}".rstrip()
        for numbers, eta, rubbing in zip(NORMAL[normal], DAMPING[damping], TANGENTIAL[tangential], strict=True)
    ]
    models = [model.replace("granular", normal, 1) for model in models]
    pairs = [f"pair_coeff {k} {k} {model}" for k, model in enumerate(models, start=1)]
    options = (f"damping {damping}", f"tangential {tangential}", limit)
    return Law("lammps", f"granular {normal}", options, ("pair_style granular", *pairs), (f"granular {models[0]}", ""))


COHESIVE = {"jkr": ("5e7 {} 0.3 0.5", "1.2e8 {} 0.22 2.0"), "dmt": ("5e7 {} 0.3 0.5", "1.2e8 {} 0.22 2.0")}
PULLED = {word: DAMPING[word] for word in ("velocity", "mass_velocity", "viscoelastic")}  # damping that goes with cohesion
VARIANTS = {
    f"{word}{null}": ("0.5 0.2", "0.7 0.3") if null else TANGENTIAL["mindlin"]
    for word, null in product(("mindlin/force", "mindlin_rescale", "mindlin_rescale/force"), ("", " NULL"))
}
RESISTANCE = {
    "rolling sds": ("2e3 0.2 0.1", "4e3 0.1 0.2"),
    "twisting marshall": ("", ""),
    "twisting sds": ("1e-3 1e-6 1e-4", "2e-3 2e-6 2e-4"),
}
RESISTANCES = (*((word,) for word in RESISTANCE), ("rolling sds", "twisting marshall"), ("rolling sds", "twisting sds"))


def extended(style: str, normal: str, damping: str, tangential: str, extra: Sequence[str] = (), limit: str = "unlimited") -> Law:
    """A granular law of one of the later sub-models, in a row of its own; numbers as in `granular`. extra: words of RESISTANCE."""
    numbers, rubbing = (NORMAL | COHESIVE)[normal], (TANGENTIAL | VARIANTS)[tangential]
    models = []
    for k in (0, 1):
        words = f"{normal} {numbers[k].format(DAMPING[damping][k])} damping {damping} tangential {tangential} {rubbing[k]}"
        models.append(" ".join((words, *(f"{word} {RESISTANCE[word][k]}" for word in extra), LIMIT[limit])).rstrip())
    pairs = [f"pair_coeff {k} {k} {model}" for k, model in enumerate(models, start=1)]
    word, *null = tangential.split()
    options = (f"normal {normal}", f"damping {damping}", f"tangential {word}", f"kt {' '.join(null) or 'given'}", *extra, limit)
    return Law("lammps", f"granular {style}", options, ("pair_style granular", *pairs), (f"granular {models[0]}", ""))


def extended_laws() -> list[Law]:
    """Cohesion with every damping it goes with, the variants of Mindlin's spring, and what resists rolling and twisting beside every kind of
    spring."""
    cohesive = product(COHESIVE, PULLED, ("linear_nohistory", "linear_history", "mindlin NULL"))
    springs = product(("hertz/material",), ("viscoelastic",), VARIANTS, ((),), LIMIT)
    pulled = product(("jkr",), ("viscoelastic",), [word for word in VARIANTS if "NULL" in word])
    beside = (("hooke", "linear_history"), ("hertz/material", "mindlin NULL"), ("jkr", "mindlin NULL"), ("dmt", "linear_nohistory"))
    return [
        *(extended("cohesive", *c) for c in cohesive),
        *(extended("mindlin variants", *c) for c in (*springs, *pulled)),
        *(extended("rolling, twisting", normal, "viscoelastic", tangential, extra) for (normal, tangential), extra in product(beside, RESISTANCES)),
    ]


def lammps_laws() -> list[Law]:
    """All combinations that LAMMPS allows: kt NULL needs the constants of a material."""
    allowed = [c for c in product(NORMAL, DAMPING, TANGENTIAL, LIMIT) if c[0] == "hertz/material" or "NULL" not in c[2]]
    return [*(classic(*c) for c in product(CLASSIC, (0, 1), LIMIT)), *(granular(*c) for c in allowed), *extended_laws()]


# LIGGGHTS -----------------------------------------------------------------------------------------------------------------

PROPERTIES = {
    "youngsModulus": "peratomtype 5e7 1.2e8",
    "poissonsRatio": "peratomtype 0.3 0.22",
    "coefficientRestitution": "peratomtypepair 2 0.6 0.5 0.5 0.8",
    "coefficientFriction": "peratomtypepair 2 0.2 0.3 0.3 0.4",
    "characteristicVelocity": "scalar 0.1",
    "kn": "peratomtypepair 2 1e4 2e4 2e4 1.5e4",
    "kt": "peratomtypepair 2 3e3 5e3 5e3 4e3",
    "gamman": "peratomtypepair 2 400 500 500 600",
    "gammat": "peratomtypepair 2 200 100 100 300",
    "gamman_abs": "peratomtypepair 2 0.4 0.5 0.5 0.6",
    "gammat_abs": "peratomtypepair 2 0.2 0.3 0.3 0.4",
    "FluidViscosity": "peratomtypepair 2 1e-3 2e-3 2e-3 3e-3",
    "MaximumRestitution": "peratomtypepair 2 0.9 0.8 0.8 0.7",
    "CriticalStokes": "peratomtypepair 2 10 12 12 14",
}
PER_RADIUS = {  # for hertz/stiffness, where the contact radius multiplies
    "kn": "peratomtypepair 2 4e7 8e7 8e7 6e7",
    "kt": "peratomtypepair 2 3e7 5e7 5e7 4e7",
    "gamman": "peratomtypepair 2 2e6 3e6 3e6 4e6",
    "gammat": "peratomtypepair 2 1e6 5e5 5e5 2e6",
}
TURNING = {  # for rolling friction and cohesion; the attraction of a contact is a quarter of its spring force
    "coefficientRollingFriction": "peratomtypepair 2 0.1 0.2 0.2 0.3",
    "coefficientRollingViscousDamping": "peratomtypepair 2 0.3 0.4 0.4 0.5",
    "cohesionEnergyDensity": "peratomtypepair 2 3e5 4e5 4e5 5e5",
}
ALWAYS = ("limitForce",)
RUBBING = ("tangential_damping",)
OWN = {"hooke": ("viscous",), "hertz": (), "hooke/stiffness": ("absolute_damping",), "hertz/stiffness": ()}
SPRING = {"hooke": ("ktToKnUser",)}


def switches(model: str, tangential: str) -> tuple[str, ...]:
    """The switches that change anything: without friction none of the tangential ones does, without a spring not that of kt."""
    rubbing = RUBBING if tangential != "off" else ()
    spring = SPRING.get(model, ()) if tangential == "history" else ()
    return (*ALWAYS, *OWN[model], *rubbing, *spring)


def gran(model: str, tangential: str, states: Sequence[str]) -> Law:
    """A LIGGGHTS model with every switch given its state."""
    values = PROPERTIES | (PER_RADIUS if model == "hertz/stiffness" else {})
    fixes = [f"fix m{k} all property/global {name} {words}" for k, (name, words) in enumerate(values.items())]
    settings = tuple(f"{name} {state}" for name, state in zip(switches(model, tangential), states, strict=True))
    words = f"model {model} tangential {tangential}"
    pair = " ".join(("pair_style gran", words, *settings))
    options = (f"tangential {tangential}", *settings)
    return Law("liggghts", model, options, (*fixes, pair, "pair_coeff * *"), (words, " ".join(settings)))


ROLLING = ("rolling_friction cdt", "rolling_friction epsd", "rolling_friction epsd2")
SJKR = "cohesion sjkr"


def turning(model: str, tangential: str, parts: Sequence[str], settings: Sequence[str]) -> Law:
    """A LIGGGHTS model with rolling friction, cohesion or both; the switches of its other parts as they are by default."""
    values = PROPERTIES | (PER_RADIUS if model == "hertz/stiffness" else {}) | TURNING
    fixes = [f"fix m{k} all property/global {name} {words}" for k, (name, words) in enumerate(values.items())]
    words = " ".join((f"model {model} tangential {tangential}", *parts))
    pair = " ".join(("pair_style gran", words, *settings))
    options = (f"model {model}", f"tangential {tangential}", *settings)
    return Law("liggghts", " ".join(parts), options, (*fixes, pair, "pair_coeff * *"), (words, " ".join(settings)))


def turning_laws() -> list[Law]:
    """All models with history, each with rolling friction and with cohesion and their switches in every state (limitForce does not reach
    cdt, so it is on there), then with both; and without history or friction, switches on."""
    found = []
    for model in OWN:
        for part, switch in ((SJKR, "tangential_reduce"), *((rolling, "torsionTorque") for rolling in ROLLING)):
            limits = ("on",) if part == ROLLING[0] else ("off", "on")
            states = [(f"limitForce {limit}", f"{switch} {state}") for limit in limits for state in ("off", "on")]
            found += [turning(model, tangential, (part,), states[-1]) for tangential in (("off", "no_history") if part == SJKR else ("off",))]
            found += [turning(model, "history", (part,), settings) for settings in states]
        found += [turning(model, "history", (SJKR, part), ("limitForce on", "tangential_reduce on", "torsionTorque off")) for part in ROLLING]
    return found


def liggghts_laws() -> list[Law]:
    """All models, tangential models and switches."""
    plain = [
        gran(model, tangential, states)
        for model, tangential in product(OWN, ("off", "no_history", "history"))
        for states in product(("off", "on"), repeat=len(switches(model, tangential)))
    ]
    return plain + turning_laws()


LAWS = {law.name: law for law in (*lammps_laws(), *liggghts_laws())}
CYLINDERS = (  # the laws whose walls feel the curvature, or do not
    "lammps granular hertz/material damping tsuji tangential mindlin NULL limit_damping",
    "liggghts hertz tangential history limitForce off tangential_damping on",
    "lammps granular rolling, twisting normal hertz/material damping viscoelastic tangential mindlin kt NULL rolling sds twisting marshall unlimited",
)


def values(law: Law) -> set[tuple[str, ...]]:
    """What a law exercises: its style, and the value of each of its options."""
    return {(law.dialect, law.style), *((law.dialect, option) for option in law.options)}


def values_by_style(law: Law) -> set[tuple[str, ...]]:
    """What a law exercises: the value of each of its options together with its style."""
    return {(law.dialect, law.style, option) for option in law.options}


def selection(laws: Iterable[Law], exercised: Callable[[Law], set[tuple[str, ...]]]) -> list[Law]:
    """A few laws that exercise all that the many do: again and again the one that adds most; of equals the last, with most on."""
    left = list(laws)[::-1]
    wanted, chosen = set[tuple[str, ...]]().union(*map(exercised, left)), list[Law]()
    while wanted:
        chosen.append(max(left, key=lambda law: len(exercised(law) & wanted)))
        wanted -= exercised(chosen[-1])
    return chosen


def quick_jobs() -> list[tuple[str, State]]:
    """What CI runs: every value of every option once on the bed, and both kinds of cylinder."""
    bed = [(law.name, STATES[0]) for law in selection(LAWS.values(), values)]
    return [*bed, *((name, STATES[1]) for name in CYLINDERS)]


def full_jobs() -> list[tuple[str, State]]:
    """All laws on the bed; in the silo every value of every option with every style, but jkr, which LAMMPS cuts off inside a cylinder
    (see the register)."""
    held = (law for law in LAWS.values() if "normal jkr" not in law.options)
    silo = {law.name for law in selection(held, values_by_style)} | set(CYLINDERS)
    return [(name, state) for state in STATES for name in LAWS if state == "bed" or name in silo]
