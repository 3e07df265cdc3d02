# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: a model run with many values of its parameters, here, on a cluster, or by Slurm.

``sitedda.study(…)`` is `sitedda.study.study`.
"""

import sys
from importlib import import_module
from types import ModuleType

_HOMES = {
    "study": "api",
    "Bands": "maps",
    "Fragility": "fragility_curve",
    "Ida": "dynamic_analysis",
    "Map": "maps",
    "Points": "axes",
    "Record": "records",
    "Records": "records",
    "Root": "solving",
    "SobolIndices": "sensitivity",
    "Tornado": "sensitivity",
    "bands": "maps",
    "eurocode8": "fitted_motion",
    "fragility": "fragility_curve",
    "fragility_of": "fragility_curve",
    "gather": "api",
    "ida": "dynamic_analysis",
    "parameter_map": "maps",
    "seeds": "axes",
    "latin_hypercube": "sampling",
    "lognormal": "sampling",
    "normal": "sampling",
    "one_at_a_time": "sampling",
    "saltelli": "sampling",
    "sobol": "sampling",
    "uniform": "sampling",
    "measure": "quantities",
    "report_page": "page",
    "solve_for": "solving",
    "sobol_indices": "sensitivity",
    "synthetic": "fitted_motion",
    "tornado": "sensitivity",
    "write_report": "page",
    "collect": "table",
    "counts": "table",
    "Workers": "workers",
}  # names, and the modules that are read when they are first used

__all__ = list(_HOMES)


class _Study(ModuleType):
    """This package, which can be called as its function `study`."""

    def __call__(self, *arguments, **more):
        """See `sitedda.study.study`."""
        return self.study(*arguments, **more)

    def __dir__(self):
        """What is meant to be used."""
        return sorted([*_HOMES, "__doc__", "__name__", "__path__"])


def __getattr__(name: str):
    """Functions, from the modules that have them."""
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


sys.modules[__name__].__class__ = _Study
