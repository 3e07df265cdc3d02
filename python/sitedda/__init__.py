"""Two-dimensional discontinuous deformation analysis for site response, masonry and jointed rock."""

from ._core import api as _api
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
from .errors import (
    CheckError,
    ConvergenceError,
    InputError,
    InterruptedRun,
    OutputError,
    SiteddaError,
    SolverError,
)
from .simulation import Run, Simulation, run
from .spectra import Peak, amplification, find_peak, fourier_spectrum

__version__ = _api.engine_version().decode().strip()

__all__ = [
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
    "find_peak",
    "fourier_spectrum",
    "modes",
    "penalty_for_frequency",
    "penalty_for_shift",
    "run",
    "scheme_damping",
    "time_step_for_damping",
    "transfer",
]
