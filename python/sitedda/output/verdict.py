# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict of a run: texts of its output, and results computed from it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ..base.numbers import counted, length, number
from ..engine.damping import damping_of
from ..engine.scheme import Scheme, scheme_damping
from ..engine.signals import spectral_acceleration
from ..input.input_text import input_values
from .response import amplifications
from .scene import Scene
from .verdict_lines import Doubt, ResultRow, Verdict

if TYPE_CHECKING:
    import xarray as xr

PERIODS = np.geomspace(0.02, 5.0, 80)  # periods of response spectra, s
SPECTRUM_DAMPING = 0.05
_LEAST_DRIFT = 1e-6  # smaller drifts are not reported
_MOST_FRAMES = 200  # largest number of frames that are searched for the first fallen block


def verdict(source, bars=None) -> Verdict:
    """Return the verdict of a run: motion, contacts, lost blocks, points, damping, warnings.

    Parameters
    ----------
    source : path, Run, xarray.Dataset or Scene
        An output.
    bars : Accuracy, optional
        Error bars of the results.
    """
    scene = Scene.of(source)
    result = Verdict(bars=bars, steps=str(scene.data.attrs.get("step_control", "")))
    add_fallen(result, scene)
    add_lost(result, scene)
    _add_engine_results(result, scene.data)
    add_drift(result, scene)
    add_sides(result, scene.data)
    add_damping(result, scene.data)
    return result


def acceleration_spectrum(acceleration, step: float) -> np.ndarray:
    """Return Sa of a motion (m/s², every `step` s) at `PERIODS`, shape (periods,), m/s²."""
    return _cached_spectrum(np.ascontiguousarray(acceleration, dtype=float).tobytes(), step)


@lru_cache(maxsize=32)
def _cached_spectrum(data: bytes, step: float) -> np.ndarray:
    """Return Sa (m/s²) at `PERIODS` of an acceleration that is given as bytes, from a cache."""
    return spectral_acceleration(np.frombuffer(data), step, PERIODS, SPECTRUM_DAMPING)


def resolved_frequency(history: xr.Dataset) -> float:
    """Return the highest frequency that the blocks resolve, Hz; 0 if not in the output."""
    values = [v for n, v in history.attrs.items() if n.startswith("resolved_frequency_hz[")]
    return float(min(values, default=0.0))


def main_axis(motion: np.ndarray) -> int:
    """Return the axis (0 x, 1 y) with the largest value of a history, shape (time, axis)."""
    return int(np.argmax(np.abs(motion).max(axis=0)))


def run_scheme(history: xr.Dataset) -> Scheme:
    """Return the time integration scheme of a run."""
    groups = input_values(history.attrs)
    return Scheme.of_control(next(iter(groups.get("control", [])), {}))


def run_step(history: xr.Dataset) -> float:
    """Return the largest time step of a run, s; 0 if it has static stages only."""
    steps = history.time_step.values[1:][np.diff(history.time.values) > 0]
    return float(np.max(steps, initial=0.0))


def describe_damping(history: xr.Dataset, *frequencies: float) -> str:
    """Describe the damping of a model at frequencies (Hz) in one line."""
    step = run_step(history)
    if not step:
        return "static stages only: damping has no effect"
    scheme = run_scheme(history)
    ratios = [scheme_damping(f, step, scheme) if f < 0.5 / step else np.nan for f in frequencies]
    text = ", ".join(
        f"{100 * float(r):.2g} % at {f:.3g} Hz" for r, f in zip(ratios, frequencies, strict=True)
    )
    has_damping = any(map(damping_of, input_values(history.attrs).get("material", [])))
    material = "as in the input" if has_damping else "none"
    return (f"damping ratio of the scheme {text} (Δt = {1e3 * step:.3g} ms); damping of the "
            f"materials: {material}")  # fmt: skip


def _add_engine_results(result: Verdict, data: xr.Dataset) -> None:
    """Add the parts of the verdict that the engine has written into the output."""
    for name, value in data.attrs.items():
        if isinstance(value, float | np.floating):
            result.values[name] = float(value)
    text = str(data.attrs.get("verdict", ""))
    result.clauses.append(f"{text[:1].lower()}{text[1:]}")
    rows = (line.split("\t") for line in str(data.attrs.get("figures", "")).splitlines())
    result.figures.extend(ResultRow(*row) for row in rows if len(row) == 5)
    result.doubts.extend(Doubt.lines(str(data.attrs.get("doubts", ""))))


