# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional discontinuous deformation analysis: site response, masonry, jointed rock."""

# Names are imported on access, so that the program handles signals and lack of memory
# also while it imports its libraries.

from .base.on_access import importer
from .paths import install as find_short_paths

TYPE_CHECKING = False  # imports for type checkers only; importing typing is slow

if TYPE_CHECKING:
    from .base.errors import (
        AuditWarning,
        CheckError,
        CheckpointError,
        ConvergenceError,
        InputError,
        InterruptedRun,
        NoRootError,
        OutOfMemory,
        OutputError,
        PeakWarning,
        SiteddaError,
        SolverError,
    )
    from .calibration import Calibration, calibrate
    from .drawing.pictures import draw
    from .engine.checking import (
        Modes,
        Penalty,
        Report,
        check,
        modes,
        penalty_for,
        penalty_for_frequency,
        penalty_for_shift,
        transfer,
    )
    from .engine.records import read_record
    from .engine.scheme import (
        scheme_damping,
        scheme_frequency,
        theta_for_damping,
        time_step_for_damping,
    )
    from .engine.spectra import Peak, amplification, find_peak, fourier_spectrum
    from .facade.model import Model
    from .facade.run import Run, Simulation, open_output, resume, run
    from .input.examples import copy_example
    from .site import Column, HalfSpace, Layer
    from .stability import (
        limit_analysis,
        mechanism,
        move_supports,
        performance_point,
        pushover,
        safety,
        travelling_axle,
    )
    from .study.error_bars import Accuracy, accuracy
    from .study.solving import Root, solve_for

__all__ = [
    "Accuracy",
    "AuditWarning",
    "Calibration",
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
    "NoRootError",
    "OutOfMemory",
    "OutputError",
    "Peak",
    "PeakWarning",
    "Penalty",
    "Report",
    "Root",
    "Run",
    "Simulation",
    "SiteddaError",
    "SolverError",
    "accuracy",
    "amplification",
    "calibrate",
    "check",
    "copy_example",
    "draw",
    "find_peak",
    "fourier_spectrum",
    "limit_analysis",
    "mechanism",
    "modes",
    "move_supports",
    "open_output",
    "penalty_for",
    "penalty_for_frequency",
    "penalty_for_shift",
    "performance_point",
    "pushover",
    "read_record",
    "resume",
    "run",
    "safety",
    "scheme_damping",
    "scheme_frequency",
    "solve_for",
    "theta_for_damping",
    "time_step_for_damping",
    "transfer",
    "travelling_axle",
]
_MODULES = (
    "cutting", "drawing", "masonry", "pictures", "plot", "response", "scene", "signals", "site",
    "study",
)  # fmt: skip
_get, _names = importer(
    __name__,
    {
        "base.errors": "AuditWarning CheckError CheckpointError ConvergenceError InputError "
        "InterruptedRun NoRootError OutOfMemory OutputError PeakWarning SiteddaError "
        "SolverError",
        "calibration": "Calibration calibrate",
        "drawing.pictures": "draw",
        "engine.checking": "Modes Penalty Report check modes penalty_for penalty_for_frequency "
        "penalty_for_shift transfer",
        "engine.records": "read_record",
        "engine.scheme": "scheme_damping scheme_frequency theta_for_damping time_step_for_damping",
        "engine.spectra": "Peak amplification find_peak fourier_spectrum",
        "study.error_bars": "Accuracy accuracy",
        "facade.model": "Model",
        "facade.run": "Run Simulation open_output resume run",
        "input.examples": "copy_example",
        "site.column": "Column HalfSpace Layer",
        "stability": "limit_analysis mechanism move_supports performance_point pushover safety "
        "travelling_axle",
        "study.solving": "Root solve_for",
        **dict.fromkeys(_MODULES, ""),
    },
)
find_short_paths()


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted([*_names(), "__version__"])


def __getattr__(name: str):
    """Import a public name from its module on first access."""
    if name == "__version__":
        from .base.core import version

        return version()
    return _get(name)
