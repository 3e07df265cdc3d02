# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional waves in bodies of square cells: a free square, a ridge, oblique waves."""

import numpy as np

from sitedda.engine.checking import modes
from sitedda.engine.simulation import Simulation
from sitedda.facade.model import Model
from sitedda.report.style import BLUE, RED, canvas

from ..case import Outcome, Table, absolute, at_most, case, observed_order, relative
from ..model import rectangle

DENSITY, SPEED, POISSON = 2000.0, 200.0, 0.25  # kg/m³, m/s, -
SPEEDS = np.array([np.sqrt(2 * (1 - POISSON) / (1 - 2 * POISSON)), 1.0]) * SPEED  # P, S
AMPLITUDE = 1e-5  # m, amplitude with negligible effect on the geometry
_LARGEST = 2 * np.sqrt(2)  # largest amplitude on the faces of a ridge / amplitude of the wave
_STEPS_PER_PERIOD = 60  # number of steps per period of a wavelet
_BODY = "ground"


def _empty_model(title: str, poisson: float, **control) -> Model:
    """Return a model with the material of the ground, without blocks."""
    model = Model(title, integration="midpoint", analysis="plane_strain", **control)
    young = 2 * DENSITY * SPEED**2 * (1 + poisson)
    model.material("rock", density=DENSITY, young_modulus=young, poisson_ratio=poisson)
    model.joint("none", friction_angle=40.0)
    return model


def _ricker_wavelet(frequency: float, time):
    """Return a Ricker wavelet of displacement centred at t = 0 (m), and its acceleration."""
    rate = np.pi * frequency
    square = (rate * np.asarray(time)) ** 2
    fade = AMPLITUDE * np.exp(-square)
    return (1 - 2 * square) * fade, rate**2 * (-6 + 24 * square - 8 * square**2) * fade


@case(
    "Lamé's mode of a free square",
    "A square of side a has a mode of pure shear along its diagonals with f = V_s/(√2 a), for any "
    "Poisson's ratio, even near ½. The model is a body of n × n cells.",
    "Lamé (1852); `docs/method.md`.",
)
def free_square(short: bool) -> Outcome:
    """Check the frequency for ordinary and nearly incompressible rock, and its convergence."""
    exact = SPEED / np.sqrt(2)
    counts = (8, 16) if short else (8, 16, 32)
    ratios = (POISSON, 0.4999)
    errors = np.array([[_lame_frequency(n, ratio) / exact - 1 for n in counts] for ratio in ratios])
    rows = [
        relative(f"frequency, {counts[-1]} × {counts[-1]} cells, ν = {ratio:g}", exact,
                 exact * (1 + error[-1]), 0.003, "Hz")
        for ratio, error in zip(ratios, errors, strict=True)
    ]  # fmt: skip
    order = observed_order([1 / n for n in counts], np.abs(errors[1]))[-1]
    rows.append(at_most("1 / order of convergence of the frequency, ν = 0.4999", 1.0 / order, 0.6))
    head = ["cells", *(f"error, ν = {ratio:g}" for ratio in ratios)]
    lines = [
        [f"{n} × {n}", *(f"{100 * e:.3f} %" for e in pair)]
        for n, pair in zip(counts, errors.T, strict=True)
    ]
    figure, (axes,) = canvas(1)
    for ratio, error, color in zip(ratios, errors, (BLUE, RED), strict=True):
        axes.loglog(counts, np.abs(error), "o-", color=color, label=f"ν = {ratio:g}")
    axes.set(xlabel="cells along a side", ylabel="error of the frequency")
    return Outcome(rows, figure, [Table("Relative error of the frequency", head, lines)])


