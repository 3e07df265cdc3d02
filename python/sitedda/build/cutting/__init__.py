# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut regions into blocks by joints, joint sets, random polygons, holes and surfaces."""

from ...base.on_access import on_access

with on_access(globals()):
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

__all__ = ["DISTRIBUTIONS", "Blocks", "Cutting", "Excavation", "Hole", "JointLine", "JointSet",
           "Region", "Sliver", "Surface", "Tunnel", "Voronoi", "cut",
           "main_joints", "slivers"]  # fmt: skip
