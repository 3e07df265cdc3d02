# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional discontinuous deformation analysis: site response, masonry, jointed rock."""

# Names are imported on access, so that the program handles signals and lack of memory
# also while it imports its libraries.

from typing import TYPE_CHECKING

from .base.on_access import import_on_access
from .paths import install as find_short_paths

find_short_paths()
if TYPE_CHECKING:
    from . import drawing, site, study
    from .base.core import __version__ as __version__
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
    from .build import cutting, masonry
    from .calibration.inference import Calibration, calibrate
    from .drawing import pictures
    from .drawing.pictures import draw
    from .engine import signals
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
    from .facade import plot
    from .facade.model import Model
    from .facade.run import Run, Simulation, open_output, resume, run
    from .input.examples import copy_example
    from .output import response, scene
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

import_on_access(globals())

__all__ = ["Accuracy", "AuditWarning", "Calibration", "CheckError", "CheckpointError", "Column",
           "ConvergenceError", "HalfSpace", "InputError", "InterruptedRun", "Layer", "Model",
           "Modes", "NoRootError", "OutOfMemory", "OutputError", "Peak", "PeakWarning", "Penalty",
           "Report", "Root", "Run", "Simulation", "SiteddaError", "SolverError", "accuracy",
           "amplification", "calibrate", "check", "copy_example", "draw", "find_peak",
           "fourier_spectrum", "limit_analysis", "mechanism", "modes", "move_supports",
           "open_output", "penalty_for", "penalty_for_frequency", "penalty_for_shift",
           "performance_point", "pushover", "read_record", "resume", "run", "safety",
           "scheme_damping", "scheme_frequency", "solve_for", "theta_for_damping",
           "time_step_for_damping", "transfer", "travelling_axle"]  # fmt: skip
