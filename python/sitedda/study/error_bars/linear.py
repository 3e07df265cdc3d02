# SPDX-License-Identifier: GPL-3.0-or-later
"""Error bars of a linear run from the exact transfer function of the scheme, without other runs.

If no contact has changed its state, a transfer function H(ω, Δt, k_n) relates the motion of a
measured point to the motion of the base.  At Δt/16, the spectrum of the motion of the point is
multiplied by H(ω, Δt/16)/H(ω, Δt).  The computing time does not depend on the time step.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.fft import irfft, rfft, rfftfreq

from ...engine.checking import transfer
from ...engine.signals import fast_length, low_pass, spectral_acceleration
from ...engine.simulation import Simulation
from ...output.verdict import PERIODS, SPECTRUM_DAMPING, run_scheme, verdict
from .bars import bar_of_steps, penalty_error
from .figures import Figure, figure_of, is_figure
from .variants import Facts, finer, stiffer

_STEPS = (16, 32, 64)  # divisors of Δt
_INTERPOLATION = 2  # factor of interpolation, because peaks of acceleration occur between samples
_PEAK_FRACTION = 0.7  # smallest Sa / largest Sa of periods at which smaller steps are evaluated
_CONTENT = 0.999999  # fraction of the energy below the highest evaluated frequency
_DECAYED = 1e-3  # a motion has ended if its last twentieth is below this fraction of the peak
_GRID = 400  # number of frequencies in each search of a peak
_REFINED = 4  # number of times that the search is refined around the peak
NO_BAR = "no error bar: in a linear run only measured points have error bars"
_AXES = ("x", "y")


@dataclass(frozen=True)
class _Point:
    """Motion of a measured point along the axis of its largest velocity."""

    name: str
    axis: str  # ``'x'`` or ``'y'``
    velocity: np.ndarray  # m/s
    acceleration: np.ndarray  # m/s²


def is_linear(history, facts: Facts) -> bool:
    """Return whether a run was linear and excited only by motion of its base along one axis.

    `history`: histories of the run; `facts`: properties of the input.
    """
    groups = facts.groups
    control = next(iter(groups.get("control", [])), {})
    axes = {key[-1] for group in [control, *groups.get("fixed_point", []),
                                   *groups.get("boundary", [])]
             for key, value in group.items()
             if key.startswith(("motion_", "base_motion_")) and value}  # fmt: skip
    loaded = any(name in groups for name in ("load", "traction", "water", "bolt", "stage"))
    at_rest = not any(control.get("gravity", ())) or control.get("settle", False)
    return (
        history.attrs.get("contacts_changed") == "no"
        and control.get("time_step_control", "fixed") != "adaptive"
        and all(soil.get("law", "linear") == "linear" for soil in groups.get("material", []))
        and at_rest and not loaded and len(axes) == 1 and history.sizes.get("point", 0) > 0
    )  # fmt: skip


def linear_figures(model, changes: Mapping, history, facts: Facts) -> dict[str, Figure]:
    """Return the results of a linear run with their error bars.

    `model`, `changes`, `history`, `facts`: see `sitedda.error_bars.measure.of_linear_run`.
    """
    variants = [finer(facts, times) for times in (1, *_STEPS)]
    variants += [stiffer(facts)] if facts.penalty else []
    outcome = verdict(history)
    values = outcome.values
    names = [name for line in outcome.figures for name in (line.largest, line.end) if name]
    if "amplification" in names:
        names.append("amplification_frequency_hz")
    no_bar = (math.nan, math.nan, math.nan, 0.0, NO_BAR)
    table = {name: Figure(name, values[name], values[name], *no_bar)
             for name in names if is_figure(name, values)}  # fmt: skip
    step = float(history.time.values[-1]) / (history.sizes["time"] - 1)
    run_step = float(np.max(history.time_step.values[1:]))
    highest = 0.499 / run_step  # highest frequency resolved by Δt, Hz
    points = _measured_points(history)
    padding = 1 if all(map(_has_died_out, points)) else 2  # zero padding, against periodic response
    length = fast_length(padding * history.sizes["time"])
    length += length % 2
    frequency = rfftfreq(length, step)
    numbers: list[dict[str, float]] = []
    cache: dict = {}
    spectra: dict = {}
    chi = run_scheme(history).chi
    for variant, divisor in zip(variants, (1, *_STEPS, 1), strict=False):
        numbers.append({})
        rates = partial(_rate_ratios, step=run_step / divisor, chi=chi)
        with Simulation(model, changes={**changes, **variant}) as simulation:
            for point in points:
                resolved = min(0.9 * highest, values[f"resolved_frequency_hz[{point.name}]"])
                velocity, acceleration = _point_motion(
                    simulation, point, frequency, highest, cache, rates
                )
                times = min(divisor, _INTERPOLATION)
                numbers[-1] |= _point_results(
                    point, velocity, acceleration, step, resolved, times, spectra
                )
            for group in facts.groups.get("amplification", []):
                numbers[-1] |= _exact_peak(simulation, group, highest)
    axes = {point.name: point.axis for point in points}
    for name in numbers[0].keys() & table.keys():
        if not _is_along_axis(axes, name, values):
            continue
        scale = values[name] / numbers[0][name] if "[" in name else 1.0
        value, *steps = (scale * row[name] for row in numbers)
        coarse, medium, fine, *stiffer_run = steps
        penalty = penalty_error(value, stiffer_run[0]) if stiffer_run else 0.0
        bar = bar_of_steps(coarse, medium, fine, facts.order)
        figure = figure_of(name, (coarse, medium, fine), bar, penalty, _STEPS)
        table[name] = replace(figure, run=value)
    return table


def _is_along_axis(axes: Mapping, name: str, values: Mapping) -> bool:
    """Return whether a result, the larger of both axes, belongs to the axis of its point."""
    measure, _, point = name.partition("[")
    key = f"{measure}_{axes.get(point[:-1])}[{point}"
    return values.get(key, values[name]) == values[name]


def _measured_points(history) -> list[_Point]:
    """Return the motion of each measured point along the axis of its largest velocity."""
    points = []
    for name in map(str, history.point.values):
        velocity = history.velocity.sel(point=name).values
        axis = int(np.argmax(np.abs(velocity).max(axis=0)))
        acceleration = history.acceleration.sel(point=name).values
        points.append(_Point(name, _AXES[axis], velocity[:, axis], acceleration[:, axis]))
    return points


def _has_died_out(point: _Point) -> bool:
    """Return whether the acceleration of a point is small at the end of the run; see `_DECAYED`."""
    final = point.acceleration[-(len(point.acceleration) // 20 + 1) :]
    return bool(np.abs(final).max() < _DECAYED * np.abs(point.acceleration).max())


def _rate_ratios(frequency: np.ndarray, step: float, chi: float) -> tuple[np.ndarray, np.ndarray]:
    """Return v/(iω u) and a/(iω v) of harmonic motions in the time integration.

    v₁ = (u₁ − u₀)/(χΔt) − (1 − χ) v₀/χ, a₁ = (v₁ − v₀)/Δt; frequencies in Hz, `step` Δt in s.
    """
    phase = 2j * np.pi * frequency * step
    factor = np.exp(phase)
    velocity = (factor - 1.0) / (chi * factor + 1.0 - chi) / phase
    return velocity, (1.0 - 1.0 / factor) / phase


def _point_motion(simulation, point: _Point, frequency: np.ndarray, highest: float, cache: dict,
           rates: Callable):  # fmt: skip
    """Return velocity (m/s) and acceleration (m/s²) of a point with the Δt and k_n of a variant.

    The difference from the run is computed, because the velocity may not be 0 at the end.
    """
    length = 2 * (len(frequency) - 1)
    spectrum = rfft(point.acceleration, length)
    if point.name not in cache:  # the transfer function of the run itself
        energy = np.cumsum(np.abs(spectrum) ** 2)
        index = np.searchsorted(energy, _CONTENT * energy[-1])
        cache[point.name] = (np.arange(1, min(index + 1, np.searchsorted(frequency, highest))),
                             None)  # fmt: skip
    band, reference = cache[point.name]
    response = transfer(simulation, frequency[band], point.name, None, point.axis)
    velocity, acceleration = rates(frequency[band])
    response = response * velocity, response * velocity * acceleration
    if reference is None:
        cache[point.name], reference = (band, response), response
    band_spectrum = np.zeros_like(spectrum)
    band_spectrum[band] = spectrum[band] * (response[1] / reference[1] - 1.0)
    change = irfft(band_spectrum, length)[: len(point.velocity)]
    of_run = spectrum[band] * reference[0] / reference[1] / (2j * np.pi * frequency[band])
    band_spectrum[band] = of_run * (response[0] / reference[0] - 1.0)
    faster = irfft(band_spectrum, length)[: len(point.velocity)]
    return point.velocity + faster - faster[0], point.acceleration + change


def _point_results(
    point, velocity, acceleration, step, resolved, refinement, spectra
) -> dict[str, float]:
    """Return the results of a point under the names of the verdict.

    A low-pass filter removes frequencies above `resolved`, Hz.  Peaks are those of the acceleration
    interpolated to `refinement` as many samples; `spectra` contains the periods with large Sa.
    """
    length = fast_length(2 * len(acceleration))
    length += length % 2
    spectrum = rfft(acceleration, length) * low_pass(length, step, resolved)
    resampled = refinement * irfft(spectrum, refinement * length)[: refinement * len(acceleration)]
    acceleration = irfft(spectrum, length)[: len(acceleration)]
    evaluated = spectra.setdefault(point.name, [])
    periods = PERIODS[np.any(evaluated, axis=0)] if len(evaluated) == 2 else PERIODS
    sa = spectral_acceleration(acceleration, step, periods, SPECTRUM_DAMPING)
    if len(evaluated) < 2:
        evaluated.append(sa > _PEAK_FRACTION * sa.max())
    results = {
        "pgv_m_s": np.abs(velocity).max(),
        "pga_resolved_m_s2": np.abs(resampled).max(),
        "arias_resolved_m_s": float(acceleration @ acceleration),
        "sa_resolved_m_s2": sa.max(),
    }
    return {f"{name}[{point.name}]": float(value) for name, value in results.items()}


def _exact_peak(simulation: Simulation, group: Mapping, highest: float) -> dict[str, float]:
    """Return the peak of the transfer function of an &amplification up to `highest`, Hz."""
    low, high = group["lowest"], min(group["highest"], highest)
    surface, base = group.get("surface", "surface"), group.get("base", "base")
    for _ in range(1 + _REFINED):
        grid = np.linspace(low, high, _GRID)
        ratio = abs(transfer(simulation, grid, surface, base, group.get("direction", "x")))
        peak = int(np.argmax(ratio))
        low, high = grid[max(peak - 1, 0)], grid[min(peak + 1, _GRID - 1)]
    return {"amplification": float(ratio[peak]), "amplification_frequency_hz": float(grid[peak])}
