"""Two-dimensional discontinuous deformation analysis for site response, masonry and jointed rock."""

from ._core import api as _api
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
    "OutputError",
    "Peak",
    "Run",
    "Simulation",
    "SiteddaError",
    "SolverError",
    "amplification",
    "find_peak",
    "fourier_spectrum",
    "run",
    "scheme_damping",
    "time_step_for_damping",
]
