# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of the engine as exceptions, and its warnings."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager

# Messages of the operating system if a library cannot allocate memory.
_NO_ROOM = ("cannot allocate memory", "failed to map segment", "out of memory")


class AuditWarning(UserWarning):
    """The energy audit of a completed run does not balance: do not trust its results."""


class CostWarning(UserWarning):
    """The operation will take a long time."""


class PeakWarning(UserWarning):
    """The amplification peak of a linear run differs from its exact transfer function."""


class RestWarning(UserWarning):
    """The model does not reach static equilibrium and is drawn as in its input."""


class SiteddaError(Exception):
    """An error of the engine; the message names the cause, the position and a remedy.

    Attributes
    ----------
    kind : int
        1 input, 2 check, 3 convergence, 4 linear solver, 5 file, 6 interrupted, 7 memory; the exit
        status of the command line.
    """

    kind = 1

    @staticmethod
    def of(kind: int, message: str) -> "SiteddaError":
        """Return the exception for a kind of error of the engine."""
        return {
            1: InputError,
            2: CheckError,
            3: ConvergenceError,
            4: SolverError,
            5: OutputError,
            6: InterruptedRun,
            7: OutOfMemory,
            8: CheckpointError,
        }.get(kind, SiteddaError)(message)


class InputError(SiteddaError, ValueError):
    """The input, or an argument, is invalid."""

    kind = 1
    cause: object = None  # the object of the input that caused the error, if known


class CheckError(SiteddaError):
    """The check of the model before its run failed."""

    kind = 2


class ConvergenceError(SiteddaError, ArithmeticError):
    """A time step does not converge."""

    kind = 3


class SolverError(SiteddaError, ArithmeticError):
    """The linear system of a step cannot be solved."""

    kind = 4


class NoRootError(SiteddaError, ArithmeticError):
    """No value of the parameter in the bracket yields the target result.

    Attributes
    ----------
    mode : str
        'outside', 'flat', 'jump', 'fails' or 'no number', see `sitedda.solve_for`.
    bracket : (float, float)
        The bracket of a jump; otherwise NaN.
    trials : tuple of (float, float)
        The parameter values that were tried and their results.
    """

    kind = 1

    def __init__(self, message: str, mode: str, bracket=(float("nan"),) * 2, trials=()):
        super().__init__(message)
        self.mode, self.bracket, self.trials = mode, bracket, trials

    def __reduce__(self):
        """Return class and arguments, with which `pickle` restores the exception."""
        return type(self), (str(self), self.mode, self.bracket, self.trials)


class OutputError(SiteddaError, OSError):
    """A file cannot be read or written."""

    kind = 5


class CheckpointError(OutputError):
    """No checkpoint is usable: each is damaged, or from another input, version or build."""


class InterruptedRun(SiteddaError):
    """The run was stopped on request; the results so far are saved."""

    kind = 6


class OutOfMemory(SiteddaError, MemoryError):
    """There is not enough memory for the model or for the factorisation of its matrix."""

    kind = 7


class MissingLibrary(SiteddaError, ImportError):
    """An optional library that this function requires is not installed."""

    kind = 1


@contextmanager
def located(place, *kinds: type[Exception]) -> Iterator[None]:
    """Raise an InputError that names a place, if not blank, for errors of `kinds` (InputError)."""
    kinds = kinds or (InputError,)
    try:
        yield
    except kinds as error:
        cause = None if isinstance(error, InputError) else error  # a defect shows its origin
        raise InputError(f"{place}: {error}" if place else str(error)) from cause


@contextmanager
def library_required(message: str) -> Iterator[None]:
    """Raise MissingLibrary with a message if an import fails."""
    try:
        yield
    except ImportError as error:
        raise MissingLibrary(message) from error


def lacks_memory(error: BaseException | None) -> bool:
    """Return whether lack of memory caused an exception."""
    while error is not None:
        if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        if isinstance(error, ImportError) and any(w in str(error).lower() for w in _NO_ROOM):
            return True
        error = error.__cause__ or error.__context__
    return False
