# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffnesses from measured modes."""

import numpy as np

from sitedda.calibration import MeasuredMode, calibrate
from sitedda.facade.model import Model

from ..case import Outcome, Table, absolute, at_most, case

_FIELD = [MeasuredMode(3.4, 0.8 / 3.29), MeasuredMode(4.75, 1.1 / 3.29)]  # bands as 90 %, Hz
_DRY = {"joint[dry].normal_stiffness_per_area": (1.7e8, 3.3e9)}  # 5e7 to 1e9 N/m a contact
_GROUND = {"boundary[sway].stiffness_per_area": (1e6, 1e8),
           "boundary[rise].stiffness_per_area": (1e7, 1e9)}  # fmt: skip


def avdat(width: float, depth: float, springs: bool) -> Model:
    """The ten drums of Avdat on a block that is fixed, or on springs."""
    model = Model("Avdat", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.contact(normal_stiffness=4e8)
    model.material("limestone", density=2250, young_modulus=17e9, poisson_ratio=0.22)
    model.joint("dry", friction_angle=35, normal_stiffness_per_area=6e8)
    half = width / 2
    model.block([-half, -depth, half, -depth, half, 0, -half, 0], name="base")
    model.drums(width=0.6, top_width=0.6, height=0.39, count=10)
    if not springs:
        model.boundary(kind="fixed", blocks="base", side="bottom")
        return model
    for (path, (low, high)), axis in zip(_GROUND.items(), "xy", strict=True):
        name = path[len("boundary[") : path.index("]")]
        model.boundary(name=name, kind="springs", blocks="base", side="bottom", direction=axis,
                       stiffness_per_area=(low * high) ** 0.5)  # fmt: skip
    return model


@case(
    "The second mode of the column at Avdat",
    "Two bands of the field, 3.0 to 3.8 and 4.2 to 5.3 Hz: a plane column on a fixed base cannot "
    "meet both; a heavy base on springs can, and so can the column in the other direction.",
    "Bao, Hatzor, Yagoda-Biran et al. (2013), sections 3.1 and 3.2.",
)
def avdat_second_mode(short: bool) -> Outcome:
    """The evidence of four hypotheses, and the stiffness of a contact by the first mode alone."""
    fixed = avdat(3, 1, False)
    first, second = (calibrate(fixed, [one], _DRY) for one in _FIELD)
    found = {
        "fixed base": calibrate(fixed, _FIELD, _DRY),
        "base 3 m × 1 m on springs": calibrate(avdat(3, 1, True), _FIELD, _DRY | _GROUND),
        "base 4 m × 2 m on springs": calibrate(avdat(4, 2, True), _FIELD, _DRY | _GROUND),
    }
    logs = {name: one.evidence for name, one in found.items()}
    logs["other direction"] = first.evidence + second.evidence
    most = max(logs.values())
    weights = {name: float(np.exp(log - most)) for name, log in logs.items()}
    total = sum(weights.values())
    pairs = {name: " and ".join(f"{f:.2f}" for f in one.frequency) for name, one in found.items()}
    pairs["other direction"] = f"{first.frequency[0]:.2f} and {second.frequency[0]:.2f}"
    cells = [[name, pairs[name], f"{log:.1f}", f"{weights[name] / total:.2g}"]
             for name, log in logs.items()]  # fmt: skip
    low, high = 0.3 * first.low[0], 0.3 * first.high[0]
    rows = [
        absolute("contact stiffness of the first mode", 2.12e8, 0.3 * first.median[0], 5e6, "N/m"),
        absolute("its lower bound, 90 %", 1.66e8, low, 8e6, "N/m"),
        absolute("its upper bound, 90 %", 2.67e8, high, 12e6, "N/m"),
        at_most("fixed base: probability", weights["fixed base"] / total, 1e-6),
        at_most("base 4 m × 2 m: misfit, deviations",
                abs(found["base 4 m × 2 m on springs"].misfit).max(), 1.0),
    ]  # fmt: skip
    table = Table("Hypotheses, equally likely before",
                  ["hypothesis", "modes (Hz)", "ln evidence", "probability"], cells)  # fmt: skip
    return Outcome(rows, tables=[table])
