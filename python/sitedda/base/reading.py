# SPDX-License-Identifier: GPL-3.0-or-later
"""Read regular files up to a maximum size."""

import os
import re
import stat
from pathlib import Path

from .errors import InputError, OutputError


def file_path(file) -> Path:
    """Return a file name as a path; raise InputError if the argument is no file name."""
    try:
        return Path(file)
    except TypeError:
        raise InputError(f"{file!r} is not a file name") from None


def check_readable(file) -> int:
    """Return the size of a regular file (bytes); reject pipes and devices, which may be endless."""
    path = file_path(file)
    try:
        status = os.stat(path)
    except FileNotFoundError as error:
        raise InputError(f"{file}: there is no such file") from error
    except (OSError, ValueError) as error:
        raise _unreadable_error(file, error) from error
    if not stat.S_ISREG(status.st_mode):
        raise OutputError(f"{file} cannot be read, because it is not a regular file")
    return status.st_size


def read_bounded(file, limit: int) -> bytes:
    """Read the bytes of a regular file; raise an error if it is larger than the maximum."""
    size = check_readable(file)
    try:
        with Path(file).open("rb") as stream:
            # Reading up to `limit` would allocate that much memory before any byte is read.
            data = stream.read(size + 1) if size <= limit else b""
    except OSError as error:
        raise _unreadable_error(file, error) from error
    if max(size, len(data)) > limit:
        raise InputError(f"{file} is larger than {limit} bytes: it is {size} bytes long")
    return data


def read_numbers(file, limit: int) -> tuple[list[str], list[tuple[int, list[float]]]]:
    """Return the column names of a CSV file, and the line number and the values of each row.

    Lines that begin with # are comments.
    """
    lines = read_bounded(file, limit).decode("utf-8-sig", "replace").splitlines()
    rows = [(i, [cell.strip(' \t"') for cell in line.split(",")])
            for i, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]  # fmt: skip
    if len(rows) < 2 or not all(rows[0][1]):
        raise InputError(f"{file}: give a heading with the name of each column, and rows of "
                         "numbers")  # fmt: skip
    (start, names), *data_rows = rows
    if "\0" in lines[0] or (len(names) == 1 and re.search(r"[;\t]", names[0])):
        raise InputError(f"{file}, line {start}: {lines[start - 1]!r} has no commas: write a table "
                         "in UTF-8, with commas between columns and decimal points")  # fmt: skip
    if repeated := [name for name in names if names.count(name) > 1]:
        raise InputError(f"{file}, line {start}: heading {repeated[0]!r} is repeated")
    table = []
    for line, cells in data_rows:
        if len(cells) != len(names):
            raise InputError(f"{file}, line {line}: {len(cells)} values under {len(names)} "
                             "headings; give one value per heading")  # fmt: skip
        table.append((line, [_number_in(f"{file}, line {line}: {name}", cell)
                             for name, cell in zip(names, cells, strict=True)]))  # fmt: skip
    return names, table


def _number_in(label: str, cell: str) -> float:
    """Return the number in a cell of a table; NaN if the cell is empty."""
    try:
        return float(cell or "nan")
    except ValueError:
        raise InputError(f"{label} = {cell!r} is not a number") from None


def _unreadable_error(file, error: Exception) -> OutputError:
    """Return the error that states why a file cannot be read."""
    return OutputError(f"{file} cannot be read: {getattr(error, 'strerror', None) or error}")
