"""Pictures of a run."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg", force=False)
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import xarray as xr  # noqa: E402

from .column import damped_amplification, scheme_damping  # noqa: E402
from .response import Amplification, layered_twin  # noqa: E402

BASE, SURFACE, TWIN = "0.55", "tab:blue", "tab:red"


def site_response(history: xr.Dataset, result: Amplification, file) -> Path:
    """Draw base and surface motion and the amplification with the one-dimensional theory over it.

    Parameters
    ----------
    history : xarray.Dataset
        Of a finished run.
    result : Amplification
    file : path
        Picture to write.
    """
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(9, 7), layout="constrained", height_ratios=[2, 3]
    )
    _motions(above, history, result)
    below.plot(result.frequency, result.ratio, color=SURFACE, lw=1.4, label="DDA, time domain")
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
    file = Path(file)
    figure.savefig(file, dpi=130)
    plt.close(figure)
    return file


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
