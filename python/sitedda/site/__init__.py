# SPDX-License-Identifier: GPL-3.0-or-later
"""Site response as it is practised: columns under motions, equivalent-linear soil, DDA beside."""

from .beside import Beside, beside
from .curves import SoilCurves, darendeli, hyperbolic
from .equivalent_linear import EquivalentLinear, equivalent_linear
from .intensity import Intensity, intensity
from .response import ColumnResponse
from .surface import Surface, surface

__all__ = [
    "Beside",
    "ColumnResponse",
    "EquivalentLinear",
    "Intensity",
    "SoilCurves",
    "Surface",
    "beside",
    "darendeli",
    "equivalent_linear",
    "hyperbolic",
    "intensity",
    "surface",
]
