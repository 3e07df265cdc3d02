# SPDX-License-Identifier: GPL-3.0-or-later
"""Strength reduction, limit analysis, pushover and mechanisms of failure."""

from typing import TYPE_CHECKING

from ..base.on_access import import_on_access

if TYPE_CHECKING:
    from .capacity import Pushover, pushover
    from .limits import Backfill, Limit, Limits, Travel, limit_analysis, travelling_axle
    from .performance import Performance, performance_point
    from .reduction import Mechanism, Safety, bisect, mechanism, safety
    from .supports import Movement, move_supports

import_on_access(globals())

__all__ = ["Backfill", "Limit", "Limits", "Mechanism", "Movement", "Performance",
           "Pushover", "Safety", "Travel", "bisect", "limit_analysis", "mechanism",
           "move_supports", "performance_point", "pushover", "safety",
           "travelling_axle"]  # fmt: skip
