# SPDX-License-Identifier: GPL-3.0-or-later
"""Error bars of the results of a run, due to time step and penalty stiffness."""

from .figures import Accuracy, Figure
from .keeping import store_accuracy, stored_accuracy
from .measure import accuracy, of_linear_run

__all__ = ["Accuracy", "Figure", "accuracy", "store_accuracy", "stored_accuracy", "of_linear_run"]
