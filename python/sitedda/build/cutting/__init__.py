# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut regions into blocks by joints, joint sets, random polygons, holes and surfaces."""

from typing import TYPE_CHECKING

from ...base.on_access import import_on_access

if TYPE_CHECKING:
    from .blocks import Blocks, cut, main_joints
    from .distributions import DISTRIBUTIONS
    from .geometry import (
        Cutting,
        Excavation,
        Hole,
        JointLine,
        JointSet,
        Region,
        Surface,
        Tunnel,
        Voronoi,
    )
    from .small_blocks import Sliver, slivers

import_on_access(globals())

__all__ = ["DISTRIBUTIONS", "Blocks", "Cutting", "Excavation", "Hole", "JointLine", "JointSet",
           "Region", "Sliver", "Surface", "Tunnel", "Voronoi", "cut",
           "main_joints", "slivers"]  # fmt: skip
