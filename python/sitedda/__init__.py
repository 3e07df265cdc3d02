"""Two-dimensional discontinuous deformation analysis: site response, masonry, jointed rock."""

import os

# Threads that wait for each other must not hold a core that another process wants.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

from ._core import api as _api  # noqa: E402
from .check import (  # noqa: E402
    Modes,
    Penalty,
    Report,
    check,
    modes,
    penalty_for_frequency,
    penalty_for_shift,
    transfer,
)
from .column import Column, HalfSpace, Layer, scheme_damping, time_step_for_damping  # noqa: E402
from .errors import (  # noqa: E402
    AuditWarning,
    CheckError,
    ConvergenceError,
    InputError,
    InterruptedRun,
    OutputError,
    SiteddaError,
    SolverError,
)
from .records import read_record  # noqa: E402
from .simulation import Run, Simulation, resume, run  # noqa: E402
from .spectra import Peak, amplification, find_peak, fourier_spectrum  # noqa: E402

__version__ = _api.engine_version().decode().strip()

_LATER = {
    "draw": "pictures",
    "open_output": "scene",
}  # names whose modules are slow to import: read at first use

__all__ = [
    "AuditWarning",
    "CheckError",
    "Column",
    "ConvergenceError",
    "HalfSpace",
    "InputError",
    "InterruptedRun",
    "Layer",
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
    "draw",
    "find_peak",
    "fourier_spectrum",
    "modes",
    "open_output",
    "penalty_for_frequency",
    "penalty_for_shift",
    "read_record",
    "resume",
    "run",
    "scheme_damping",
    "time_step_for_damping",
    "transfer",
]


def __getattr__(name: str):
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".{_LATER[name]}", __name__), name)
