# SPDX-License-Identifier: GPL-3.0-or-later
"""Tasks of a study that have a name."""

from collections.abc import Callable
from importlib import import_module

from ..base.errors import InputError

# Module and name of functions of the path of an input; they are imported on first use.
TASKS = {
    "safety": ".factor_of_safety:factor_of_safety",
    "accuracy": ".error_bars.of_case:figures_with_bars",
}


def task_of(task: str | Callable) -> str | Callable:
    """Return 'run', or the function that executes a task.

    `task`: name of the task, or a function of the path of an input.
    """
    if task == "run" or callable(task):
        return task
    if not isinstance(task, str) or task not in TASKS:
        names = ", ".join(map(repr, ("run", *TASKS)))
        raise InputError(f"task = {task!r}: give {names} or a function of the path of an input")
    module, function = TASKS[task].split(":")
    return getattr(import_module(module, __package__), function)
