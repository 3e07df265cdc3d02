# SPDX-License-Identifier: GPL-3.0-or-later
"""Site response as it is practised: columns under motions, equivalent-linear soil, DDA beside."""

from .beside import Beside, beside
from .branches import Branches
from .column import Column, HalfSpace, Layer
from .compare import Analyses, analyses
from .curves import SoilCurves, darendeli, gqh, hyperbolic, mkz
from .equivalent_linear import EquivalentLinear, equivalent_linear
from .intensity import Intensity, intensity
from .nonlinear import NonlinearResponse, nonlinear
from .profile import Profile, read_profile
from .response import ColumnResponse
from .surface import Surface, surface

__all__ = [
    "Analyses",
    "Beside",
    "Branches",
    "Column",
    "ColumnResponse",
    "EquivalentLinear",
    "HalfSpace",
    "Intensity",
    "Layer",
    "NonlinearResponse",
    "Profile",
    "SoilCurves",
    "Surface",
    "analyses",
    "beside",
    "darendeli",
    "equivalent_linear",
    "gqh",
    "hyperbolic",
    "intensity",
    "mkz",
    "nonlinear",
    "read_profile",
    "surface",
]
