# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: run a model with many values of its parameters, locally, on Dask or by Slurm.

``sitedda.study(…)`` is `sitedda.study.study`.
"""

import sys
from importlib import import_module
from types import ModuleType

_HOMES = {
    name: module
    for module, names in {
        "api": "study gather",
        "maps": "Bands Map bands parameter_map",
        "fragility_curve": "Fragility FragilityBounds fragility fragility_of",
        "dynamic_analysis": "Ida ida",
        "axes": "Points seeds",
        "records": "Record Records",
        "solving": "Root solve_for",
        "solving_systems": "Roots",
        "sensitivity": "SobolIndices Tornado sobol_indices tornado",
        "fitted_motion": "asce7 eurocode8 eurocode8_2024 synthetic",
        "sampling": "latin_hypercube lognormal normal one_at_a_time read_points saltelli "
        "sobol uniform",
        "quantities": "measure",
        "page": "report_page write_report",
        "table": "collect counts",
        "umbridge": "serve_umbridge",
        "workers": "Workers",
    }.items()
    for name in names.split()
}  # public names; their modules are imported on first use

__all__ = list(_HOMES)


class _Study(ModuleType):
    """Module type of this package, which makes the package callable as `study`."""

    def __call__(self, *arguments, **more):
        """Run a study; see `sitedda.study.study`."""
        return self.study(*arguments, **more)

    def __dir__(self):
        """Return the public names."""
        return sorted([*_HOMES, "__doc__", "__name__", "__path__"])


def __getattr__(name: str):
    """Import a public name from its module on first access."""
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


sys.modules[__name__].__class__ = _Study