def _lame_frequency(count: int, poisson: float) -> float:
    """Return the frequency of Lamé's mode of a square of 1 m with `count`² cells, Hz."""
    model = _empty_model("square", poisson, time_step=1e-6, steps=1)
    side = 1.0 / count
    for j in range(count):
        for i in range(count):
            model.block(rectangle(i * side, j * side, side, side), body=_BODY)
    modes_found = modes(model, 12)
    centres = np.pi * (np.arange(count) + 0.5) / count  # centres of the cells
    x, y = np.stack(np.meshgrid(centres, centres)).reshape(2, -1)
    shape = np.stack([np.cos(x) * np.sin(y), -np.sin(x) * np.cos(y)], axis=-1)
    displacements = modes_found.shapes[:, :, :2]
    similarity = abs(np.einsum("mba,ba->m", displacements, shape))
    similarity /= np.linalg.norm(displacements, axis=(1, 2))
    return float(modes_found.frequency[np.argmax(similarity)])


@case(
    "A ridge of 90 degrees under vertical SV waves",
    "With the crest at the origin and faces y = −|x|, u_x = F(t − y/V_s) − F(t + y/V_s) and "
    "u_y = F(t + x/V_s) − F(t − x/V_s) leave the faces free of traction for any Poisson ratio: the "
    "crest is a node, and along the faces the amplitude is 2√2 |sin(kr/√2)|.",
    "Superposition of plane SV waves; `docs/boundaries.md`.",
)
def ridge(short: bool) -> Outcome:
    """Check amplitudes at the crest and the faces of a ridge as high as a wavelength."""
    rows, series, lines = [], [], []
    for length, poisson in ((12, 0.25),) if short else ((12, 0.25), (12, 0.4), (24, 0.25)):
        distance, computed, exact, crest = _run_ridge(length, poisson)
        series.append((length, distance, computed, exact))
        label = f"λ = {length} cells, ν = {poisson:g}"
        errors = crest / _LARGEST, abs(computed - exact).max() / _LARGEST
        lines.append([label, *(f"{value:.4f}" for value in errors)])
        rows += [
            at_most(f"{label}: amplitude at the crest / largest amplitude", errors[0], 0.12),
            at_most(f"{label}: largest error on the faces / largest amplitude", errors[1], 0.03),
        ]
    figure, (axes,) = canvas(1)
    length, distance, computed, exact = series[0]
    axes.plot(distance / length, exact, color=BLUE, label="closed form")
    axes.plot(distance / length, computed, "o", ms=4, color=RED,
        label=f"computed, λ = {length} cells")  # fmt: skip
    axes.set(xlabel="distance from the crest (λ)", ylabel="amplitude / amplitude of the wave")
    head = ["wavelength", "crest", "largest error on the faces"]
    title = "Amplitude at the crest and largest error on the faces / largest amplitude"
    return Outcome(rows, figure, [Table(title, head, lines)])


def _run_ridge(length: int, poisson: float):
    """Return distances from the crest (m), computed and exact amplitudes, amplitude of the crest.

    The frequency has a small negative imaginary part, for which the closed form is valid as well.
    It suppresses the vibration that remains at the end of the run.
    """
    frequency = SPEED / length
    delay = 1.5 / frequency + length / SPEED
    step, duration = 1.0 / (_STEPS_PER_PERIOD * frequency), 2 * delay + 3 * length / SPEED
    model = _empty_model("ridge", poisson, time_step=step, duration=duration)
    time = np.arange(0.0, duration + step, step) - delay

    def motion(name: str, delay_of_edge: float) -> None:
        times = (time + delay_of_edge, time - delay_of_edge)
        advance, delay = (_ricker_wavelet(frequency, at)[1] for at in times)
        values = advance - delay
        model.motion(name, values.tolist(), step, "acceleration", drift_order=0)

    for j in range(length):
        half, y = length - j, float(j - length)
        for i in range(-half, half):
            corners = rectangle(i, y, 1, 1)
            cut = {-half: 3, half - 1: 2}.get(i)
            outline = corners if cut is None else np.delete(corners, cut, axis=0)
            model.block(outline.ravel().tolist(), name=f"b_{j}_{i}", body=_BODY)
    motion("across", length / SPEED)
    for x in range(-length, length + 1):
        motion(f"up_{x}", x / SPEED)
    for i in range(-length, length):
        for x in (i, i + 1):
            motions = {"motion_x": "across", "motion_y": f"up_{x}"}
            model.fixed_point(float(x), -float(length), f"b_0_{i}", **motions)
    for i in range(length):
        model.measured_point(f"p{i}", float(i), -float(i))
    history = model.run().history
    omega = 2 * np.pi * frequency - 2j / duration
    weight = np.exp(-1j * omega * history.time.values)
    wave = weight @ _ricker_wavelet(frequency, history.time.values - delay)[0]
    motions = np.einsum("t,tpa->pa", weight, history.displacement.values) / wave
    tangents = np.arange(length)
    computed = np.linalg.norm(abs(motions), axis=1)
    exact = _LARGEST * abs(np.sin(omega / SPEED * tangents))
    return np.sqrt(2) * tangents[1:], computed[1:], exact[1:], computed[0]


