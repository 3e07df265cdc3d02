# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut regions into blocks by joints, joint sets, random polygons, holes and surfaces."""

from importlib import import_module

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

# Names of modules that need shapely; these modules are imported on access.
_LATER = {"Blocks": "blocks", "cut": "blocks", "main_joints": "blocks"}
_LATER |= {"Sliver": "small_blocks", "slivers": "small_blocks"}


def __getattr__(name: str):
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f".{_LATER[name]}", __name__)
    globals()[name] = getattr(module, name)
    return globals()[name]


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
