# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be done with the input of a case in place of a run, by name."""

from __future__ import annotations

from collections.abc import Callable

from ..base.errors import InputError


def factor_of_safety(file) -> dict:
    """The factor of safety of an input, see `sitedda.safety`.

    Parameters
    ----------
    file : path
        Namelist input.

    Returns
    -------
    dict
        ``factor_of_safety``; the model ``stands_at`` one factor and ``fails_at`` another;
        ``warning``.
    """
    from ..stability import safety

    found = safety(file)
    return {
        "factor_of_safety": found.factor,
        "stands_at": found.low,
        "fails_at": found.high,
        "warning": found.warning,
    }


TASKS: dict[str, Callable] = {"safety": factor_of_safety}


def task_of(task: str | Callable) -> str | Callable:
    """'run', or the function that a task is.

    Parameters
    ----------
    task : str or callable
        Its name, or a function of the path of an input.
    """
    found = TASKS.get(task, task) if isinstance(task, str) else task
    if found != "run" and not callable(found):
        known = ", ".join(map(repr, ("run", *TASKS)))
        raise InputError(f"task = {task!r}: give {known} or a function of the path of an input")
    return found
