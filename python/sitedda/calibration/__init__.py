# SPDX-License-Identifier: GPL-3.0-or-later
"""Calibrate stiffnesses of a model by measured modes or a record of vibrations."""

from typing import TYPE_CHECKING

from ..base.on_access import import_on_access

if TYPE_CHECKING:
    from .family import Family, family_of
    from .inference import Calibration, calibrate, odds
    from .measured import measured_modes
    from .record import horizontal_over_vertical, identify, read_ambient

import_on_access(globals())

__all__ = ["Calibration", "Family", "calibrate", "family_of", "horizontal_over_vertical",
           "identify", "measured_modes", "odds", "read_ambient"]  # fmt: skip