@case(
    "Oblique waves on dashpots",
    "Dashpots ρV_p and ρV_s reflect a fraction of the energy of plane P and S waves, which arrive "
    "at 30° and 60° from the normal (ν = ¼, plane strain). The reflected amplitudes follow from "
    "stress = dashpot traction at the edge.",
    "Lysmer and Kuhlemeyer (1969); `docs/boundaries.md`.",
)
def oblique_waves(short: bool) -> Outcome:
    """Check reflections in periodic ground with motions at its top."""
    waves = [(wave, angle) for wave in (0, 1) for angle in (30.0, 60.0)]
    rows, lines = [], []
    for columns in (24,) if short else (24, 36):
        fractions = _reflected_energies(columns, waves)
        for (wave, angle), fraction in zip(waves, fractions, strict=True):
            exact = reflected_energy(wave, angle)
            label = f"{'PS'[wave]} wave at {angle:g}°, {columns} cells per period"
            rows.append(absolute(f"reflected energy, {label}", exact, fraction, 0.005))
            lines.append([label, f"{exact:.4f}", f"{fraction:.4f}"])
    angles = np.linspace(0.0, 80.0, 81)
    figure, (axes,) = canvas(1)
    for wave, color in ((0, BLUE), (1, RED)):
        curve = [reflected_energy(wave, angle) for angle in angles]
        axes.plot(angles, curve, color=color, label=f"{'PS'[wave]}, closed form")
        axes.plot([30, 60], [r.computed for r in rows[2 * wave : 2 * wave + 2]], "o", color=color)
    axes.set(xlabel="angle from the normal (°)", ylabel="reflected / incident energy",
        ylim=(0, 0.4))  # fmt: skip
    head = ["wave", "closed form", "computed"]
    return Outcome(rows, figure, [Table("Reflected / incident energy", head, lines)])


def reflected_energy(wave: int, angle: float) -> float:
    """Return the fraction of the energy of a P (0) or S (1) wave that dashpots reflect.

    The angle from the normal is in degrees.
    """
    speed = SPEEDS / SPEED
    slowness = np.sin(np.radians(angle)) / speed[wave]
    normal = _direction_cosines(slowness, speed)
    stiff = [[speed[0] ** 2, speed[0] ** 2 - 2], [speed[0] ** 2 - 2, speed[0] ** 2]]

    def imbalance(kind: int, cosine: complex):
        # (stress on the edge y = 0 − traction of the dashpots) / −iω
        direction = np.array([slowness * speed[kind], cosine])
        polarisation = direction if kind == 0 else np.array([cosine, -direction[0]])
        strain = direction * polarisation / speed[kind]
        shear = (direction[1] * polarisation[0] + direction[0] * polarisation[1]) / speed[kind]
        normal_stress = np.dot(stiff[1], strain)
        return np.array([normal_stress - speed[0] * polarisation[1], shear - polarisation[0]])

    matrix = np.column_stack([imbalance(kind, -normal[kind]) for kind in (0, 1)])
    amplitude = np.linalg.solve(matrix, -imbalance(wave, normal[wave]))
    flux = speed * normal.real
    return float(abs(amplitude) ** 2 @ flux / flux[wave])


