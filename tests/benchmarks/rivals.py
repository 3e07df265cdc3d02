# SPDX-License-Identifier: GPL-3.0-or-later
"""Other programs: rivals.py SITEDDA_NATIVE [--ntdda FOLDER] [--box2d FOLDER] [--pairs N] [--docs]

A wall of touching bricks in running bond under sudden gravity, in sitedda and in ntdda (a
descendant of the original DDA) or Box2D 3, with equal bricks, density and friction.  ntdda has
the same elasticity, penalty (its own, 50 E) and time steps as sitedda.  FOLDER is the source of
a program; ntdda is built beforehand:
cmake -B build -DCMAKE_C_FLAGS="-O3 -march=native -fcommon -w" && make -C build dda

The programs run alternately on one thread.  Printed are processor times of a step (ntdda) or of a
simulated second (Box2D), of both DDA programs without the first step, and the final errors:
settlement, of the top over the closed form ρ g H²/2E; asymmetry, the largest difference of mirrored
displacements over the same settlement; reaction, of the base over the weight of the bricks minus 1.
The wall is symmetric and at rest in the end, thus the last two are zero in the exact solution.
--docs writes the tables to docs/benchmarks.md, which `speed.py --docs` retains.
"""

import re
import statistics
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import speed_report
from common import ROOT, parse_options
from compare import LONG, changed, taken_by
from speed_models import DENSITY, GRAVITY, YOUNG_MODULUS, Model, touching_wall
from wall_ntdda import FACTOR, analysis, geometry

import sitedda

HERE = Path(__file__).parent
LIMIT = 20  # s of processor time of a run of another program
SUBSTEPS, FRAME = 16, 1 / 60  # of Box2D
FREQUENCY, ACCELERATION = 2.0, 0.1 * GRAVITY  # of the shaking, Hz and m/s²
SAMPLE = 0.005  # s
NTDDA = ((200, 1e-3, 60), (200, 5e-3, 60), (200, 1e-3, 200), (400, 1e-3, 60), (400, 5e-3, 60),
         (820, 1e-3, 60), (820, 5e-3, 60))  # fmt: skip
BOX2D = ((0.0, FRAME), (0.0, 0.05), (0.0, 0.1), (ACCELERATION, FRAME), (ACCELERATION, 0.05))
FLAGS = ["-O3", "-march=native", "-DNDEBUG", "-w"]


@dataclass(frozen=True)
class Result:
    """Processor time of a run, s, final vertices (blocks, 4, 2) and the force on the base, N."""

    time: float
    vertices: np.ndarray
    reaction: float


def shaken_text(model: Model, time_step: float, acceleration: float) -> str:
    """Return the input of sitedda, shaken by a sine from the start."""
    times = np.arange(0.0, 1.5, SAMPLE)
    values = acceleration * np.sin(2 * np.pi * FREQUENCY * times)
    motion = "&motion name = 'shaking', quantity = 'acceleration', drift_order = 0"
    motion += f", time_step = {SAMPLE}\n   values = " + ", ".join(f"{it:.5f}" for it in values)
    text = model.text(FACTOR * YOUNG_MODULUS, time_step, LONG, 0, "auto")
    text = re.sub(r"(?ms)^&motion.*? /$", f"{motion} /", text)
    return text + "&output history_interval = 1 /\n"


def run_sitedda(engine: Path, folder: Path, model: Model, text: str, steps: int) -> Result:
    """Return the result of sitedda, without the time of a run of one step."""
    files = [folder / f"sitedda_{number}.nml" for number in (1, steps)]
    for file, number in zip(files, (1, steps), strict=True):
        file.write_text(changed(text, number, number))
    start, time = (taken_by(engine, file) for file in files)
    with sitedda.open_output(files[1].with_suffix(".nc")) as data:
        vertices = data.vertices.values[-1].reshape(-1, 4, 2)
    return Result(time - start, vertices, base_force(model, vertices))


