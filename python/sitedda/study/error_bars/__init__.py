# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the figures of a run can be trusted: bars of time step and penalty stiffness."""

from .figures import Accuracy, Figure
from .keeping import keep_accuracy, kept_accuracy
from .measure import accuracy, of_linear_run

__all__ = ["Accuracy", "Figure", "accuracy", "keep_accuracy", "kept_accuracy", "of_linear_run"]
