# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut regions into blocks by joints, joint sets, random polygons, holes and surfaces."""

from ...base.on_access import importer
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

__all__ = [
    "DISTRIBUTIONS",
    "Blocks",
    "Cutting",
    "Excavation",
    "Hole",
    "JointLine",
    "JointSet",
    "Region",
    "Sliver",
    "Surface",
    "Tunnel",
    "Voronoi",
    "cut",
    "main_joints",
    "slivers",
]

# The modules that need shapely are imported on access.
__getattr__, __dir__ = importer(
    __name__, {"blocks": "Blocks cut main_joints", "small_blocks": "Sliver slivers"}
)