def _direction_cosines(slowness: float, speed) -> np.ndarray:
    """Return the normal direction cosines of P and S waves; imaginary if evanescent."""
    normal = np.sqrt(1 - (slowness * np.asarray(speed)) ** 2 + 0j)
    return np.where(normal.imag > 0, -normal, normal)


def _reflected_energies(columns: int, waves) -> list[float]:
    """Return the reflected energy fractions of waves in ground of period `columns` × 1 m."""
    number = 2 * np.pi / columns
    rates = [number * SPEEDS[wave] / np.sin(np.radians(angle)) for wave, angle in waves]
    fields = [_displacement_field(columns, axis, number, rates) for axis in "xy"]
    fractions = []
    for i, ((wave, _), rate) in enumerate(zip(waves, rates, strict=True)):
        amplitudes = np.array([_wave_amplitudes(field[i], number, rate) for field in fields])
        # The rows belong to the two runs; a matrix maps incident to reflected amplitudes.
        incident, reflected = amplitudes[:, :2].T, amplitudes[:, 2:].T
        matrix = reflected @ np.linalg.inv(incident)
        flux = SPEEDS * _direction_cosines(number / rate, SPEEDS).real
        fractions.append(float(abs(matrix[:, wave]) ** 2 @ flux / flux[wave]))
    return fractions


def _wave_amplitudes(field, number: float, rate: float) -> np.ndarray:
    """Return amplitudes of downgoing P, S and upgoing P, S waves in a field, shape (rows, 2)."""
    height = np.arange(len(field)) + 0.5
    cosine = _direction_cosines(number / rate, SPEEDS)
    waves = []
    for sign in (-1, 1):
        for kind in (0, 1):
            direction = np.array([number * SPEEDS[kind] / rate, sign * cosine[kind]])
            polarisation = direction if kind == 0 else np.array([-direction[1], direction[0]])
            phase = np.exp(-1j * rate / SPEEDS[kind] * direction[1] * height)
            waves.append(np.outer(phase, polarisation).ravel())
    return np.linalg.lstsq(np.array(waves).T, field.ravel(), rcond=None)[0]


def _displacement_field(columns: int, axis: str, number: float, rates) -> list[np.ndarray]:
    """Return, for each frequency, displacements (rows, 2) that vary as exp(−ikx).

    A wavelet along `axis` moves the top.
    """
    rows = round(0.57 * columns)
    frequency = 0.5 * (min(rates) + max(rates)) / (2 * np.pi)
    step = 2 * np.pi / max(rates) / (_STEPS_PER_PERIOD // 2)
    duration = 6 / frequency + 10 * rows / SPEED
    model = _empty_model("oblique", POISSON, time_step=step, duration=duration)
    for j in range(rows):
        for i in range(columns):
            model.block(rectangle(i, j, 1, 1), name=f"b_{j}_{i}", body=_BODY)
    wavelet = _ricker_wavelet(frequency, np.arange(0.0, 3 / frequency, step) - 1.5 / frequency)[1]
    for i in range(columns + 1):
        values = np.cos(number * i) * wavelet
        model.motion(f"m{i}", values.tolist(), step, "acceleration", drift_order=0)
    for i in range(columns):
        for x in (i, i + 1):
            motions = {f"motion_{axis}": f"m{x}"}
            model.fixed_point(float(x), float(rows), f"b_{rows - 1}_{i}", **motions)
    rock = {"density": DENSITY, "pressure_velocity": SPEEDS[0], "shear_velocity": SPEEDS[1]}
    model.boundary("base", "viscous", side="bottom", **rock)
    model.boundary(kind="tied")
    phase = np.exp(1j * number * (np.arange(columns) + 0.5)) / columns
    transforms = np.zeros((len(rates), rows, 2), dtype=complex)
    with Simulation(model) as run:
        first, at_end = run.coordinates[:, :2].copy(), False
        while not at_end:
            at_end = run.advance(1)
            motions = (run.coordinates[:, :2] - first).reshape(rows, columns, 2)
            harmonic = np.einsum("jia,i->ja", motions, phase)
            transforms += np.exp(-1j * np.array(rates) * run.time)[:, None, None] * harmonic
    return list(transforms)
