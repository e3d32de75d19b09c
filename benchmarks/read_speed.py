"""Times the reading of text dumps side by side: `python benchmarks/read_speed.py --folder DIR [--ovito-python PYTHON] [--rounds 5]`.

Writes two dumps of about 200 MB into the folder (frames of 100,000 rows, 16 columns, mixed ids, a blank at the end of each row), one
with %g and one with %.17g, and checks that all numbers read from them are those of Python's float(), bit for bit. Then, in turn, round
by round, with all files in memory: this project with one thread and with two (blocks of one frame), OVITO, MDAnalysis and numpy.loadtxt
on the first frames. Last a child reads a dump of 2 GB frame by frame and tells its largest memory.

What is timed: all frames, all columns, each as float64 arrays; rows sorted by id here, in the order of the file in OVITO (its default).
OVITO: import_file and, for every frame, compute() and all properties; in an interpreter of its own, its import not counted, all the
threads it likes. MDAnalysis: a pass over a DumpReader(additional_columns=True) that is already open (float32 positions). The column
"others" says how many cores other programs used meanwhile (Linux): ratios are the medians of each round's; those of rounds that others
disturb mean little, above all for two threads on two cores. --patience S waits up to S seconds before each measurement for others to
use less than a tenth of a core.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from demverify.formats.dump import read_block, read_dump, split
from demverify.formats.reading import AS_WRITTEN, Block

NAMES = ("id", "type", *"xyz", "vx", "vy", "vz", "fx", "fy", "fz", "omegax", "omegay", "omegaz", "radius", "mass")
ROWS = 100_000
FORMATS = {"%g": 14, "%.17g": 8}  # frames that make 200 MB
OTHERS_FRAMES = {"MDAnalysis": 4, "numpy.loadtxt": 2}
COPIES = 10
OVITO = """
import json, sys, time
from ovito.io import import_file
print(json.dumps("ready"), flush=True)
for path in sys.stdin:
    start, cpu, values = time.perf_counter(), time.process_time(), 0
    pipeline = import_file(path.strip())
    for frame in range(pipeline.num_frames):
        data = pipeline.compute(frame)
        values += sum(data.particles[name][...].size for name in data.particles.keys())
    print(json.dumps((time.perf_counter() - start, time.process_time() - cpu, values)), flush=True)
