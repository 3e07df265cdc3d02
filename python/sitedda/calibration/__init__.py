# SPDX-License-Identifier: GPL-3.0-or-later
"""Calibrate stiffnesses of a model by measured modes or a record of vibrations."""

from .calibrate import Calibration, calibrate, odds
from .family import Family, family_of
from .measured import measured_modes
from .record import horizontal_over_vertical, identify, read_ambient

__all__ = ["Calibration", "Family", "calibrate", "family_of", "horizontal_over_vertical",
           "identify", "measured_modes", "odds", "read_ambient"]  # fmt: skip
