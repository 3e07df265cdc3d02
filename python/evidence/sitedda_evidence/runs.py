# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of the paper, and parallel execution of runs."""

from collections.abc import Callable, Iterable
from concurrent.futures import as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sitedda.input.examples import inputs
from sitedda.study.workers import Workers

_CORES = 2


@dataclass(frozen=True)
class Task:
    """An independent run."""

    key: object  # key of its result
    work: Callable[..., Any]  # function of a module
    arguments: dict = field(default_factory=dict)  # arguments of the function by name
    weight: float = 1.0  # estimated computing time, s; longer tasks start first


def input_file(name: str) -> Path:
    """Return the path of an input of the paper."""
    return inputs() / "paper" / name


def run_all(
    tasks: Iterable[Task], progress: Callable[[int, int], None] | None = None, cores: int = _CORES
) -> dict[Any, Any]:
    """Execute all tasks and return their results by key.

    `progress`: called with the number of completed tasks and the number of tasks; `cores`: number
    of processes; 1: this process executes the tasks.
    """
    queue = sorted(tasks, key=lambda task: -task.weight)
    results = {}
    if cores == 1:
        for task in queue:
            results[task.key] = task.work(**task.arguments)
            if progress:
                progress(len(results), len(queue))
        return results
    pool = Workers(cores)
    try:
        key_of = {pool.submit(task.work, **task.arguments): task.key for task in queue}
        for future in as_completed(key_of):
            results[key_of[future]] = future.result()
            if progress:
                progress(len(results), len(queue))
    finally:
        pool.shutdown(cancel_futures=len(results) < len(queue))
    return results
