# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture of the spread of results over time in an ensemble of twins."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...base.errors import InputError
from ...base.numbers import axis_label, number
from ...report.style import BLUE, GREY, ORANGE, canvas

if TYPE_CHECKING:
    from .figures import Accuracy

_MOST_RESULTS = 6  # largest number of results in a picture
_COLUMNS = 2


def bands_picture(results: Accuracy):
    """Draw median and 16–84 % range of up to six results over time; return the figure.

    `results`: results with an ensemble.
    """
    names = [name for name in results.figures if name in results.bands][:_MOST_RESULTS]
    if not names:
        raise InputError("there are no bands without an ensemble: give ensemble = 10 or more")
    rows = math.ceil(len(names) / _COLUMNS)
    figure, panels = canvas(_COLUMNS, rows, size=(10.0, 2.6 * rows))
    for axes, name in zip(panels, names, strict=False):
        band, horizon = results.bands[name], results[name].decided
        axes.fill_between(band.time, band.low, band.high, color=BLUE, alpha=0.25, lw=0,
                          label="16–84 % of twins")  # fmt: skip
        axes.plot(band.time, band.median, color=BLUE, lw=1.6, label="median")
        if horizon < results.end:
            label = f"predictable until {number(horizon, 3)} s"
            axes.axvline(horizon, color=ORANGE, lw=1.2, label=label)
        axes.set(title=axis_label(name), xlabel="time (s)", xlim=(band.time[0], band.time[-1]))
        axes.title.set_color(GREY)
        axes.legend(frameon=False, fontsize=8)
    for axes in panels[len(names) :]:
        axes.set_visible(False)
    return figure
