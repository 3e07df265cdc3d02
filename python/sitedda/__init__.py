# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional discontinuous deformation analysis: site response, masonry, jointed rock."""

from .check import (
    Modes,
    Penalty,
    Report,
    check,
    modes,
    penalty_for_frequency,
    penalty_for_shift,
    transfer,
)
from .column import Column, HalfSpace, Layer
from .engine import version
from .errors import (
    AuditWarning,
    CheckError,
    CheckpointError,
    ConvergenceError,
    InputError,
    InterruptedRun,
    OutOfMemory,
    OutputError,
    PeakWarning,
    SiteddaError,
    SolverError,
)
from .model import Model
from .records import read_record
from .scheme import (
    scheme_damping,
    scheme_frequency,
    theta_for_damping,
    time_step_for_damping,
)
from .simulation import Run, Simulation, resume, run
from .spectra import Peak, amplification, find_peak, fourier_spectrum

__version__ = version()
del version

__all__ = [
    "AuditWarning",
    "CheckError",
    "CheckpointError",
    "Column",
    "ConvergenceError",
    "HalfSpace",
    "InputError",
    "InterruptedRun",
    "Layer",
    "Model",
    "Modes",
    "OutOfMemory",
    "OutputError",
    "Peak",
    "PeakWarning",
    "Penalty",
    "Report",
    "Run",
    "Simulation",
    "SiteddaError",
    "SolverError",
    "amplification",
    "check",
    "draw",
    "find_peak",
    "fourier_spectrum",
    "mechanism",
    "modes",
    "open_output",
    "penalty_for_frequency",
    "penalty_for_shift",
    "read_record",
    "resume",
    "run",
    "safety",
    "scheme_damping",
    "scheme_frequency",
    "theta_for_damping",
    "time_step_for_damping",
    "transfer",
]
# Read when asked for.
_MODULES = (
    "cutting", "drawing", "masonry", "pictures", "plot", "response", "scene", "signals", "site",
    "study",
)  # fmt: skip
# Of modules that are.
_FUNCTIONS = {
    "draw": "pictures",
    "mechanism": "stability",
    "open_output": "scene",
    "safety": "stability",
}


def __dir__() -> list[str]:
    """What is meant to be used."""
    return sorted([*__all__, *_MODULES, "__version__", "__doc__", "__name__", "__path__"])


def __getattr__(name: str):
    """The modules that need scipy or matplotlib, and functions of them."""
    from importlib import import_module

    if name in _MODULES:
        return import_module(f".{name}", __name__)
    if name in _FUNCTIONS:
        return getattr(import_module(f".{_FUNCTIONS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
