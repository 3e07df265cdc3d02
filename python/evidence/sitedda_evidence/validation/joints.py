# SPDX-License-Identifier: GPL-3.0-or-later
"""Waves through elastic, slipping and closing joints, and a slope released by a shock."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import erf

from sitedda.report.style import BLUE, COLORS, GREEN, ORANGE, canvas

from .. import model as nml
from ..case import Outcome, Table, absolute, at_most, case, observed_order, relative

DENSITY, YOUNG = 2650.0, 60e9  # kg/m³, Pa, ν = 0
PENALTY = 100 * YOUNG  # N/m
GLUE = {"cohesion": 1e12, "tensile_strength": 1e12}  # Pa
PER_STEP = 0.25  # Δt / travel time of a wave through a block


@dataclass(frozen=True)
class Bar:
    """A bar of bonded blocks with an input motion at one end; it may contain other joints."""

    # ``"P"``: motion along the bar; ``"S"``: motion across it, with blocks that cannot rotate.
    wave: str = "P"
    size: float = 1.0  # length of a block, m; the bar is 1 m wide
    # `before`, `after`: number of blocks before and after the first joint.
    before: int = 180
    after: int = 180

    @property
    def modulus(self) -> float:
        """Return Young's or shear modulus of the bar, Pa."""
        return YOUNG if self.wave == "P" else 0.5 * YOUNG

    @property
    def speed(self) -> float:
        """Return the wave velocity, m/s."""
        return np.sqrt(self.modulus / DENSITY)

    @property
    def impedance(self) -> float:
        """Return the impedance ρc, Pa s/m."""
        return DENSITY * self.speed

    @property
    def time_step(self) -> float:
        """Return the time step, s."""
        return PER_STEP * self.size / self.speed

    def block_modulus(self) -> float:
        """Return Young's modulus (Pa) of blocks that compensates the compliance of contacts.

        Two contacts, with k_n along and k_n/2.5 across, are in series with each block.
        """
        stiffness = 2 * PENALTY / (1.0 if self.wave == "P" else 2.5)
        return YOUNG / (1 - self.modulus / (stiffness * self.size))

    def text(
        self, steps: int, displacement, spacing: float, joints: Sequence[int] = (), **law
    ) -> str:
        """Return the input with displacements (m) of the end at intervals `spacing` (s).

        The blocks `joints` have a joint of the given law at their left side.
        """
        angle = law.pop("friction_angle", 45.0)
        parts = [
            nml.control(self.time_step, steps, (0, 0), integration="midpoint"),
            nml.contact(PENALTY, fixed_point_ratio=10.0),
            nml.material("rock", DENSITY, self.block_modulus()),
            nml.joint("glued", 60.0, **GLUE),
            nml.joint("joint", angle, **law),
            nml.motion("wave", displacement, spacing, "displacement"),
        ]
        for i in range(self.before + self.after):
            outline = nml.rectangle(i * self.size, 0.0, self.size, 1.0)
            sides = ["glued"] * 3 + ["joint" if i in joints else "glued"]
            parts.append(nml.group("block", name=f"b{i}", vertices=outline, edge_joints=sides))
            if self.wave == "S":
                fixed = {"block": f"b{i}", "direction": "x"}
                parts += [nml.group("fixed_point", x=x, y=y, **fixed) for x, y in outline]
        axis = "x" if self.wave == "P" else "y"
        drive = {"direction": axis, f"motion_{axis}": "wave"}
        parts += [nml.group("fixed_point", x=0.0, y=y, block="b0", **drive) for y in (0.0, 1.0)]
        for name, i in (("before", self.before // 2), ("after", self.before + self.after // 2)):
            parts.append(nml.measured_point(name, ((i + 0.5) * self.size, 0.5), f"b{i}"))
        return "".join(parts)

    def run(self, *arguments, **law):
        """Return the history, and velocities (m/s) before and after the joints; see `text`."""
        data = nml.history(self.text(*arguments, **law))
        axis = 0 if self.wave == "P" else 1
        return data, *(data.velocity.sel(point=p).values[:, axis] for p in ("before", "after"))


def _smooth_step(bar: Bar, width: float):
    """Return a displacement (m) with Gaussian velocity of standard deviation `width` blocks.

    The second value is the sampling interval, s.
    """
    duration = 8 * width * bar.size / bar.speed
    time = np.linspace(0, duration, 401)
    spread = width * bar.size / bar.speed
    return 1e-7 * (1 + erf((time - duration / 2) / spread / np.sqrt(2))), float(time[1])


def _padded_spectrum(values: np.ndarray) -> np.ndarray:
    return np.fft.rfft(values, 16 * len(values))


@functools.cache
def _incident_wave(bar: Bar, width: float):
    """Return time (s) and both velocities (m/s) of the bar without joints."""
    displacement, spacing = _smooth_step(bar, width)
    steps = int(2.45 * min(bar.before, bar.after) / PER_STEP)
    data, before, after = bar.run(steps, displacement - displacement[0], spacing)
    return data.time.values, before, after


def _measure_transmission(bar: Bar, width: float, joints: Sequence[int], stiffness: float):
    """Return frequencies ω (rad/s), complex T and R of elastic joints, and the history."""
    displacement, spacing = _smooth_step(bar, width)
    time, before, after = _incident_wave(bar, width)
    stiffnesses = {"normal_stiffness_per_area": stiffness, "shear_stiffness_per_area": stiffness}
    data, before_joint, after_joint = bar.run(
        len(time) - 1, displacement - displacement[0], spacing, joints, **GLUE, **stiffnesses
    )
    omega = 2 * np.pi * np.fft.rfftfreq(16 * len(time), bar.time_step)
    with np.errstate(divide="ignore", invalid="ignore"):
        transmitted = _padded_spectrum(after_joint) / _padded_spectrum(after)
        reflected = _padded_spectrum(before_joint - before) / _padded_spectrum(before)
    return omega, transmitted, reflected, data


@case(
    "P and S waves through an elastic joint",
    "A joint of stiffness k per area lies between half-spaces of impedance Z = ρc. With ξ = ωZ/2k, "
    "T = 1/(1 + iξ), |R| = ξ/√(1 + ξ²), and the delay is atan(ξ)/ω. T is the ratio of the spectra "
    "of a pulse with and without the joint. The bar of bonded blocks is so long that its ends do "
    "not reflect within the run. The normal stiffness applies to P waves, the shear stiffness to "
    "S waves.",
    "Schoenberg (1980), J. Acoust. Soc. Am. 68; Pyrak-Nolte, Myer and Cook (1990), J. Geophys. "
    "Res. 95.",
)
def elastic_joint(short: bool) -> Outcome:
    """Check transmission, reflection and delay for several ξ, and the effect of the block size."""
    rows, curves = [], {}
    largest = 1.0 if short else 3.0
    for wave in "P" if short else "PS":
        bar = Bar(wave, before=110, after=110) if short else Bar(wave)
        curve, data = _measure_over_xi(bar, largest, 7.0)
        curves[wave] = curve
        marks = (0.1, 0.5, 1.0) if short else (0.1, 0.2, 0.5, 1.0, 2.0, 3.0)
        for mark in marks:
            xi, transmitted, reflected = curve[:, np.argmin(np.abs(curve[0].real - mark))]
            name = f"{wave}, ξ = {mark:g}"
            theory = 1 / (1 + 1j * xi)
            rows.append(relative(f"|T|, transmitted / incident, {name}", abs(theory),
                abs(transmitted), 1e-2))  # fmt: skip
            rows.append(relative(f"|R|, reflected / incident, {name}", abs(xi * theory),
                abs(reflected), 1e-2))  # fmt: skip
            rows.append(relative(f"phase delay ωτ (rad), {name}", np.arctan(xi.real),
                -np.angle(transmitted), 1e-2))  # fmt: skip
        rows.append(at_most(f"{wave} waves: energy residual / work", nml.energy_residual(data),
            1e-6))  # fmt: skip
    tables = [] if short else [_block_size_table()]
    figure, axes = canvas()
    for wave, (xi, transmitted, reflected) in curves.items():
        for axis, values, theory in (
            (axes[0], transmitted, 1 / np.sqrt(1 + xi.real**2)),
            (axes[1], reflected, xi.real / np.sqrt(1 + xi.real**2)),
        ):
            axis.plot(xi.real, theory, color="0.6", lw=3)
            axis.plot(xi.real, np.abs(values), color=BLUE if wave == "P" else ORANGE, label=wave)
    for axis, name in zip(axes, ("|T|", "|R|"), strict=True):
        axis.set(xlabel="ξ = ωZ/2k", ylabel=name, title="grey: theory")
    return Outcome(rows, figure, tables)


def _measure_over_xi(bar: Bar, largest: float, width: float, shortest: float = 20.0):
    """Return rows ξ, T, R from ξ = 0.1 to `largest`, and the history.

    At `largest`, the wavelength is `shortest` blocks.
    """
    stiffness = np.pi * bar.speed / (shortest * bar.size) * bar.impedance / largest
    joints = (bar.before,)
    omega, transmitted, reflected, data = _measure_transmission(bar, width, joints, stiffness)
    xi = omega * bar.impedance / (2 * stiffness)
    band = (xi > 0.09) & (xi < 1.02 * largest)
    return np.array([xi[band], transmitted[band], reflected[band]]), data


def _block_size_table() -> Table:
    """Tabulate the error at ξ = 1 for several numbers of blocks per wavelength."""
    counts, errors = (10, 20, 40), []
    for count in counts:
        bar = Bar("P", before=3 * count + 60, after=3 * count + 60)
        curve, _ = _measure_over_xi(bar, 1.0, 0.35 * count, count)
        xi, transmitted, reflected = curve[:, np.argmin(np.abs(curve[0].real - 1.0))]
        theory = 1 / (1 + 1j * xi)
        errors.append((abs(transmitted / theory - 1), abs(abs(reflected / (xi * theory)) - 1)))
    orders = observed_order([1 / count for count in counts], [error[0] for error in errors])
    return Table(
        "One joint at ξ = 1: relative error for several numbers of blocks per wavelength.",
        ("blocks", "error of complex T", "error of |R|", "order of T"),
        [(n, *error, order) for n, error, order in zip(counts, errors, orders, strict=True)],
    )


@case(
    "P waves through equal joints",
    "For N joints at the spacing d, |T| = [1 + ξ² sin²NΦ/sin²Φ]^(−1/2), cos Φ = cos kd − ξ sin kd. "
    "If |cos Φ| > 1, an infinite row transmits no waves; with ξ = ½ from d/λ = 0.3524 to ½.",
    "Transfer matrices of a layered medium; Pyrak-Nolte, Myer and Cook (1990).",
)
def joints_in_series(short: bool) -> Outcome:
    """Check the transmission of two and four joints at ξ = ½, and the stop band."""
    spacings = (0.1,) if short else (0.02, 0.1, 0.3, 0.5)
    rows, results = [], {}
    for spacing in spacings:
        # Distant joints reflect the wave for a long time, especially near the stop band.
        wave, length = {0.3: (50, 800), 0.5: (40, 1000)}.get(spacing, (50, 130 if short else 250))
        bar = Bar("P", before=length, after=length)
        stiffness = 2 * np.pi * bar.speed / (wave * bar.size) * bar.impedance
        for count in (2, 4):
            blocks = round(spacing * wave)
            joints = tuple(bar.before + i * blocks for i in range(count))
            omega, transmitted, _, data = _measure_transmission(bar, 0.14 * wave, joints, stiffness)
            results[spacing, count] = omega * bar.size * wave / (2 * np.pi * bar.speed), transmitted
            index = np.argmin(np.abs(results[spacing, count][0] - 1))
            theory = _series_transmission(0.5, 2 * np.pi * spacing, count)
            name = f"|T|, {count} joints, d/λ = {spacing:g}"
            rows.append(relative(name, theory, abs(transmitted[index]), 2e-2))
            if spacing == spacings[0] and count == 2:
                rows.append(at_most("energy residual / work", nml.energy_residual(data), 1e-6))
    if not short:
        edges = _stop_band(*(results[0.5, count] for count in (2, 4)))
        lower_end = brentq(lambda r: np.cos(np.pi * r) - 0.5 * r * np.sin(np.pi * r) + 1, 0.5, 0.95)
        for name, theory, end in zip(("lower", "upper"), (lower_end, 1.0), edges, strict=True):
            rows.append(relative(f"{name} end of the stop band, ω/ω(ξ = ½), d/λ = 0.5", theory, end,
                2e-2))  # fmt: skip
    figure, axes = canvas()
    extremes = (spacings[0], spacings[-1])
    for axis, spacing in zip(axes, extremes, strict=True):
        for count, color in ((2, BLUE), (4, GREEN)):
            ratio, transmitted = results[spacing, count]
            band = (ratio > 0.1) & (ratio < 2.0)
            angle = 2 * np.pi * spacing * ratio[band]
            theory = _series_transmission(0.5 * ratio[band], angle, count)
            axis.plot(ratio[band], theory, color="0.7", lw=3)
            axis.plot(ratio[band], np.abs(transmitted[band]), color=color, label=f"{count} joints")
        title = f"d/λ = {spacing:g} at ξ = ½; grey: theory"
        axis.set(xlabel="ω/ω(ξ = ½)", ylabel="|T|", title=title)
    return Outcome(rows, figure)


def _stop_band(two_joints, four_joints) -> tuple[float, float]:
    """Return the widest band of ω/ω(ξ = ½) with cos² 2Φ > 1, in which Φ is not real.

    With X_N = |T_N|⁻² − 1, X₄/X₂ = 4 cos² 2Φ.  The arguments are (ω/ω(ξ = ½), T) of two and four
    joints.
    """
    ratio = two_joints[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        squares = [np.abs(transmitted) ** -2 - 1 for _, transmitted in (two_joints, four_joints)]
        stopped = (squares[1] > 4 * squares[0]) & (ratio > 0.4) & (ratio < 1.2)
    turns = np.flatnonzero(np.diff(stopped))
    widest = np.argmax(np.where(stopped[turns[:-1] + 1], np.diff(turns), 0))
    return float(ratio[turns[widest]]), float(ratio[turns[widest + 1]])


def _series_transmission(xi, angle, count: int):
    """Return the theoretical |T| of `count` joints with kd = `angle`."""
    phase = np.arccos((np.cos(angle) - xi * np.sin(angle)).astype(complex))
    return 1 / np.sqrt(1 + np.real((xi * np.sin(count * phase) / np.sin(phase)) ** 2))


@case(
    "S waves through a joint that slips: energy",
    "A joint of strength τ_s transmits an incident velocity v = v₀ sin ωt clipped at ± τ_s/ρc."
    " With a = τ_s/(ρc v₀) and sin θ = a, T² = (4/π)[θ/2 − sin 2θ/4 + a²(π/2 − θ)], R² = ∫(v −"
    " clipped v)²/∫v² and A² = 1 − T² − R². The ratio of work of friction to incident energy is"
    " A². The joint law is `'mohr_coulomb'` without friction, with constant cohesion.",
    "Miller (1978), Bull. Seism. Soc. Am. 68; the closed form is elementary.",
)
def plastic_joint(short: bool) -> Outcome:
    """Check T, R, A and the work of friction for several ratios of strength to incident stress."""
    ratios = (0.5,) if short else (0.3, 0.5, 0.65, 0.8)
    bar = Bar("S", before=130, after=130) if short else Bar("S", before=250, after=250)
    wave = 50 if short else 100  # blocks in a wavelength
    period = wave * bar.size / bar.speed
    time = np.linspace(0, period, 801)
    speed, steps = 0.1, int((1.5 * bar.before + 1.3 * wave) / PER_STEP)
    displacement = speed * period / (2 * np.pi) * (1 - np.cos(2 * np.pi * time / period))
    _, reference_before, reference_after = bar.run(steps, displacement, time[1])
    rows, last_run, computed = [], None, {name: [] for name in "TRA"}
    for ratio in ratios:
        strength = ratio * bar.impedance * speed
        law = {"law": "mohr_coulomb", "friction_angle": 0.0, "weakening_slip": 1.0,
               "cohesion": strength, "residual_cohesion": strength, "tensile_strength": 1e12,
               "residual_tensile_strength": 1e12, "normal_stiffness_per_area": 2 * PENALTY,
               "shear_stiffness_per_area": PENALTY}  # fmt: skip
        data, before, after = bar.run(steps, displacement, time[1], (bar.before,), **law)
        incident = np.sum(reference_after**2)
        transmitted = np.sum(after**2) / incident
        reflected = np.sum((before - reference_before) ** 2) / np.sum(reference_before**2)
        coefficients = np.sqrt([transmitted, reflected, 1 - transmitted - reflected])
        for name, theory, value in zip("TRA", clipped_sine(ratio), coefficients, strict=True):
            rows.append(relative(f"coefficient {name}, a = {ratio:g}", theory, value, 1e-2))
            computed[name].append(value)
        energy = bar.impedance * np.sum(reference_after**2) * bar.time_step
        work = float(data.energy_friction[-1]) / energy
        rows.append(relative(f"work of friction / incident energy, a = {ratio:g}",
            clipped_sine(ratio)[2] ** 2, work, 5e-3))  # fmt: skip
        rows.append(at_most(f"energy residual / work, a = {ratio:g}", nml.energy_residual(data),
            1e-6))  # fmt: skip
        last_run = data.time.values, reference_after, after, ratio
    return Outcome(rows, _draw_slipping_joint(last_run, speed, ratios, computed))


def clipped_sine(ratio: float) -> np.ndarray:
    """Return T, R and A for a strength of `ratio` times the incident stress."""
    theta = np.arcsin(ratio)
    transmitted = theta / 2 - np.sin(2 * theta) / 4 + ratio**2 * (np.pi / 2 - theta)
    # ∫ (sin − a)² from θ to π/2, of ∫ sin² = π/4
    reflected = (np.pi / 2 - theta) / 2 + np.sin(2 * theta) / 4 - 2 * ratio * np.cos(theta)
    reflected += ratio**2 * (np.pi / 2 - theta)
    transmitted, reflected = 4 / np.pi * transmitted, 4 / np.pi * reflected
    return np.sqrt([transmitted, reflected, 1 - transmitted - reflected])


def _draw_slipping_joint(last_run, speed: float, ratios, coefficients):
    figure, (left, right) = canvas()
    time, incident, transmitted, ratio = last_run
    left.plot(1e3 * time, incident / speed, color="0.7", label="without the joint")
    left.plot(1e3 * time, transmitted / speed, color=BLUE, label=f"a = {ratio:g}")
    left.set(xlabel="time (ms)", ylabel="v / v₀", title="transmitted wave")
    fine = np.linspace(0.01, 0.99, 99)
    theory = np.array([clipped_sine(a) for a in fine])
    for i, (name, color) in enumerate(zip("TRA", COLORS, strict=False)):
        right.plot(fine, theory[:, i], color=color, label=name)
        right.plot(ratios, coefficients[name], "o", color=color)
    right.set(xlabel="a = τ_s/(ρc v₀)", ylabel="coefficient", title="lines: theory, points: engine")
    return figure


@case(
    "A pulse through a joint of hyperbolic closure",
    "A half-sine P pulse of 50 Hz through a joint σ = k_ni δ/(1 − δ/V_m): the transmitted velocity "
    "obeys dv/dt = (2k_ni/Z)(v_I − v)(1 + Z v/(k_ni V_m))². A larger fraction of a larger pulse is "
    "transmitted.",
    "Method of characteristics, as Zhao and Cai (2001), Int. J. Rock Mech. Min. Sci. 38.",
)
def closing_joint(short: bool) -> Outcome:
    """Check the peak of the transmitted pulse for three amplitudes."""
    speeds = (0.05,) if short else (1e-3, 0.05, 0.3)
    size = 2.0 if short else 1.0
    bar = Bar("P", size, int(60 / size), int(130 / size))
    stiffness, closure, period = 3.5e9, 0.61e-3, 0.02
    time = np.linspace(0, period / 2, 401)
    steps = int(((bar.before + 0.5 * bar.after) * size / bar.speed + 0.55 * period) / bar.time_step)
    law = {"law": "barton_bandis", "jrc": 0.0, "jcs": 1e8, "max_closure": closure,
           "normal_stiffness_per_area": stiffness}  # fmt: skip
    rows, lines = [], []
    for speed in speeds:
        displacement = speed * period / (2 * np.pi) * (1 - np.cos(2 * np.pi * time / period))
        data, _, after = bar.run(steps, displacement, time[1], (bar.before,), **law)
        theory = _transmitted_velocity(bar, speed, period, stiffness, closure)
        name = f"largest v/v₀ behind the joint, v₀ = {speed:g} m/s"
        rows.append(relative(name, theory.y[0].max() / speed, after.max() / speed, 1e-2))
        rows.append(at_most(f"energy residual / work, v₀ = {speed:g} m/s",
            nml.energy_residual(data), 1e-6))  # fmt: skip
        lines.append((speed, data.time.values, after, theory))
    figure, (axes,) = canvas(columns=1)
    for (speed, times, after, theory), color in zip(lines, COLORS, strict=False):
        arrival = (bar.before + bar.after // 2 + 0.5) * size / bar.speed
        axes.plot(1e3 * theory.t, theory.y[0] / speed, color="0.7", lw=3)
        axes.plot(1e3 * (times - arrival), after / speed, color=color, label=f"{speed:g} m/s")
    axes.set(xlabel="time after arrival (ms)", ylabel="v / v₀", xlim=(-1, 11), title="grey: theory")
    return Outcome(rows, figure)


def _transmitted_velocity(bar: Bar, speed: float, period: float, stiffness: float, closure: float):
    """Return the solution (scipy) of the differential equation of the transmitted velocity."""

    def rate(t, v):
        incident = speed * np.sin(2 * np.pi * t / period)
        slope = (1 + bar.impedance * v / (stiffness * closure)) ** 2
        return 2 * stiffness / bar.impedance * (incident - v) * slope

    exact = {"rtol": 1e-9, "atol": 1e-12 * speed, "max_step": period / 2000}
    return solve_ivp(rate, (0, period / 2), [0.0], **exact)


@case(
    "A slope released by a shock",
    "The peak strength of a joint holds a block on a plane. A load breaks the joint; the block"
    " then slides at the residual strength with the acceleration g sin α − g cos α tan φ_r.",
    "Coulomb friction.",
)
def released_slope(short: bool) -> Outcome:
    """Check equilibrium before the load and the acceleration after it."""
    rows, lines = [], []
    cases = ((30.0, 40.0, 20.0), (25.0, 32.0, 22.0), (40.0, 60.0, 15.0))
    for angle, peak, residual in cases[:1] if short else cases:
        slope = np.radians(angle)
        direction = np.array([np.cos(slope), -np.sin(slope)])
        shape = nml.rotated(nml.rectangle(0, 0, 2, 1), -slope)
        x, y = shape.mean(axis=0)
        force = np.outer(0.8 * nml.GRAVITY * 2 * DENSITY * direction, [0, 1, 1, 0])
        text = nml.text(
            nml.control(1e-3, 1000, settle=True, max_displacement_ratio=0.05),
            nml.contact(1e10),
            nml.material("rock", DENSITY, 1e12),
            nml.joint("j", peak, law="mohr_coulomb", residual_friction_angle=residual),
            nml.fixed_block("base", nml.rotated(nml.rectangle(-2, -1, 40, 1), -slope), "rock", "j"),
            nml.block("top", shape, "rock", "j"),
            nml.group("load", x=x, y=y, block="top", time=(0.2, 0.21, 0.3, 0.31), force_x=force[0],
                      force_y=force[1]),
            nml.measured_point("top", (x, y), "top"),
        )  # fmt: skip
        data = nml.history(text)
        along = data.displacement.sel(point="top").values @ direction
        time = data.time.values
        sliding = time >= 0.35
        fit = np.polyfit(time[sliding] - 0.35, along[sliding], 2)
        theory = nml.GRAVITY * (np.sin(slope) - np.cos(slope) * np.tan(np.radians(residual)))
        label = f"slope {angle:g}°, φ {peak:g}° to {residual:g}°"
        rows += [
            absolute(f"displacement before the load, {label}", 0.0, along[time < 0.2][-1], 1e-6,
                "m"),
            relative(f"acceleration of sliding, {label}", theory, 2 * fit[0], 1e-3, "m/s²"),
            at_most(f"energy residual / work, {label}", nml.energy_residual(data), 1e-6),
        ]  # fmt: skip
        lines.append((label, time, along))
    figure, (axes,) = canvas(columns=1)
    for (label, time, along), color in zip(lines, COLORS, strict=False):
        axes.plot(time, along, color=color, label=label)
    axes.axvspan(0.2, 0.31, color="0.9")
    axes.set(xlabel="time (s)", ylabel="slip (m)", title="grey: load")
    return Outcome(rows, figure)
