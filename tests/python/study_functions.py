# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that studies of the tests call in worker processes; comparison of tables."""

import os
import signal
import time

import numpy as np


def ishigami(x1: float, x2: float, x3: float) -> float:
    """sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1."""
    return np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)


def plane(a: float, b: float, text: str = "") -> dict:
    """Return numbers and an array; raise ValueError for b = 0."""
    if b == 0:
        raise ValueError(f"b is nothing {text}".strip())
    return {"sum": a + b, "row": np.array([a, b, a * b])}


def troubled(kind: str) -> float:
    """End the process, use all memory, or never end, by `kind`; otherwise return a number."""
    if kind == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if kind == "exits":
        os._exit(3)
    if kind == "memory":
        return float(np.ones(1 << 34).sum())
    if kind == "endless":
        time.sleep(1000.0)
    return 1.0


def steps_of(run) -> float:
    """Return the number of samples of a run."""
    return float(run.history.sizes["time"])


def first_frequency(file) -> dict:
    """Return the first frequency of an input, which needs no run."""
    import sitedda

    modes = sitedda.modes(file, 1)
    return {"frequency_1": modes.frequency[0], "damping_1": modes.damping[0]}


def same(one, other) -> None:
    """Check that two tables are bit-identical except for the seconds of the cases."""
    import xarray as xr

    xr.testing.assert_identical(one.drop_vars("seconds").load(), other.drop_vars("seconds").load())


def fails_once(run):
    """Fail at the first call, then return 1."""
    mark = run.output.with_name("tried")
    if not mark.exists():
        mark.touch()
        raise ValueError("no such thing")
    return 1.0
