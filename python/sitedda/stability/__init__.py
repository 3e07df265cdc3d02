# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors of safety by strength reduction, and mechanisms of failure."""

from .safety import Mechanism, Safety, bisect, mechanism, safety

__all__ = ["Mechanism", "Safety", "bisect", "mechanism", "safety"]