def run_ntdda(program: Path, folder: Path, model: Model, time_step: float, steps: int) -> Result:
    """Return the result of ntdda, without the time of a run of one step."""
    (folder / "wall.geo").write_text(geometry(model))
    runs = []
    for number in (1, steps):
        (folder / "wall.ana").write_text(analysis(number, time_step))
        runs.append(parsed(output_of([program, "wall.geo", "wall.ana"], folder, "")))
    vertices = in_order(model, runs[1][2])
    return Result(runs[1][0] - runs[0][0], vertices, base_force(model, vertices))


def run_box2d(program: Path, folder: Path, model: Model, acceleration: float) -> Result:
    """Return the result of one second of Box2D."""
    bricks = "".join("{} {} {} {}\n".format(*it[[0, 2]].ravel()) for it in model.polygons)
    arguments = [str(round(1 / FRAME)), str(FRAME), str(SUBSTEPS), str(acceleration)]
    time, force, vertices = parsed(output_of([program, *arguments, str(FREQUENCY)], folder, bricks))
    return Result(time, vertices, force)


def output_of(command: list, folder: Path, data: str) -> str:
    """Return the standard output of a program."""
    limited = ["sh", "-c", f'ulimit -t {LIMIT}; exec "$@"', "sh", *command]
    return subprocess.run(limited, cwd=folder, input=data, check=True, capture_output=True,
                          text=True).stdout  # fmt: skip


def parsed(output: str) -> tuple[float, float, np.ndarray]:
    """Return time, reaction (NaN if not printed) and vertices of the output of a driver."""
    head = re.search(r"(?m)^time (\S+)\n(?:reaction (\S+)\n)?", output)
    if head is None:
        raise ValueError("the program has printed no time")
    rows = [line.split() for line in output[head.end() :].splitlines()]
    return float(head[1]), float(head[2] or "nan"), np.array(rows, float).reshape(-1, 4, 2)


def in_order(model: Model, vertices: np.ndarray) -> np.ndarray:
    """Return vertices in the order of the model, whose blocks ntdda renumbers."""
    centres = vertices.mean(axis=1)
    ordered = []
    for polygon in model.polygons:
        block = vertices[np.argmin(((centres - polygon.mean(axis=0)) ** 2).sum(axis=1))]
        ordered.append([block[np.argmin(((block - it) ** 2).sum(axis=1))] for it in polygon])
    return np.array(ordered)


def base_force(model: Model, vertices: np.ndarray) -> float:
    """Return the force of the penalty springs between the base and the course on it, N."""
    right, left = vertices[0, 2:]
    course = [i for i, it in enumerate(model.polygons) if i and it[0, 1] == 0.0]
    feet = vertices[course, :2].reshape(-1, 2)
    surface = np.interp(feet[:, 0], [left[0], right[0]], [left[1], right[1]])
    return float(FACTOR * YOUNG_MODULUS * np.maximum(surface - feet[:, 1], 0.0).sum())


def errors(model: Model, result: Result) -> tuple[float, float, float]:
    """Return settlement over the closed form, asymmetry over it, and reaction over weight - 1."""
    polygons = np.array(model.polygons)
    closed_form = DENSITY * GRAVITY * model.top**2 / (2 * YOUNG_MODULUS)
    moved = result.vertices - polygons
    mirrored = polygons[:, [1, 0, 3, 2]] * [-1, 1] + [polygons[1:, :, 0].max(), 0]
    place = {tuple(corners): i for i, corners in enumerate(polygons.reshape(-1, 8).round(6))}
    pairs = [place[tuple(corners)] for corners in mirrored.reshape(-1, 8).round(6)]
    asymmetry = np.abs(moved - moved[pairs][:, [1, 0, 3, 2]] * [-1, 1]).max()
    sides = polygons[1:, 2] - polygons[1:, 0]
    weight = DENSITY * GRAVITY * sides.prod(axis=1).sum()
    settlement = -moved[..., 1].min() / closed_form
    return settlement, asymmetry / closed_form, result.reaction / weight - 1


