# SPDX-License-Identifier: GPL-3.0-or-later
"""A joint whose asperities wear under cyclic slip."""

import numpy as np

from .. import model as nml
from ..case import Outcome, at_most, case, curves, relative, yes_or_no

CYCLE, EVERY = 2000, 10  # number of steps per cycle, and per sample of the motion
# Shear force (N/m) and remaining asperity angle (degrees) at the peaks of three cycles.
PEAKS = ((0.9875e6, 14.639), (0.9579e6, 13.769), (0.9311e6, 12.957))


def worn(cycles: float = 2.25) -> str:
    """Return a block under 1 MPa that slides cyclically by ± 5 mm on asperities of 15°."""
    count = int(cycles * CYCLE)
    phase = 2 * np.pi * np.linspace(0.0, cycles, count // EVERY + 1)
    law = {"law": "plesha", "asperity_angle": 15.0, "asperity_wear": 5e-6}
    law |= {"normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 1e10}
    displacement = 5e-3 * np.sin(phase)
    return nml.driven_block(2e-3, count, law, displacement, EVERY * 2e-3, CYCLE // 4)


@case(
    "Wear of asperities",
    "A block in cyclic slip has the peak forces tan(φ + α) N, α = α₀ exp(−cW), where W is the work "
    "of slip. The dilation is slip × tan α.",
    "Plesha (1987).",
)
def asperities(short: bool) -> Outcome:
    """Check force and angle at the peaks of three cycles, and the dilation at the first peak."""
    data = nml.history(worn())
    frame = data.contact_frame.values
    shear = np.abs(np.bincount(frame, data.contact_shear_force.values))[1::4]
    wear = np.bincount(frame, data.contact_weakened.values)[1::4] / np.bincount(frame)[1::4]
    dilation = data.displacement.sel(point="top", axis="y").values
    dilation = dilation - dilation[0]
    rows = []
    cycles = zip(PEAKS, shear, wear, strict=True)
    for cycle, ((force, angle), computed, fraction) in enumerate(cycles, 1):
        rows.append(relative(f"cycle {cycle}: largest shear force", force, computed, 1e-3, "N/m"))
        rows.append(relative(f"cycle {cycle}: asperity angle at the largest force", angle,
            15.0 * (1.0 - fraction), 1e-3, "°"))  # fmt: skip
    dissipated = (data.energy_friction - data.energy_dilation).values
    rows += [
        relative("dilation at the first peak", 1.297e-3, dilation[CYCLE // 4], 1e-3, "m"),
        yes_or_no("the work of friction never decreases", True,
            bool(np.diff(dissipated).min() >= -1e-15 * dissipated[-1])),
        at_most("energy residual / work", nml.energy_residual(data), 1e-6),
    ]  # fmt: skip
    return Outcome(rows, curves("time (s)", "dilation (mm)", (data.time, 1e3 * dilation, {})))
