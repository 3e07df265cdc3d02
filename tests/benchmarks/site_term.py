# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage of multi-fidelity site terms of a basin and a ridge.

    python tests/benchmarks/site_term.py [--shapes basin ridge] [--large 600] [--repeats 20]
        [--runs 20] [--size 10] [--folder FOLDER]

A large plain sample of plane runs, which --folder keeps, is the population of profiles.  Each
repetition draws --runs of them by their columns, so the mean of the large sample is exact.
Its error as an estimate for all profiles is printed too.  --size is the size of cells, m.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common import parse_options

import sitedda
from sitedda import Column, HalfSpace, Layer
from sitedda.signals import smooth_konno_ohmachi
from sitedda.site import site_term
from sitedda.site.site_terms import draw_samples, term_of
from sitedda.study import study

HEAD = """&run title = '{name}' /
&control time_step = {step}, analysis = 'plane_strain', integration = 'midpoint', duration = 1.0 /
&material name = 'rock', density = 2200.0, shear_velocity = 760.0, pressure_velocity = 1400.0,
   rayleigh_frequencies = 1.0, 8.0, damping_ratio = 0.01 /
&material name = 'soil', density = 1900.0, shear_velocity = 250.0, pressure_velocity = 600.0,
   rayleigh_frequencies = 1.0, 8.0, damping_ratio = 0.04 /
&joint name = 'none', friction_angle = 45.0 /
&region name = 'ground', outline = {outline}, material = 'soil' /
&surface points = {surface}, material = 'rock' /
&mesh regions = 'ground', size = {size}, body = 'ground' /
&motion name = 'quake', file = 'quake.csv', quantity = 'acceleration', unit = 'm/s2' /
&boundary name = 'base', kind = 'compliant', side = 'bottom', motion_x = 'quake',
   density = 2200.0, shear_velocity = 760.0, pressure_velocity = 1400.0 /
&boundary kind = 'tied' /
"""
SHAPES = {  # outline, rock surface; points with thicknesses of soil and rock below
    "basin": ("-100, -30, 100, -30, 100, 0, -100, 0", "-60, 0, -40, -20, 40, -20, 60, 0",
              {"middle": (0, 0, 20, 10), "edge": (50, 0, 10, 20)}),
    "ridge": ("-100, -20, 100, -20, 100, 0, 30, 0, 0, 30, -30, 0, -100, 0",
              "-100, -10, -30, -10, 0, 20, 30, -10, 100, -10",
              {"level": (-80, 0, 10, 10), "crest": (0, 30, 10, 40)}),
}  # fmt: skip
PERIODS = np.array([0.35, 0.6, 1.0])  # s
BANDWIDTH = 40.0  # of the window of Konno and Ohmachi, which ends at ± 20 % of its centre
FREQUENCIES = np.geomspace(0.8, 3.45, 80)  # Hz
COPIES = 100  # copies of the columns of the population, so that their number is no error


def smoothed(transfer: np.ndarray) -> np.ndarray:
    """AF over a band at each period."""
    return smooth_konno_ohmachi(FREQUENCIES, transfer, BANDWIDTH, 1 / PERIODS)


@dataclass(frozen=True)
class Site:
    """Random velocities of soil and rock, and damping of soil, by sample number."""

    name: str
    file: str

    def values(self, sample: int) -> np.ndarray:
        """Return the S-wave velocities of soil and rock (m/s) and the damping ratio of soil."""
        normal_numbers = np.random.default_rng([7, sample]).standard_normal(3)
        return np.array([250.0, 760.0, 0.04]) * np.exp(np.array([0.15, 0.1, 0.3]) * normal_numbers)


class Plane(Site):
    """Amplification factors of the plane model."""

    def __call__(self, sample: int) -> np.ndarray:
        soil, rock, damping = self.values(sample)
        changes = {f"material[{name}].{wave}_velocity": float(speed * ratio)
                   for name, speed, high in (("soil", soil, 2.4), ("rock", rock, 1400 / 760))
                   for wave, ratio in (("shear", 1.0), ("pressure", high))}  # fmt: skip
        changes["material[soil].damping_ratio"] = float(damping)
        with sitedda.Simulation(self.file, changes=changes) as model:
            return np.array([smoothed(sitedda.transfer(model, FREQUENCIES, name, None))
                             for name in SHAPES[self.name][2]])  # fmt: skip


