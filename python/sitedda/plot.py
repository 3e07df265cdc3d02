"""Pictures of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .column import damped_amplification, scheme_damping
from .drawing import new_figure, save
from .response import Amplification, layered_twin
from .signals import smooth_konno_ohmachi

if TYPE_CHECKING:
    import xarray as xr

BASE, SURFACE, TWIN = "0.55", "tab:blue", "tab:red"


def site_response(history: xr.Dataset, result: Amplification, file, discrete=None) -> Path:
    """Draw base and surface motion and the amplification with the one-dimensional theory over it.

    Parameters
    ----------
    history : xarray.Dataset
        Of a finished run.
    result : Amplification
    file : path
        Picture to write.
    discrete : ndarray, optional
        The model's own discrete transfer function at ``result.frequency``.
    """
    figure, (above, below) = new_figure(2, 1, (9, 7), height_ratios=[2, 3])
    _motions(above, history, result)
    below.plot(result.frequency, result.ratio, color=SURFACE, lw=1.4, label="DDA, time domain")
    _smoothed(below, result)
    if discrete is not None:
        label = "DDA, exact discrete theory"
        below.plot(result.frequency, abs(discrete), color="k", lw=1.0, ls=":", label=label)
    _theory(below, history, result)
    peak = result.peak
    below.plot(peak.frequency, peak.amplitude, "o", color=SURFACE, ms=5)
    below.annotate(
        f"{peak.amplitude:.2f} at {peak.frequency:.2f} Hz",
        (peak.frequency, peak.amplitude),
        xytext=(12, -4),
        textcoords="offset points",
    )
    below.set(
        xlabel="frequency (Hz)",
        ylabel=f"amplification {result.surface} / {result.base}",
        xlim=(result.frequency[0], result.frequency[-1]),
        ylim=(0, None),
    )
    below.legend(frameon=False, loc="upper left")
    figure.suptitle(history.attrs.get("title", ""))
    return save(figure, file)


def _smoothed(axes, result: Amplification) -> None:
    """The curve smoothed, for the eye; the peak is read from the raw one."""
    # Centres on the bins themselves, so that no window is empty, however coarse the spectrum.
    centres = result.frequency[:: max(1, result.frequency.size // 300)]
    try:
        curve = smooth_konno_ohmachi(result.frequency, result.ratio, 40.0, centres)
    except ImportError:
        return
    axes.plot(centres, curve, color=BASE, lw=1.0, label="smoothed, Konno–Ohmachi, b = 40")


def record_panels(motion: xr.Dataset, file) -> Path:
    """Draw acceleration, velocity and displacement of a record, one above the other.

    Parameters
    ----------
    motion : xarray.Dataset
        Of `sitedda.read_record`.
    file : path
        Picture to write.
    """
    figure, panels = new_figure(3, 1, (9, 6), sharex=True)
    units = ("m/s²", "m/s", "m")
    for axes, name, unit in zip(
        panels, ("acceleration", "velocity", "displacement"), units, strict=True
    ):
        series = motion[name].values
        peak = int(abs(series).argmax())
        axes.axhline(0.0, color="0.8", lw=0.6)
        axes.plot(motion.time, series, color=SURFACE, lw=0.7)
        axes.plot(motion.time[peak], series[peak], "o", color=TWIN, ms=4)
        axes.set_ylabel(f"{name} ({unit})")
        axes.set_title(f"largest {abs(float(series[peak])):.4g} {unit}", loc="right", fontsize=9)
    panels[-1].set(xlabel="time (s)", xlim=(0, float(motion.time[-1])))
    figure.suptitle(motion.attrs.get("station", "") or motion.attrs["file"], fontsize=10)
    return save(figure, file)


def _motions(axes, history: xr.Dataset, result: Amplification) -> None:
    axis = ("x", "y").index(result.direction)
    for name, color in ((result.surface, SURFACE), (result.base, BASE)):
        series = history.acceleration.sel(point=name).isel(axis=axis)
        axes.plot(history.time, series, color=color, lw=0.6, label=name)
    axes.set(xlabel="time (s)", ylabel="acceleration (m/s²)", xlim=(0, float(history.time[-1])))
    axes.legend(frameon=False, loc="upper right")


def _theory(axes, history: xr.Dataset, result: Amplification) -> None:
    """The twin with the scheme's damping; for a uniform column, paper eq. 10."""
    try:
        column = layered_twin(history, result.surface, result.base)
    except ValueError:
        return
    time_step = float(history.time_step[-1])
    speed = column.depth / column.travel_time
    if len({(layer.shear_velocity, layer.density) for layer in column.layers}) == 1:
        damping = scheme_damping(result.frequency, time_step)
        theory = damped_amplification(result.frequency, column.depth, speed, damping)
        label = "1-D theory, paper eq. 10, damping of the scheme"
    else:
        theory = abs(column.scheme_transfer(result.frequency, time_step))
        label = "1-D layered theory with the damping of the scheme"
    axes.plot(result.frequency, np.asarray(theory), color=TWIN, lw=1.1, ls="--", label=label)
