# SPDX-License-Identifier: GPL-3.0-or-later
"""Read regular files up to a maximum size."""

import os
import stat
from pathlib import Path

from .errors import InputError, OutputError


def check_readable(file) -> int:
    """Return the size of a regular file, bytes; reject pipes and devices, which may be endless.

    Raises
    ------
    InputError
        If the file does not exist.
    OutputError
        If it is not a regular file.
    """
    try:
        found = os.stat(file)
    except FileNotFoundError as trouble:
        raise InputError(f"{file}: there is no such file") from trouble
    except (OSError, ValueError) as trouble:
        raise _unreadable_error(file, trouble) from trouble
    if not stat.S_ISREG(found.st_mode):
        raise OutputError(f"{file} cannot be read: it is not a regular file")
    return found.st_size


def read_bounded(file, most: int) -> bytes:
    """Read the bytes of a regular file; raise an error if it is larger than the maximum."""
    size = check_readable(file)
    try:
        with Path(file).open("rb") as stream:
            # Reading up to `most` would allocate that much memory before any byte is read.
            data = stream.read(size + 1) if size <= most else b""
    except OSError as trouble:
        raise _unreadable_error(file, trouble) from trouble
    if max(size, len(data)) > most:
        raise InputError(f"{file} is larger than {most} bytes: it is {size} bytes long")
    return data


def _unreadable_error(file, trouble: Exception) -> OutputError:
    return OutputError(f"{file} cannot be read: {getattr(trouble, 'strerror', None) or trouble}")