class Columns(Site):
    """Amplification factors of the columns below the points."""

    def __call__(self, sample: int) -> np.ndarray:
        soil, rock, damping = self.values(sample)
        below = HalfSpace(density=2200.0, shear_velocity=760.0)
        return np.array([
            smoothed(Column([Layer(upper, density=1900.0, shear_velocity=soil, damping=damping),
                             Layer(lower, density=2200.0, shear_velocity=rock, damping=0.01)],
                       below)
                     .transfer(FREQUENCIES, kind="outcrop"))
            for _, _, upper, lower in SHAPES[self.name][2].values()
        ])  # fmt: skip


def write_model(folder: Path, name: str, size: float, step: float = 4e-3) -> str:
    """Write the input of a shape."""
    outline, surface, points = SHAPES[name]
    text = HEAD.format(name=name, outline=outline, surface=surface, size=size, step=step)
    for point, (x, y, _, _) in points.items():
        text += f"&measured_point name = '{point}', x = {x:.1f}, y = {y:.1f} /\n"
    (folder / "quake.csv").write_text("0, 0\n0.01, 0\n0.02, 0\n")
    file = folder / f"{name}_{size:g}_{step:g}.nml"
    file.write_text(text)
    return str(file)


def main() -> None:
    options = parse_options(__doc__, shapes=list(SHAPES), large=600, repeats=20, runs=20,
                            size=10.0, folder=Path)  # fmt: skip
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)  # the path of the model identifies stored cases
        folder.mkdir(parents=True, exist_ok=True)
        for name in options.shapes:
            compare(name, folder, options)


def compare(name: str, folder: Path, options) -> None:
    """Print the term of a shape, and how many intervals contain the mean of all runs."""
    file, points = write_model(folder, name, options.size), list(SHAPES[name][2])
    finer = {"mesh": Plane(name, write_model(folder, name, options.size / 2)),
             "time step": Plane(name, write_model(folder, name, options.size, 2e-3))}  # fmt: skip
    large = study(Plane(name, file), {"sample": range(options.large)}, folder=folder / name,
                  workers=1)["value"].values  # fmt: skip
    below = Columns(name, file)
    print(site_term(Plane(name, file), below, points, PERIODS, runs=options.runs, columns=10_000,
                    finer=finer, finer_runs=2, workers=1))  # fmt: skip
    plane, columns = np.log(large), np.log([below(i) for i in range(options.large)])
    mean = plane.mean(axis=0)
    error = 1.96 * plane.std(axis=0, ddof=1) / np.sqrt(len(plane))
    generator, tables = np.random.default_rng(1), []
    medians = np.tile(columns, (COPIES, 1, 1))
    for _ in range(options.repeats):
        rows = draw_samples(medians, options.runs, generator)
        values = plane[rows % options.large]
        tables.append(term_of(values, medians, rows, points, PERIODS).table)
    deviation = np.abs([np.log(table["median"].values) - mean for table in tables])
    half = np.array([table.sampling.values for table in tables])
    saving = np.median([table.saving.values for table in tables], axis=0)
    right = (deviation <= half).sum(axis=0)
    for (i, j), count in np.ndenumerate(right):
        print(f"{name} {points[i]}, {PERIODS[j]:g} s: {count} of {len(deviation)} "
              f"intervals contain {np.exp(mean[i, j]):.4f} (for all profiles "
              f"± {100 * error[i, j]:.1f} %); median interval "
              f"± {100 * np.median(half[:, i, j]):.2f} %, saving {saving[i, j]:.1f}")  # fmt: skip
    print(f"{name}: {right.sum()} of {deviation.size} intervals contain the mean")


if __name__ == "__main__":
    main()
