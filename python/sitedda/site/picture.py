# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of columns under motions, alone and beside a run."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ..signals import spectral_acceleration

PERIODS = np.logspace(-1.7, 0.7, 120)  # s
REFERENCE, COLUMN, BLOCKS = "#8a9099", "#d55e00", "#0072b2"


def response_figure(response) -> Figure:
    """Motions, spectra and profiles of a column.

    Parameters
    ----------
    response : ColumnResponse

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(11, 7.2), layout="constrained")
    axes = figure.subplot_mosaic(
        [["motion", "motion", "motion"], ["spectra", "acceleration", "strain"]],
        height_ratios=[1, 1.7],
    )
    time, ground = response.time, response.motion.acceleration
    axes["motion"].plot(time, response.acceleration(), color=COLUMN, lw=0.8, label="surface")
    axes["motion"].plot(time, ground, color=REFERENCE, lw=0.8, label="reference motion")
    axes["motion"].set(xlabel="time (s)", ylabel="acceleration (m/s²)", xlim=(0, time[-1]))
    axes["motion"].legend(frameon=False, ncols=2, loc="upper right")
    spectra = axes["spectra"]
    step = response.motion.time_step
    spectra.semilogx(PERIODS, response.spectrum(PERIODS), color=COLUMN, label="surface")
    spectra.semilogx(
        PERIODS, spectral_acceleration(ground, step, PERIODS), color=REFERENCE, label="reference"
    )
    spectra.set(xlabel="period (s)", ylabel="Sa, 5 % (m/s²)", ylim=(0, None))
    spectra.legend(frameon=False)
    profile = response.profile()
    axes["acceleration"].plot(profile.acceleration, profile.depth, color=COLUMN)
    axes["acceleration"].set(xlabel="peak acceleration (m/s²)", xlim=(0, None))
    axes["strain"].step(
        100 * np.append(profile.strain.values, profile.strain.values[-1]),
        profile.depth,
        where="pre",
        color=COLUMN,
    )
    axes["strain"].set(xlabel="peak shear strain (%)", xlim=(0, None))
    for name in ("acceleration", "strain"):
        axes[name].set(ylabel="depth (m)", ylim=(response.column.depth, 0))
    figure.suptitle(response.words, fontsize=10)
    return figure


def beside_figure(beside) -> Figure:
    """A run of blocks and its column in one picture.

    Parameters
    ----------
    beside : Beside

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(11, 7.6), layout="constrained")
    axes = figure.subplot_mosaic(
        [["motion", "motion", "motion"], ["ratio", "spectra", "profile"]], height_ratios=[1, 1.7]
    )
    _motions(axes["motion"], beside)
    _ratio(axes["ratio"], beside)
    _spectra(axes["spectra"], beside)
    _profile(axes["profile"], beside)
    figure.suptitle(beside.title, fontsize=10)
    return figure


def _motions(axes, beside) -> None:
    axes.plot(beside.time, beside.surface, color=BLOCKS, lw=0.9, label="blocks (DDA)")
    label = f"column, {beside.damping}"
    axes.plot(beside.time, beside.column_surface, color=COLUMN, lw=0.7, ls="--", label=label)
    axes.set(xlabel="time (s)", ylabel="surface (m/s²)", xlim=(beside.time[0], beside.time[-1]))
    axes.legend(frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0))


def _ratio(axes, beside) -> None:
    axes.plot(beside.frequency, abs(beside.ratio), color=BLOCKS, lw=0.9, label="blocks (DDA)")
    axes.plot(beside.frequency, abs(beside.column_ratio), color=COLUMN, lw=0.9, ls="--")
    axes.set(xlabel="frequency (Hz)", ylabel="surface/base", ylim=(0, None))
    axes.set_xlim(beside.frequency[0], beside.frequency[-1])


def _spectra(axes, beside) -> None:
    step = beside.response.motion.time_step
    for series, color, style in (
        (beside.base, REFERENCE, "-"),
        (beside.surface, BLOCKS, "-"),
        (beside.column_surface, COLUMN, "--"),
    ):
        axes.semilogx(
            PERIODS, spectral_acceleration(series, step, PERIODS), color=color, ls=style, lw=1.0
        )
    axes.set(xlabel="period (s)", ylabel="Sa, 5 % (m/s²)", ylim=(0, None))


def _profile(axes, beside) -> None:
    profile = beside.response.profile()
    axes.plot(profile.acceleration, profile.depth, color=COLUMN, ls="--")
    depth, peak = beside.points
    axes.plot(peak, depth, "o", color=BLOCKS, ms=5)
    axes.set(
        xlabel="peak acceleration (m/s²)",
        ylabel="depth (m)",
        xlim=(0, 1.1 * max(peak.max(), float(profile.acceleration.max()))),
        ylim=(1.03 * beside.response.column.depth, -0.03 * beside.response.column.depth),
    )
