"""Plants defects in a copy of the native solver and asks the library to find them: `python benchmarks/mutations.py [NAME ...] [--quick]`.

Each mutation changes one place in the solver's source. The cases named beside it run in native alone, so that only closed forms can tell (column
"closed form"), and then with the engines as well ("engines"). Exit status 0: every defect was found. --quick: three of them, against closed forms.
10 minutes; every mutation compiles its loops anew.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Mutation:
    """A defect: in `file`, `old` becomes `new`, once. cases: of the library, that should find it. form: whether a closed form must."""

    what: str
    file: str
    old: str
    new: str
    cases: tuple[str, ...]
    form: bool = True


MUTATIONS: dict[str, Mutation] = {
    "pair-torque-sign": Mutation(
        "the torque of friction between spheres has the wrong sign", "kernel_contact.py",
        "gx, gy, gz, hx, hy, hz = -aa * cx, -aa * cy, -aa * cz, -ao * cx, -ao * cy, -ao * cz",
        "gx, gy, gz, hx, hy, hz = aa * cx, aa * cy, aa * cz, ao * cx, ao * cy, ao * cz", ("oblique-pair:E1e09-e1.0-1",),
    ),
    "wall-torque-sign": Mutation(
        "the torque of friction at a wall has the wrong sign", "kernel_wall.py",
        "qx, qy, qz = -arm * (ny * fz - nz * fy), -arm * (nz * fx - nx * fz), -arm * (nx * fy - ny * fx)",
        "qx, qy, qz = arm * (ny * fz - nz * fy), arm * (nz * fx - nx * fz), arm * (nx * fy - ny * fx)", ("slip-to-roll",),
    ),
    "damping-factor": Mutation(
        "the dashpot that goes with the mass is twice too strong", "contact/damping_fraction.py",
        "return damping_fraction * sqrt(meff * stiffness)", "return 2.0 * damping_fraction * sqrt(meff * stiffness)", ("wall-normal",),
    ),
    "history-not-turned": Mutation(
        "the tangential spring does not turn with the contact", "contact/friction_rotated_history.py",
        "if abs(along) * kt > 1e-10 * limit:", "if False:", ("collision-copies:moved", "cluster-collision"),
        form=False,
    ),
    "reduced-mass": Mutation(
        "the mass of a contact is that of one particle", "kernel_contact.py", "equal[1] * equal[1] / (equal[1] + equal[1])", "equal[1]",
        ("head-on-hooke:legacy-e0.5",),
    ),
    "reduced-mass-unequal": Mutation(
        "the reduced mass of unequal spheres is the mean of their masses", "kernel_contact.py", "meff = ma * mo / (ma + mo)\n        if FROZEN",
        "meff = 0.25 * (ma + mo)\n        if FROZEN", ("head-on-unequal:hooke-radius2-e0.8",),
    ),
    "wall-velocity": Mutation(
        "a wall's velocity is ignored", "kernel_wall.py", "vx, vy, vz = b.v[i, 0] - wvx, b.v[i, 1] - wvy, b.v[i, 2] - wvz",
        "vx, vy, vz = b.v[i, 0], b.v[i, 1], b.v[i, 2]", ("conveyor:belt-from-rest",),
    ),
    "spin-in-slip": Mutation(
        "spin counts with the wrong sign in the velocity of the surface", "kernel_wall.py",
        "tx = vx - vn * nx - arm * (w[i, 1] * nz - w[i, 2] * ny)", "tx = vx - vn * nx + arm * (w[i, 1] * nz - w[i, 2] * ny)", ("slip-to-roll",),
    ),
    "coulomb-limit": Mutation(
        "friction may be twice what Coulomb allows", "contact/friction_rotated_history.py", "limit = mu * critical_force",
        "limit = 2.0 * mu * critical_force", ("wall-oblique",),
    ),
    "hertz-factor": Mutation(
        "Hertz' force is 1 % too strong", "contact/normal_hertz.py", "return kn * contact_radius * overlap\n",
        "return 1.01 * kn * contact_radius * overlap\n", ("head-on-hertz",),
    ),
    "half-kick": Mutation(
        "the second half of the kick is 1 % too weak", "kernel_motion.py", "flat.v[e] = flat.v[e] + g + again * g",
        "flat.v[e] = flat.v[e] + g + 0.99 * again * g", ("free-flight:down",),
    ),
    "reaction": Mutation(
        "what acts on the other sphere is 0.1 % too weak", "kernel_contact.py", "b.force[o, 0] -= lanes[PX + u]",
        "b.force[o, 0] -= 0.999 * lanes[PX + u]", ("head-on-hooke:legacy-e0.5",),
    ),
    "image-shift": Mutation(
        "a neighbour behind a periodic face is looked for on the wrong side", "kernel_contact.py", "x[a, 0] - (x[o, 0] + shifts[s, 0])",
        "x[a, 0] - (x[o, 0] - shifts[s, 0])", ("collision-copies:across-x",),
    ),
    "rolling-limit": Mutation(
        "rolling resistance is half of what it should be", "contact/rolling_sds.py", "limit = rolling_friction * critical_force",
        "limit = 0.5 * rolling_friction * critical_force", ("rolling-decay-sds:mu0.1",),
    ),
    "wall-rotation": Mutation(
        "a turning wall has the velocity of its points at the sphere's centre, not at its surface", "bind_walls.py",
        'if shape.rotation.at == "surface" else ""', 'if False else ""', ("cylinder-swing:turning",),
    ),
    "memory-lost": Mutation(
        "a renewed neighbour list forgets the springs", "neighbor_rows.py", "if turned else memory[k, c]", "if turned else 0.0",
        ("chute",), form=False,
    ),
}  # fmt: skip
QUICK = ("wall-torque-sign", "reduced-mass", "coulomb-limit")


def found_by(name: str, mutation: Mutation, engines: Sequence[str], scratch: Path) -> list[str]:
    """Cells of the library that fail with this defect planted."""
    solver = scratch / name / "solver"
    if not solver.exists():
        shutil.copytree(ROOT / "solver", solver, ignore=shutil.ignore_patterns("__pycache__"))
        file = solver / "demsolver" / mutation.file
        text = file.read_text()
        if text.count(mutation.old) != 1:
            sys.exit(f"{name}: {mutation.file} has {text.count(mutation.old)} times what is to be changed, expected once")
        file.write_text(text.replace(mutation.old, mutation.new))
    environment = {**os.environ, "PYTHONPATH": f"{solver}:{ROOT}", "XDG_CACHE_HOME": f"{scratch / name / 'cache'}", "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("NUMBA_CACHE_DIR", None)
    out = scratch / name / "-".join(engines or ("all",))
    words = [*mutation.cases, "--out", f"{out}", "--json", f"{out}.json"]
    words += [word for engine in engines for word in ("--engines", engine)]
    command = [sys.executable, "-m", "demverify.cli", "verify", *words]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, cwd=ROOT)
    if done.returncode not in (0, 1):
        sys.exit(f"{name}: the library did not run: {done.stderr.strip()}")
    results = json.loads(Path(f"{out}.json").read_text())
    return [f"{one['name']}: {cell['reason']}" for one in results for cell in one["cells"].values() if cell["status"] == "fail"]


def main(words: Sequence[str]) -> int:
    """Runs and prints; 1 when a defect was not found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(MUTATIONS)}")
    parser.add_argument("--quick", action="store_true", help="three of them, against closed forms only")
    options = parser.parse_args(words)
    if unknown := [name for name in options.names if name not in MUTATIONS]:
        parser.error(f"there is no mutation {unknown[0]!r}; there are {', '.join(MUTATIONS)}")
    names = options.names or (QUICK if options.quick else MUTATIONS)
    table, missed, console = Table("defect", "closed form", "engines", "first found by"), 0, Console(width=150)
    with tempfile.TemporaryDirectory() as scratch:
        for name in names:
            mutation = MUTATIONS[name]
            alone = found_by(name, mutation, ("native",), Path(scratch))
            beside = [] if options.quick else found_by(name, mutation, (), Path(scratch))
            good = bool(alone) if mutation.form else bool(beside)
            missed += not good
            first = " ".join((alone or beside or ["NOT FOUND"])[0].split())[:220]
            table.add_row(f"{name}: {mutation.what}", _told(alone), "" if options.quick else _told(beside), first)
            print(f"{name}: {'found' if good else 'NOT FOUND'}", file=sys.stderr, flush=True)
            shutil.rmtree(Path(scratch) / name)
    console.print(table, markup=False)
    console.print(f"{len(names) - missed} of {len(names)} planted defects found")
    return int(missed > 0)


def _told(found: Sequence[str]) -> str:
    return f"{len(found)} off" if found else "-"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
