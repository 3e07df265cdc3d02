# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of the engine for the studies: where the inputs are, and many runs on two cores."""

import multiprocessing
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..input.examples import inputs

_CORES = 2


@dataclass(frozen=True)
class Task:
    """One independent piece of work.

    Attributes
    ----------
    key : tuple
        Under which its result is kept; the study's name first.
    work : callable
        A function at the top of a module.
    arguments : dict
        Passed to it by name.
    weight : float
        About how long it takes, s: long ones start first.
    """

    key: tuple
    work: Callable[..., Any]
    arguments: dict = field(default_factory=dict)
    weight: float = 1.0


def input_file(name: str) -> Path:
    """An input of the reproduction."""
    return inputs() / "paper" / name


def run_all(
    tasks: Iterable[Task], progress: Callable[[int, int], None] | None = None, cores: int = _CORES
) -> dict[tuple, Any]:
    """Do all tasks and return their results by key.

    Parameters
    ----------
    tasks : iterable of Task
    progress : callable, optional
        Called with how many are done and how many there are.
    cores : int
        Processes; 1 works in this one.
    """
    todo = sorted(tasks, key=lambda task: -task.weight)
    results = {}
    if cores == 1:
        for task in todo:
            results[task.key] = task.work(**task.arguments)
            if progress:
                progress(len(results), len(todo))
        return results
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(cores, mp_context=context) as pool:
        waiting = {pool.submit(task.work, **task.arguments): task.key for task in todo}
        for done in as_completed(waiting):
            results[waiting[done]] = done.result()
            if progress:
                progress(len(results), len(todo))
    return results
