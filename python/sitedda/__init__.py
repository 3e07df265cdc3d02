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
from .model import Model  # noqa: E402
from .records import read_record  # noqa: E402
from .simulation import Run, Simulation, resume, run  # noqa: E402
from .spectra import Peak, amplification, find_peak, fourier_spectrum  # noqa: E402

__version__ = _api.engine_version().decode().strip()

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
