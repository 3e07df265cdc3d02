# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the run of a level site, drawn without matplotlib."""

from __future__ import annotations

from ..output.response import Amplification
from ..output.scene import Scene
from ..report.chart import Chart, Panel
from ..report.colors import FAINT
from ..report.words import folded
from ..site.beside import beside
from .panels import draw_profile, draw_site, title_words
from .purpose import Shown

_SIZE = (11.0, 7.6)  # inches, as all lengths below
_LEFT, _BETWEEN, _RIGHT = 0.75, 0.85, 0.2  # left of, between and right of both columns of panels
_FIRST = 0.35  # width of the first column over that of both
_ABOVE, _BELOW = 0.55, 0.6  # above and below the axes of a panel for ticks and labels
_TITLE, _LEGEND = 0.38, 0.35  # for a title between panels, for the legend of the profile
_UPPER = 0.48  # height of the upper panels over that of all


def site_chart(what: Shown, discrete=None) -> Chart | None:
    """Draw a site: profile, accelerations, response spectra and amplification.

    Parameters
    ----------
    what : Shown
    discrete : ndarray, optional
        See `plot.run_picture`.

    Returns
    -------
    Chart or None
        None: the ground is not level, or there is no amplification.
    """
    scene, result = what.scene, what.of
    if not isinstance(result, Amplification):
        return None
    try:
        profile = beside(scene.data, result.surface, result.base)
    except ValueError:
        return None
    chart = Chart(_SIZE)
    panels = _add_panels(chart)
    draw_profile(panels["profile"], profile)
    draw_site(panels, scene, result, discrete)
    _place_panels(panels, _SIZE[1] - _write_title(chart, scene, result.peak.frequency))
    return chart


def _add_panels(chart: Chart) -> dict[str, Panel]:
    """Add the panels of a site, in two columns."""
    both = _SIZE[0] - _LEFT - _BETWEEN - _RIGHT
    first = _LEFT, _FIRST * both
    second = _LEFT + _FIRST * both + _BETWEEN, (1 - _FIRST) * both
    return {name: chart.add_panel(*(first if name in ("profile", "spectra") else second))
            for name in ("profile", "surface", "base", "spectra", "ratio")}  # fmt: skip


def _place_panels(panels: dict[str, Panel], top: float) -> None:
    """Place the panels of a site below a height, with room for their legends."""
    high = max(panels["spectra"].legend_height + _LEGEND, panels["ratio"].legend_height)
    top, between = top - _ABOVE, _BELOW + high + 0.1
    free = top - between - _BELOW
    upper, lower = _UPPER * free, (1 - _UPPER) * free
    each = (upper - _TITLE) / 2
    panels["profile"].place(top - upper, upper)
    panels["surface"].place(top - each, each)
    panels["base"].place(top - upper, each)
    for name in ("spectra", "ratio"):
        panels[name].place(_BELOW, lower)


def _write_title(chart: Chart, scene: Scene, frequency: float) -> float:
    """Write the title of a run and the damping at a frequency (Hz); return their height, inches."""
    title, words = title_words(scene.data, frequency)
    room, down = _SIZE[0] - 0.4, 0.2
    title, words = folded(title, room, 13, True, 2), folded(words, room, 9.5)
    chart.text(0.11, _SIZE[1] - down, title, 13, bold=True)
    down += 0.23 * (title.count("\n") + 1)
    chart.text(0.11, _SIZE[1] - down, words, 9.5, FAINT)
    return down + 0.17 * words.count("\n")