def compared(ours: Callable[[], Result], other: Callable[[], Result], pairs: int):
    """Return the results of both programs, run alternately; of the other none if it fails."""
    try:
        results: tuple[list[Result], list[Result]] = ([], [other()])
    except (subprocess.SubprocessError, ValueError):
        return [ours() for _ in range(pairs)], []
    for pair in range(pairs):
        results[0].append(ours())
        if pair + 1 < pairs:
            results[1].append(other())
    return results


def cells(model: Model, results: tuple[list[Result], list[Result]], unit: float) -> list[str]:
    """Return times over `unit` with their ranges, their ratio, and the errors of both programs."""
    times = [sorted(1e3 * it.time / unit for it in runs) for runs in results]
    if not results[1]:
        return [f"{statistics.median(times[0]):.3g}", "fails", "–", "–", "–", "–"]
    medians = [statistics.median(it) for it in times]
    shown = [f"{statistics.median(it):.3g} ({it[0]:.3g}–{it[-1]:.3g})" for it in times]
    both = zip(*(errors(model, runs[-1]) for runs in results), strict=True)
    return [*shown, f"{medians[1] / medians[0]:.2g}", *(f"{a:.2g}, {b:.2g}" for a, b in both)]


def compiled(folder: Path, name: str, *arguments) -> Path:
    """Return the program that is compiled from a driver beside this file."""
    program = folder / name
    subprocess.run(
        ["gcc", *FLAGS, HERE / f"{name}.c", *arguments, "-lm", "-o", program], check=True
    )
    return program


def ntdda_rows(engine: Path, source: Path, folder: Path, pairs: int) -> list[str]:
    """Return rows of the table of sitedda and ntdda."""
    paths = [f"-I{source}/{name}" for name in ("include", "src/platform/stubs")]
    program = compiled(
        folder, "wall_ntdda", "-fcommon", *paths, source / "build/src/libdda.a", "-lxml2"
    )
    rows = []
    for blocks, step, steps in NTDDA:
        model = touching_wall(blocks)
        ours = partial(run_sitedda, engine, folder, model, shaken_text(model, step, 0.0), steps)
        other = partial(run_ntdda, program, folder, model, step, steps)
        case = [len(model.polygons), f"{1e3 * step:g}", steps]
        rows.append(row(*case, *cells(model, compared(ours, other, pairs), steps - 1)))
    return rows


def box2d_rows(engine: Path, source: Path, folder: Path, pairs: int) -> list[str]:
    """Return rows of the table of sitedda and Box2D, for 1,008 blocks and one second."""
    program = compiled(
        folder, "wall_box2d", f"-I{source}/include", *source.glob("src/*.c"), "-lpthread"
    )
    model = touching_wall(1000)
    rows = []
    for acceleration, step in BOX2D:
        text = shaken_text(model, step, acceleration)
        ours = partial(run_sitedda, engine, folder, model, text, round(1 / step))
        other = partial(run_box2d, program, folder, model, acceleration)
        case = ["shaken" if acceleration else "settling", f"{1e3 * step:.3g}"]
        rows.append(row(*case, *cells(model, compared(ours, other, pairs), 1)))
    return rows


def row(*values) -> str:
    """Return and print a row."""
    print(speed_report.row(*values), flush=True)
    return speed_report.row(*values)


def main() -> None:
    """Measure, print, and write the tables if required."""
    options = parse_options(__doc__, "engine", ntdda=Path, box2d=Path, pairs=3, docs=False)
    if options.docs and not (options.ntdda and options.box2d):
        raise SystemExit("--docs requires --ntdda and --box2d")
    engine = options.engine.resolve()
    tables = {}
    for name, rows in (("ntdda", ntdda_rows), ("box2d", box2d_rows)):
        source = getattr(options, name)
        if source:
            with tempfile.TemporaryDirectory() as folder:
                tables[name] = rows(engine, source.resolve(), Path(folder), options.pairs)
    if options.docs:
        speed_report.write_rivals(ROOT / "docs" / "benchmarks.md", tables)


if __name__ == "__main__":
    main()
