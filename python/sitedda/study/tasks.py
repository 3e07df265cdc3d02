# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be done with the input of a case in place of a run, by name."""

from __future__ import annotations

from collections.abc import Callable

from ..base.errors import InputError

BAR, DECIDED = "_bar", "_decided_s"  # behind the name of a figure, in the table of a study


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


def figures_with_bars(file) -> dict:
    """The figures of the run of an input, how sure each is, and until when, see `accuracy`.

    Parameters
    ----------
    file : path
        Namelist input.

    Returns
    -------
    dict
        Of each figure its value by name, ``NAME_bar`` and ``NAME_decided_s``; counts that are 0;
        ``end_s``, s; ``warning``.
    """
    from .error_bars import accuracy
    from .error_bars.figures import COUNTS

    found = accuracy(file, workers=1)
    numbers: dict = dict.fromkeys(COUNTS, 0.0) | {"end_s": found.end}
    for name, figure in found.figures.items():
        numbers[name] = figure.finest
        numbers[f"{name}{BAR}"], numbers[f"{name}{DECIDED}"] = figure.bar, figure.decided
    return numbers | {"warning": "\n".join(f"{topic}: {words}" for topic, words in found.doubts())}


TASKS: dict[str, Callable] = {"safety": factor_of_safety, "accuracy": figures_with_bars}


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
