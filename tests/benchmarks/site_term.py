# SPDX-License-Identifier: GPL-3.0-or-later
"""Multi-fidelity site terms of a basin and a ridge, compared with plain sampling.

    python tests/benchmarks/site_term.py [--shapes basin ridge] [--large 600] [--repeats 20]
        [--runs 30] [--columns 10000] [--size 10] [--folder FOLDER]

--large and --runs are the numbers of plane runs of the large sample and of a repetition; --folder
keeps the large sample; --size is the size of cells, m.  Each repetition has its own plane runs.  An
interval is correct if it contains the mean of the large plain sample within that mean's interval.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from layered_site import parse_options

import sitedda
from sitedda import Column, HalfSpace, Layer
from sitedda.site import site_term
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


@dataclass(frozen=True)
class Site:
    """Random velocities of soil and rock, and damping of soil, by sample number."""

    name: str
    file: str
    first: int = 0

    def values(self, sample: int) -> np.ndarray:
        """Return the S-wave velocities of soil and rock (m/s) and the damping ratio of soil."""
        deviates = np.random.default_rng([7, self.first + sample]).standard_normal(3)
        return np.array([250.0, 760.0, 0.04]) * np.exp(np.array([0.15, 0.1, 0.3]) * deviates)


class Plane(Site):
    """Amplification factors of the plane model."""

    def __call__(self, sample: int) -> np.ndarray:
        soil, rock, damping = self.values(sample)
        changes = {f"material[{name}].{wave}_velocity": float(speed * ratio)
                   for name, speed, high in (("soil", soil, 2.4), ("rock", rock, 1400 / 760))
                   for wave, ratio in (("shear", 1.0), ("pressure", high))}  # fmt: skip
        changes["material[soil].damping_ratio"] = float(damping)
        with sitedda.Simulation(self.file, changes=changes) as model:
            found = [sitedda.transfer(model, 1 / PERIODS, name, None)
                     for name in SHAPES[self.name][2]]  # fmt: skip
        return np.abs(found)


class Columns(Site):
    """Amplification factors of the columns below the points."""

    def __call__(self, sample: int) -> np.ndarray:
        soil, rock, damping = self.values(sample)
        below = HalfSpace(density=2200.0, shear_velocity=760.0)
        return np.array([
            abs(Column([Layer(up, density=1900.0, shear_velocity=soil, damping=damping),
                        Layer(down, density=2200.0, shear_velocity=rock, damping=0.01)], below)
                .transfer(1 / PERIODS, kind="outcrop"))
            for _, _, up, down in SHAPES[self.name][2].values()
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
    options = parse_options(__doc__, shapes=list(SHAPES), large=600, repeats=20, runs=30,
                            columns=10_000, size=10.0, folder=Path)  # fmt: skip
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)  # the path of the model identifies stored cases
        folder.mkdir(parents=True, exist_ok=True)
        for name in options.shapes:
            compare(name, folder, options)


def compare(name: str, folder: Path, options) -> None:
    """Print the site term of a shape, and how many intervals of its repetitions are correct."""
    file, points = write_model(folder, name, options.size), list(SHAPES[name][2])
    large = study(Plane(name, file), {"sample": range(options.large)},
                  folder=options.folder and options.folder / name)["value"].values  # fmt: skip
    logs = np.log(large)
    plain = np.exp(logs.mean(axis=0)), 1.96 * logs.std(axis=0, ddof=1) / np.sqrt(len(logs))
    finer = {"mesh": Plane(name, write_model(folder, name, options.size / 2)),
             "time step": Plane(name, write_model(folder, name, options.size, 2e-3))}  # fmt: skip
    print(site_term(Plane(name, file), Columns(name, file), points, PERIODS, runs=options.runs,
                    columns=options.columns, finer=finer, finer_runs=2))  # fmt: skip
    right, saving, half = [], [], []
    for number in range(options.repeats):
        first = 100_000 * (number + 1)
        own = (Plane(name, file, first), Columns(name, file, first))
        one = site_term(*own, points, PERIODS, runs=options.runs, columns=options.columns).table
        off = np.abs(np.log(one["median"].values / plain[0]))
        right.append(off <= np.hypot(one.sampling.values, plain[1]))
        saving.append(one.saving.values)
        half.append(one.sampling.values)
    for i, j in np.ndindex(len(points), PERIODS.size):
        print(f"{name} {points[i]}, {PERIODS[j]:g} s: {sum(one[i, j] for one in right)} of "
              f"{len(right)} intervals hold {plain[0][i, j]:.4f} ± {100 * plain[1][i, j]:.1f} %; "
              f"saving {np.median([one[i, j] for one in saving]):.1f}, "
              f"± {100 * np.median([one[i, j] for one in half]):.2f} %")  # fmt: skip


if __name__ == "__main__":
    main()
