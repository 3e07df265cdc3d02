# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffnesses of a model from modes that were measured."""

from .calibrate import Calibration, calibrate, odds
from .family import Family, family_of
from .measured import MeasuredMode, measured_modes

__all__ = ["Calibration", "Family", "MeasuredMode", "calibrate", "family_of", "measured_modes",
           "odds"]  # fmt: skip
