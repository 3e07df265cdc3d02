# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw calibrated modes with the measured shapes."""

import numpy as np

from ..drawing.modes import REACH, draw_modes
from ..engine.checking import matrices
from ..engine.simulation import Simulation
from ..input.changes import merged
from ..output.scene import Scene
from ..report.style import RED
from .inference import Calibration
from .measured import Observations


def draw_calibration(model, result: Calibration, changes=None, contacts: str = "auto"):
    """Draw the measured modes of the best model; return the figure.

    Arrows are the measured components of shapes; they end at the model's points where both agree.

    `model`, `changes`, `contacts`: see `calibrate`.
    """
    values = result.unknowns.best.to_dict()
    number = result.fit.number.to_numpy()
    order = np.argsort(number)
    with Simulation(model, changes=merged(changes, values)) as simulation:
        figure = draw_modes(
            simulation, int(number.max()), contacts, number[order] - 1,
            [result.mode_words()[j] for j in order],
        )  # fmt: skip
        scene = Scene.of(simulation)
        *_, points, names = matrices(simulation, contacts)
    points_at = np.array([(point["x"], point["y"]) for point in scene.points()])
    data = Observations(result.measured, names)
    for panel, j in zip(figure.axes, order, strict=False):
        shape = result.modes.shapes[number[j] - 1]
        scale = REACH * scene.size / np.linalg.norm(shape[:, :2], axis=1).max()
        motion = (points @ shape.ravel())[data.rows[j]]
        projection = data.shapes[j] * (data.shapes[j] @ motion)
        for row, value in zip(data.rows[j], projection, strict=True):
            start = points_at[row // 2]
            tip = start + scale * value * np.eye(2)[row % 2]
            arrow = {"arrowstyle": "->", "color": RED, "lw": 1.5}
            panel.annotate("", tip, start, arrowprops=arrow)
    return figure
