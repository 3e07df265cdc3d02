# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors of safety by strength reduction, limit analysis, and mechanisms of failure."""

from .limits import Limit, Limits, limit_analysis
from .pushover import Pushover, pushover
from .safety import Mechanism, Safety, bisect, mechanism, safety

__all__ = [
    "Limit",
    "Limits",
    "Mechanism",
    "Pushover",
    "Safety",
    "bisect",
    "limit_analysis",
    "mechanism",
    "pushover",
    "safety",
]
