# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw calibrated modes with the measured shapes."""

import numpy as np

from ..drawing.modes import REACH, draw_modes
from ..engine.checking import matrices
from ..engine.simulation import Simulation
from ..input.changes import merged
from ..output.scene import Scene
from ..report.style import RED
from .calibrate import Calibration
from .measured import Observations


def draw_calibration(model, found: Calibration, changes=None, contacts: str = "auto"):
    """Draw the measured modes of the best model; return the figure.

    Arrows are the measured components of shapes; they end at the model's points where both agree.

    Parameters
    ----------
    model, changes, contacts
        See `calibrate`.
    found : Calibration
    """
    best = found.unknowns.best.to_dict()
    number = found.fit.number.to_numpy()
    order = np.argsort(number)
    with Simulation(model, changes=merged(changes, best)) as simulation:
        figure = draw_modes(
            simulation, int(number.max()), contacts, number[order] - 1,
            [found.mode_words()[j] for j in order],
        )  # fmt: skip
        scene = Scene.of(simulation)
        *_, points, names = matrices(simulation, contacts)
    places = np.array([(one["x"], one["y"]) for one in scene.points()])
    seen = Observations(found.measured, names)
    for panel, j in zip(figure.axes, order, strict=False):
        shape = found.modes.shapes[number[j] - 1]
        scale = REACH * scene.size / np.linalg.norm(shape[:, :2], axis=1).max()
        at = (points @ shape.ravel())[seen.rows[j]]
        for row, value in zip(seen.rows[j], seen.shapes[j] * (seen.shapes[j] @ at), strict=True):
            place = places[row // 2]
            end = place + scale * value * np.eye(2)[row % 2]
            panel.annotate("", end, place, arrowprops={"arrowstyle": "->", "color": RED, "lw": 1.5})
    return figure
