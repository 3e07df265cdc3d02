# SPDX-License-Identifier: GPL-3.0-or-later
"""The program `sitedda`: it ends with one sentence, from the first import on.

This module imports nothing that takes time or memory, so that a signal, a library that is missing
and too little memory are met here, wherever they come.
"""

from __future__ import annotations

import errno
import sys

from .stop import Interruption

_INTERRUPTED, _MEMORY = 6, 7
# What the system says where a library finds no room.
_NO_ROOM = ("cannot allocate memory", "failed to map segment", "out of memory")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status, see `sitedda.command.main`."""
    with Interruption() as interruption:
        status = _status(arguments, interruption)
    if arguments is None:  # this process is the program, and at its end
        interruption.ignore()
    return status


def _status(arguments: list[str] | None, interruption: Interruption) -> int:
    try:
        from .command import main as carry_out

        return carry_out(arguments)
    except SystemExit:
        raise
    except BaseException as trouble:
        interruption.ignore()
        ending = (_INTERRUPTED, "interrupted") if interruption.heard else _ending(trouble)
        if ending is None:
            raise
        print(f"sitedda: {ending[1]}", file=sys.stderr)
        return ending[0]


def _ending(trouble: BaseException) -> tuple[int, str] | None:
    """Status and sentence of what is no fault of the program; None if it is one."""
    if isinstance(trouble, KeyboardInterrupt):
        return _INTERRUPTED, "interrupted"
    if _lacks_memory(trouble):
        return _MEMORY, "there is not enough memory"
    if isinstance(trouble, ImportError) and (name := (trouble.name or "").partition(".")[0]):
        return 1, f"the library {name} is missing or broken: pip install {name}"
    return None


def _lacks_memory(trouble: BaseException | None) -> bool:
    """Whether it, or what it comes from, is want of memory."""
    while trouble is not None:
        if isinstance(trouble, MemoryError) or getattr(trouble, "errno", None) == errno.ENOMEM:
            return True
        if isinstance(trouble, ImportError) and any(w in str(trouble).lower() for w in _NO_ROOM):
            return True
        trouble = trouble.__cause__ or trouble.__context__
    return False