def add_drift(result: Verdict, scene: Scene) -> None:
    """Add the drift: relative horizontal displacement of top and bottom block / their distance."""
    start = scene.coordinates(0)
    low, high = int(np.argmin(start[:, 1])), int(np.argmax(start[:, 1]))
    height = start[high, 1] - start[low, 1]
    if height <= 0:
        return
    displacement = scene.displacement(scene.frames - 1)[:, 0]
    drift = (displacement[high] - displacement[low]) / height
    result.values["residual_drift"] = float(drift)
    pair = f"{scene.names[high]} relative to {scene.names[low]}"
    if scene.body[low] == scene.body[high] > 0:
        pair = f"top of {scene.names[high]} relative to its bottom"
    if abs(drift) >= _LEAST_DRIFT:
        shift = length(displacement[high] - displacement[low])
        label = f"{pair}: {shift} in a height of {number(height)} m"
        result.add_result("drift of blocks", "residual_drift", drift, "%", label, end=True)


def add_fallen(result: Verdict, scene: Scene) -> None:
    """Add blocks and bodies that have fallen."""
    first_of, body, sizes = bodies = _group_bodies(scene)
    lost = np.sort(first_of[have_fallen(scene, scene.frames - 1, bodies)[first_of]])
    if len(lost) == 0:
        return
    sample = np.unique(
        np.linspace(0, scene.frames - 1, min(scene.frames, _MOST_FRAMES)).astype(int)
    )
    frame = next((f for f in sample if have_fallen(scene, f, bodies).any()), scene.frames - 1)
    result.add_clause(
        f"{len(lost)} of {len(sizes)} blocks are displaced by more than their size at the end, the "
        f"first by t = {number(scene.time[frame])} s: "
        + ", ".join(f"{scene.names[b]} ({number(sizes[body[b]], 3)} m²)" for b in lost[:5])
        + (" …" if len(lost) > 5 else ""),
        blocks_fallen=len(lost),
        first_block_fallen_s=scene.time[frame],
    )


def have_fallen(scene: Scene, frame: int, bodies=None) -> np.ndarray:
    """Return whether blocks, or bodies of cells, have moved by more than their size.

    The movement is relative to the lowest body.  The shape is (blocks,).
    """
    _, body, sizes = bodies or _group_bodies(scene)
    areas, lowest_body = scene.areas(), body[int(np.argmin(scene.coordinates(0)[:, 1]))]
    displacements = [np.bincount(body, areas * axis) / sizes
                     for axis in scene.displacement(frame)[:, :2].T]  # fmt: skip
    distance = np.hypot(displacements[0] - displacements[0][lowest_body],
                        displacements[1] - displacements[1][lowest_body])  # fmt: skip
    return (distance > np.sqrt(sizes))[body]


def _group_bodies(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the first block of each body, the body of each block, and areas of bodies (m²)."""
    labels = -np.arange(1, scene.blocks + 1)
    _, first_of, body = np.unique(
        np.where(scene.body > 0, scene.body, labels), return_index=True, return_inverse=True
    )
    return first_of, body, np.bincount(body, scene.areas())


def add_lost(result: Verdict, scene: Scene) -> None:
    """Add blocks that have left the model."""
    lost = scene.lost(scene.frames - 1)
    if len(lost) == 0:
        return
    first = next(frame for frame in range(scene.frames) if len(scene.lost(frame)))
    names = ", ".join(scene.names[b] for b in lost[:5]) + (" …" if len(lost) > 5 else "")
    result.add_clause(
        f"{counted(len(lost), 'block', 'blocks')} left the model, the first by t = "
        f"{number(scene.time[first])} s: {names}",
        blocks_lost=len(lost),
        first_block_lost_s=scene.time[first],
    )


def add_sides(result: Verdict, data: xr.Dataset) -> None:
    """Add the largest difference of velocity between each side and its free field, at the top."""
    for i, kind in enumerate(data["boundary_kind"].values if "boundary_kind" in data else ()):
        if kind != "free_field":
            continue
        side = data.isel(boundary=i)
        peak = np.linalg.norm(side.incoming_velocity.values, axis=1).max()
        difference = side.boundary_velocity.values - side.incoming_velocity.values
        if not peak > 0:
            continue
        name = str(side.boundary.values)
        departure = np.linalg.norm(difference, axis=1).max() / peak
        label = f"{name}, divided by its peak velocity"
        result.add_result("side velocity error", f"side_departure[{name}]", departure, "%", label)


def add_damping(summary: Verdict, data: xr.Dataset) -> None:
    """Add the peak of each requested amplification, and the damping at its frequency."""
    try:
        peaks = [result.peak for result in amplifications(data)]
    except (KeyError, ValueError):
        return
    for peak in peaks:
        summary.values["amplification_frequency_hz"] = peak.frequency
        label = f"at {number(peak.frequency)} Hz; {describe_damping(data, peak.frequency)}"
        summary.add_result("peak amplification", "amplification", peak.amplitude, "", label)
