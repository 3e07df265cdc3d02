# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are read: regular files alone, up to the size of their kind."""

import os
import stat
from pathlib import Path

from .errors import InputError, OutputError


def check_readable(file) -> int:
    """The size of a file that can be read, bytes: a pipe or a device might never end.

    Raises
    ------
    InputError
        If there is none.
    OutputError
        If it is not a regular file.
    """
    try:
        found = os.stat(file)
    except FileNotFoundError as trouble:
        raise InputError(f"{file}: there is no such file") from trouble
    except (OSError, ValueError) as trouble:
        raise _unreadable(file, trouble) from trouble
    if not stat.S_ISREG(found.st_mode):
        raise OutputError(f"{file} cannot be read: it is not a regular file")
    return found.st_size


def read_bounded(file, most: int) -> bytes:
    """The bytes of a regular file of at most so many."""
    size = check_readable(file)
    try:
        with Path(file).open("rb") as stream:
            # Not up to `most`, which would allocate memory before any byte is read.
            data = stream.read(size + 1) if size <= most else b""
    except OSError as trouble:
        raise _unreadable(file, trouble) from trouble
    if max(size, len(data)) > most:
        raise InputError(f"{file} is larger than {most} bytes: it is {size} bytes long")
    return data


def _unreadable(file, trouble: Exception) -> OutputError:
    return OutputError(f"{file} cannot be read: {getattr(trouble, 'strerror', None) or trouble}")
