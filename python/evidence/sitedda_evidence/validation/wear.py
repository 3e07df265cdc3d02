# SPDX-License-Identifier: GPL-3.0-or-later
"""A joint whose asperities wear under cyclic slip."""

import numpy as np

from .. import model as nml
from ..case import Outcome, at_most, case, curves, relative, true

CYCLE, EVERY = 2000, 10  # number of steps per cycle, and per sample of the motion
# Shear force (N/m) and remaining asperity angle (degrees) at the peaks of three cycles.
PEAKS = ((0.9875e6, 14.639), (0.9579e6, 13.769), (0.9311e6, 12.957))


def worn(cycles: float = 2.25) -> str:
    """Return a block under 1 MPa that slides cyclically by ± 5 mm on asperities of 15°."""
    count = int(cycles * CYCLE)
    phase = 2 * np.pi * np.linspace(0.0, cycles, count // EVERY + 1)
    law = {"law": "plesha", "asperity_angle": 15.0, "asperity_wear": 5e-6}
    law |= {"normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 1e10}
    way = 5e-3 * np.sin(phase)
    return nml.driven_block(2e-3, count, law, way, EVERY * 2e-3, CYCLE // 4)


@case(
    "Wear of asperities",
    "Peak forces tan(φ + α) N of a block in cyclic slip; α = α₀ exp(−cW), W the work of slip; the "
    "block dilates by slip × tan α.",
    "Plesha (1987).",
)
def asperities(short: bool) -> Outcome:
    """Check force and angle at the peaks of three cycles, and the dilation at the first peak."""
    data = nml.history(worn())
    frame = data.contact_frame.values
    shear = np.abs(np.bincount(frame, data.contact_shear_force.values))[1::4]
    off = np.bincount(frame, data.contact_weakened.values)[1::4] / np.bincount(frame)[1::4]
    lift = data.displacement.sel(point="top", axis="y").values
    rows = []
    for cycle, ((force, angle), got, share) in enumerate(zip(PEAKS, shear, off, strict=True), 1):
        rows.append(relative(f"cycle {cycle}: peak force", force, got, 1e-3, "N/m"))
        rows.append(relative(f"cycle {cycle}: angle", angle, 15.0 * (1.0 - share), 1e-3, "°"))
    lost = (data.energy_friction - data.energy_dilation).values
    rows += [
        relative("dilation at the first peak", 1.297e-3, lift[CYCLE // 4] - lift[0], 1e-3, "m"),
        true("friction only takes", True, bool(np.diff(lost).min() >= -1e-15 * lost[-1])),
        at_most("residual of the energy audit", nml.residual(data), 1e-6),
    ]
    return Outcome(rows, curves("time (s)", "climb (mm)", (data.time, 1e3 * (lift - lift[0]), {})))
