# SPDX-License-Identifier: GPL-3.0-or-later
"""A column of yielding soil, compared with OpenSees (nested yield surfaces, the same backbone).

Prints surface PGA, Sa and largest strain of both programs at three intensities; `--plot FILE` draws
the loops of the lowest cells.  Requires `openseespy==3.7.0.6` with `openseespylinux==3.7.0.6`
(3.7.1.2 rejects PressureIndependMultiYield).  Run in the top folder of the repository:

    python tests/benchmarks/opensees_column.py
"""

from pathlib import Path

import numpy as np
from common import parse_options

import sitedda
from sitedda import Column, Layer
from sitedda.signals import spectral_acceleration
from sitedda.site import SoilCurves, nonlinear

HEIGHT, CELLS, DENSITY, VELOCITY = 20.0, 40, 2000.0, 300.0  # m, –, kg/m³, m/s
REFERENCE = 3.65e-4  # reference strain γ_r of the hyperbola
STRAINS = np.logspace(-6.5, -1.3, 39)  # strains of the nested surfaces, at most 40
PERIODS = np.array([0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0, 2.0])  # s
RECORD = Path("inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc")
DURATION, STEPS = 20.0, 5  # s of the record, steps per sample


def opensees(base, step):
    """Return surface acceleration, m/s², and strain and stress (Pa) of the lowest cell."""
    import openseespy.opensees as ops

    size = HEIGHT / CELLS
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    for i in range(CELLS + 1):
        for side in (0, 1):
            node = 2 * i + 1 + side
            ops.node(node, float(side), i * size)
            ops.fix(node, int(i == 0), 1)
        if i > 0:
            ops.equalDOF(2 * i + 1, 2 * i + 2, 1)
    modulus = DENSITY * VELOCITY**2
    pairs = [float(v) for s in STRAINS for v in (s, 1 / (1 + s / REFERENCE))]
    soil = (2, DENSITY, modulus, 5 * modulus, 1.0, 0.1, 0.0, 100.0, 0.0, -len(STRAINS), *pairs)
    ops.nDMaterial("PressureIndependMultiYield", 1, *soil)
    for i in range(CELLS):
        corners = (2 * i + 1, 2 * i + 2, 2 * i + 4, 2 * i + 3)
        ops.element("quad", i + 1, *corners, 1.0, "PlaneStrain", 1)
    ops.updateMaterialStage("-material", 1, "-stage", 1)
    ops.timeSeries("Path", 1, "-dt", step, "-values", *map(float, base))
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-10, 50)
    ops.algorithm("KrylovNewton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    response = np.zeros((3, base.size))
    for k in range(1, base.size):
        if ops.analyze(1, step) != 0:
            raise SystemExit(f"OpenSees does not converge in step {k}")
        response[0, k] = ops.nodeAccel(2 * CELLS + 1, 1) + base[k]
        response[1, k] = ops.nodeDisp(3, 1) / size
        response[2, k] = ops.eleResponse(1, "material", 1, "stress")[3]  # xx, yy, zz, xy
    return response


def backbone():
    """Return the polygon of the nested surfaces, with the full modulus up to the first."""
    stress = STRAINS / (1 + STRAINS / REFERENCE)
    strain = np.unique(np.concatenate([np.logspace(-8, -1.3, 600), STRAINS]))
    corners = np.concatenate([[0.0, stress[0]], STRAINS[1:]])
    values = np.concatenate([[0.0, stress[0]], stress[1:]])
    reduction = np.minimum(np.interp(strain, corners, values) / strain, 1.0)
    return SoilCurves(strain, reduction, np.full(strain.size, 0.01))


def main() -> None:
    """Print the table, and draw the loops."""
    options = parse_options(__doc__, plot=Path)
    record = sitedda.read_record(RECORD)
    sample = float(record.time[1] - record.time[0])
    ground = record.acceleration.values[: round(DURATION / sample)]
    steps = np.arange((ground.size - 1) * STEPS + 1) / STEPS
    base = np.interp(steps, np.arange(ground.size), ground)
    column = Column([Layer(HEIGHT, density=DENSITY, shear_velocity=VELOCITY)])
    loops = []
    print("scale   strain (%)        PGA (m/s²)        Sa over OpenSees − 1 (%) at")
    print(" " * 42 + "".join(f"{p:>8g}" for p in PERIODS) + " s")
    for scale in (0.2, 0.5, 1.5):
        step = sample / STEPS
        top, strain, stress = opensees(scale * base, step)
        result = nonlinear(column, [backbone()], scale * base, step, damping_curve="masing",
                         branches=80, highest_frequency=50.0, compare=False)  # fmt: skip
        surface = result.acceleration()
        low = HEIGHT - 0.5 * HEIGHT / CELLS
        reference_result = spectral_acceleration(top, step, PERIODS)
        ratio = 100 * (result.spectrum(PERIODS) / reference_result - 1)
        print(
            f"{scale:5g}{100 * abs(strain).max():9.4f}{100 * abs(result.strain(low)).max():9.4f}"
            f"{abs(top).max():9.3f}{abs(surface).max():9.3f} "
            + "".join(f"{value:8.2f}" for value in ratio)
        )
        loops.append((scale, strain, stress, -result.strain(low), -result.stress(low)))
    if options.plot:
        draw(loops, options.plot)


def draw(loops, path) -> None:
    """Draw the loops of the lowest cells of both programs side by side."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 4), layout="constrained")
    for axes, (scale, *series) in zip(figure.subplots(1, len(loops)), loops, strict=True):
        strain, stress, own_strain, own_stress = series
        axes.plot(100 * strain, stress / 1e3, color="#8a9099", lw=1.6, label="OpenSees")
        axes.plot(100 * own_strain, own_stress / 1e3, color="#d55e00", lw=0.6, label="sitedda")
        axes.set(
            xlabel="shear strain (%)", ylabel="shear stress (kPa)", title=f"record × {scale:g}"
        )
        axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
