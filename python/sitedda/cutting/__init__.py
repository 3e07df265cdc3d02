"""Regions cut into blocks by joints: single ones, sets, random polygons; holes and surfaces."""

from .cut import Blocks, cut, main_joints
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
from .slivers import Sliver, slivers

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