"""
MEMORY = """
import re, sys, time
from pathlib import Path
from demverify.formats.dump import read_dump
start = time.perf_counter()
frames = sum(1 for _ in read_dump(sys.argv[1]))
peak = int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) / 1024
print(f"{frames} frames, one after the other: at most {peak:.0f} MB in memory; {time.perf_counter() - start:.1f} s")
"""


@dataclass(frozen=True)
class Time:
    """One measurement. wall: s. others: cores that other programs used meanwhile."""

    wall: float
    others: float


def write_dump(path, fmt, frames):
    """A dump as LIGGGHTS would write it of a moving bed; also one of its first frames alone for each slow reader."""
    rng = np.random.default_rng(1)
    row = "%d %d" + 14 * f" {fmt}" + " \n"
    with path.open("w") as stream:
        for step in range(frames):
            stream.write(f"ITEM: TIMESTEP\n{step:09d}\nITEM: NUMBER OF ATOMS\n{ROWS}\nITEM: BOX BOUNDS pp pp ff\n" + 3 * "0 0.3\n")
            stream.write(f"ITEM: ATOMS {' '.join(NAMES)} \n")
            stream.writelines(row % values for values in zip(*(column.tolist() for column in columns(rng)), strict=True))
    for name, few in OTHERS_FRAMES.items():
        size = path.stat().st_size * few // frames
        [first, *_] = split(path, size)
        part_of(path, name).write_bytes(path.open("rb").read(first.stop))


def columns(rng):
    """Positions in a box, moderate velocities, forces over many orders of magnitude with zeros among them, small particles."""
    radius = rng.uniform(0.001, 0.002, ROWS)
    force = [np.where(rng.random(ROWS) < 0.1, 0.0, rng.normal(size=ROWS) * np.exp(rng.normal(0.0, 2.0, ROWS))) for _ in range(3)]
    return [
        rng.permutation(ROWS) + 1,
        rng.integers(1, 4, ROWS),
        *rng.uniform(0.0, 0.3, (3, ROWS)),
        *rng.normal(0.0, 0.2, (3, ROWS)),
        *force,
        *rng.normal(0.0, 10.0, (3, ROWS)),
        radius,
        4.0 / 3.0 * np.pi * radius**3 * 2500.0,
    ]


def part_of(path, name):
    """The first frames of a dump, for a slow reader."""
    return path.with_suffix(f".{name}")


def check(path):
    """Compares every number with float(). Raises SystemExit where one differs."""
    with path.open("rb") as stream:
        for frame in read_dump(path):
            for line in stream:
                if line.startswith(b"ITEM: ATOMS"):
                    break
            words = b"".join(stream.readline() for _ in range(frame.n)).split()
            expected = np.array([float(word) for word in words]).reshape(-1, len(NAMES))
            expected = expected[np.argsort(expected[:, 0])]
            got = np.column_stack([frame.columns[name] for name in NAMES])
            if not np.array_equal(got.view(np.int64), expected.view(np.int64)):
                sys.exit(f"{path}: step {frame.step} is not what float() reads")


def read_frames(block):
    """Numbers in a block."""
    return sum(frame.n * len(frame.columns) for frame in read_block(block, AS_WRITTEN))


def read_in_threads(path, threads, frames):
    """Numbers in a file of so many frames, read frame by frame side by side. Blocks are asked for a little smaller than a frame: the next
    frame is searched from there."""
    with ThreadPoolExecutor(threads) as pool:
        return sum(pool.map(read_frames, split(path, int(0.93 * path.stat().st_size / frames))))


def read_mdanalysis(reader):
    """A pass over all frames."""
    for step in reader:
        assert step.n_atoms == ROWS


def read_loadtxt(path):
    """The rows of the frames alone, without looking for them."""
    with path.open("rb") as stream:
        for _ in range(OTHERS_FRAMES["numpy.loadtxt"]):
            assert np.loadtxt(stream, skiprows=9, max_rows=ROWS).shape == (ROWS, len(NAMES))


class Ovito:
    """OVITO in an interpreter of its own."""

    def __init__(self, python):
        self._process = subprocess.Popen([python, "-c", OVITO], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._process.stdout.readline()

    def read(self, path):
        """Reads a file; the processor time that it took."""
        self._process.stdin.write(f"{path}\n")
        self._process.stdin.flush()
        _, cpu, values = json.loads(self._process.stdout.readline())
        assert values >= ROWS * len(NAMES)
        return cpu

    def close(self):
        """Ends it."""
        self._process.stdin.close()
        self._process.wait()


def busy():
    """Processor seconds that all programs have used, 0 where the system does not tell."""
    try:
        user, nice, system = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0].split()[1:4]
    except OSError:
        return 0.0
    return (int(user) + int(nice) + int(system)) / os.sysconf("SC_CLK_TCK")


def wait_for_quiet(patience):
    """Waits up to so many seconds for others to use less than a tenth of a core."""
    until = time.perf_counter() + patience
    while time.perf_counter() < until:
        start, before = time.perf_counter(), busy()
        time.sleep(0.5)
        if busy() - before < 0.1 * (time.perf_counter() - start):
            break


def timed(read, patience):
    """Wall time of a call; what it returns, if anything, is processor time used outside of this process."""
    wait_for_quiet(patience)
    before, cpu, start = busy(), time.process_time(), time.perf_counter()
    elsewhere = read()
    wall = time.perf_counter() - start
    used = time.process_time() - cpu + (elsewhere if isinstance(elsewhere, float) else 0.0)
    return Time(wall, max(0.0, (busy() - before - used) / wall))


def readers(fmt, path, ovito):
    """Name -> (what to time, MB that it reads)."""
    from MDAnalysis.coordinates.LAMMPS import DumpReader

    warnings.filterwarnings("ignore", module="MDAnalysis")  # it has no time step
    size = path.stat().st_size / 1e6
    parts = {name: part_of(path, name) for name in OTHERS_FRAMES}
    frames = FORMATS[fmt]
    found = {"demverify": (lambda: read_frames(Block(path)), size), "demverify, 2 threads": (lambda: read_in_threads(path, 2, frames), size)}
    if ovito:
        found["OVITO"] = (lambda: ovito.read(path), size)
    reader = DumpReader(str(parts["MDAnalysis"]), additional_columns=True)
    found["MDAnalysis"] = (lambda: read_mdanalysis(reader), parts["MDAnalysis"].stat().st_size / 1e6)
    found["numpy.loadtxt"] = (lambda: read_loadtxt(parts["numpy.loadtxt"]), parts["numpy.loadtxt"].stat().st_size / 1e6)
    return found


def compare(fmt, path, ovito, rounds, patience):
    """Prints the table of one dump."""
    found = readers(fmt, path, ovito)
    for read, _ in found.values():  # compile, and bring the file into memory
        read()
    times = [{name: timed(read, patience) for name, (read, _) in found.items()} for _ in range(rounds)]
    speed = [{name: found[name][1] / one[name].wall for name in found} for one in times]
    print(f"\n{fmt}: {path.stat().st_size / 1e6:.0f} MB, {rounds} rounds\n\n| reader | MB/s | lowest | highest | demverify is faster by | others |")
    print("|---|---:|---:|---:|---:|---:|")
    for name in found:
        all_ = [one[name] for one in speed]
        ratio = median(one["demverify"] / one[name] for one in speed)
        others = median(one[name].others for one in times)
        print(f"| {name} | {median(all_):.0f} | {min(all_):.0f} | {max(all_):.0f} | {ratio:.2f} | {others:.2f} |")
    gain = [one["demverify, 2 threads"] / one["demverify"] for one in speed]
    print(f"\ntwo threads over one: {median(gain):.2f} (rounds: {' '.join(f'{one:.2f}' for one in gain)})")


def memory(path):
    """Reads 2 GB in a child, which prints its peak (VmHWM of Linux: what getrusage tells also holds what the parent had)."""
    content = path.read_bytes()
    big = path.with_name("big.txt")
    with big.open("wb") as stream:
        for copy in range(COPIES):
            stream.write(content.replace(b"TIMESTEP\n00", b"TIMESTEP\n%02d" % copy))
    done = subprocess.run([sys.executable, "-c", MEMORY, str(big)], capture_output=True, text=True, check=True)
    print(f"\n{big.stat().st_size / 1e6:.0f} MB in {done.stdout}")
    big.unlink()


def main():
    """Writes, checks, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True, help="where the dumps go, 2.6 GB; those that are there are used again")
    parser.add_argument("--ovito-python", help="a Python that has ovito")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--patience", type=float, default=0.0, help="seconds to wait for a quiet machine before each measurement")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    ovito = Ovito(options.ovito_python) if options.ovito_python else None
    paths = {fmt: options.folder / f"{fmt.strip('%').replace('.', '')}.txt" for fmt in FORMATS}
    for fmt, path in paths.items():
        if not path.exists():
            write_dump(path, fmt, FORMATS[fmt])
        check(path)
        print(f"{path.name}: {FORMATS[fmt]} frames, {FORMATS[fmt] * ROWS * len(NAMES)} numbers, all equal to float() bit for bit")
        compare(fmt, path, ovito, options.rounds, options.patience)
    if ovito:
        ovito.close()
    memory(paths["%g"])


if __name__ == "__main__":
    main()
