# SPDX-License-Identifier: GPL-3.0-or-later
"""Content of the start page: shipped examples and records, and an empty model."""

from dataclasses import dataclass, field
from pathlib import Path

EMPTY = """&run title = 'A new model' /
&control time_step = 1e-3, duration = 5, gravity = 0, -9.81, analysis = 'plane_strain'
   time_step_control = 'adaptive', settle = .true. /
&output block_seconds = 0.1, history_seconds = 0.01 /

&material name = 'rock', density = 2600, young_modulus = 5e9, poisson_ratio = 0.25 /
&joint name = 'joint', friction_angle = 35 /

&region name = 'rock', outline = 0, 0, 40, 0, 40, 20, 0, 20 /
&boundary name = 'base', kind = 'fixed', side = 'bottom' /
&measured_point name = 'top', x = 20, y = 20 /
"""


@dataclass(frozen=True)
class BundledFiles:
    """Shipped examples and records.

    `examples`: first sentence and file of each example, by its name.
    """

    examples: dict[str, tuple[str, Path]] = field(default_factory=dict)
    records: dict[str, Path] = field(default_factory=dict)  # file of each record, by its name
