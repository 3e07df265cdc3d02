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
from .column import Column, HalfSpace, Layer, scheme_damping, time_step_for_damping
from .engine import version
from .errors import (
    AuditWarning,
    CheckError,
    ConvergenceError,
    InputError,
    InterruptedRun,
    OutputError,
    SiteddaError,
    SolverError,
)
from .model import Model
from .records import read_record
from .simulation import Run, Simulation, resume, run
from .spectra import Peak, amplification, find_peak, fourier_spectrum

__version__ = version()
del version

__all__ = [
    "AuditWarning",
    "CheckError",
    "Column",
    "ConvergenceError",
    "HalfSpace",
    "InputError",
    "InterruptedRun",
    "Layer",
    "Model",
    "Modes",
    "OutputError",
    "Peak",
    "Penalty",
    "Report",
    "Run",
    "Simulation",
    "SiteddaError",
    "SolverError",
    "amplification",
    "check",
    "find_peak",
    "fourier_spectrum",
    "modes",
    "penalty_for_frequency",
    "penalty_for_shift",
    "read_record",
    "resume",
    "run",
    "scheme_damping",
    "time_step_for_damping",
    "transfer",
]
# Imported when they are asked for.
_MODULES = ("cutting", "drawing", "masonry", "plot", "response", "signals")


def __dir__() -> list[str]:
    """What is meant to be used."""
    return sorted([*__all__, *_MODULES, "__version__", "__doc__", "__name__", "__path__"])


def __getattr__(name: str):
    """The modules that need scipy or matplotlib."""
    if name in _MODULES:
        from importlib import import_module

        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
