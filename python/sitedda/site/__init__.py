# SPDX-License-Identifier: GPL-3.0-or-later
"""Site response: linear, equivalent-linear and nonlinear columns, compared with DDA.

Analyses of many columns are imported on access, because the picture of a run does not need them.
"""

from typing import TYPE_CHECKING

from ..base.on_access import import_on_access
from .beside import Beside, beside
from .branches import Branches
from .column import Column, HalfSpace, Layer
from .compare import Analyses, analyses
from .curves import SoilCurves, darendeli, gqh, hyperbolic, mkz, strength_corrected
from .equivalent_linear import EquivalentLinear, equivalent_linear
from .intensity import Intensity, intensity
from .nonlinear import NonlinearResponse, nonlinear
from .response import ColumnResponse
from .surface import Surface, surface

if TYPE_CHECKING:
    from .amplification import AmplificationTable, amplification_table
    from .matching import matched
    from .motions import (
        band_pass,
        conditional_mean,
        read_flatfile,
        resampled,
        rotated_spectra,
        scale_to,
    )
    from .profile import Profile, read_profile
    from .randomization import TORO, Toro, randomized
    from .site_terms import SiteTerm, site_term
    from .suite_file import read_suite
    from .suites import Suite, suite

import_on_access(globals())

__all__ = ["TORO", "AmplificationTable", "Analyses", "Beside", "Branches", "Column",
           "ColumnResponse", "EquivalentLinear", "HalfSpace", "Intensity", "Layer",
           "NonlinearResponse", "Profile", "SiteTerm", "SoilCurves", "Suite", "Surface", "Toro",
           "amplification_table", "analyses", "band_pass", "beside", "conditional_mean",
           "darendeli", "equivalent_linear", "gqh", "hyperbolic", "intensity", "matched", "mkz",
           "nonlinear", "randomized", "read_flatfile", "read_profile", "read_suite", "resampled",
           "rotated_spectra", "scale_to", "site_term", "strength_corrected", "suite",
           "surface"]  # fmt: skip
