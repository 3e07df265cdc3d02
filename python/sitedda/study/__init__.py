# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: run a model with many values of its parameters, locally, on Dask or by Slurm.

``sitedda.study(…)`` is `sitedda.study.study`.
"""

import sys
from types import ModuleType
from typing import TYPE_CHECKING

from ..base.on_access import import_on_access

if TYPE_CHECKING:
    from ..stability.code_spectra import asce7, eurocode8, eurocode8_2024
    from .api import gather, study
    from .axes import Points, seeds
    from .dynamic_analysis import Ida, ida
    from .fitted_motion import synthetic
    from .fragility_curve import Fragility, FragilityBounds, fragility, fragility_of
    from .maps import Bands, Map, bands, parameter_map
    from .page import report_page, write_report
    from .quantities import measure
    from .records import Record, Records
    from .sampling import (
        latin_hypercube,
        lognormal,
        normal,
        one_at_a_time,
        read_points,
        saltelli,
        sobol,
        uniform,
    )
    from .sensitivity import SobolIndices, Tornado, sobol_indices, tornado
    from .solving import Root, solve_for
    from .solving_systems import Roots
    from .table import collect, counts
    from .umbridge import serve_umbridge
    from .workers import Workers

import_on_access(globals())

__all__ = ["Bands", "Fragility", "FragilityBounds", "Ida", "Map", "Points", "Record", "Records",
           "Root", "Roots", "SobolIndices", "Tornado", "Workers", "asce7", "bands", "collect",
           "counts", "eurocode8", "eurocode8_2024", "fragility", "fragility_of", "gather", "ida",
           "latin_hypercube", "lognormal", "measure", "normal", "one_at_a_time", "parameter_map",
           "read_points", "report_page", "saltelli", "seeds", "serve_umbridge", "sobol",
           "sobol_indices", "solve_for", "study", "synthetic", "tornado", "uniform",
           "write_report"]  # fmt: skip


class _Study(ModuleType):
    """Module type of this package, which makes the package callable as `study`."""

    def __call__(self, *arguments, **options):
        """Run a study; see `sitedda.study.study`."""
        return self.study(*arguments, **options)


sys.modules[__name__].__class__ = _Study
