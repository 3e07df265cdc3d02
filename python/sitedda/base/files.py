# SPDX-License-Identifier: GPL-3.0-or-later
"""Write files atomically; replace only files of the same kind.

A file is written under a temporary name in its folder, flushed to the disk and renamed. It replaces
only a regular file of the same kind, which the first bytes identify.  A failure raises an
`OutputError` that names the file.
"""

import os
import re
import signal
import stat
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .errors import InterruptedRun, OutputError
from .reading import file_path

_HEAD = 1 << 24  # number of first bytes that identify the kind of a file
_XML = rb"\s*+(?><\?xml[^>]*>\s*)?+(?><!--.*?-->\s*)*+"
UNCHECKED = ""  # kind of a file in a folder that the package writes
OWN_INPUT, OWN_RECORD = "an input that sitedda wrote", "a record that sitedda wrote"
OWN_SCRIPT = "a script that sitedda wrote"
OWN_TABLE = "a table that sitedda wrote"
_KINDS = {
    "a picture": rb"\x89PNG\r\n\x1a\n|%PDF-|%!PS|\xff\xd8\xff|II\*\0|MM\0\*|GIF8|RIFF....WEBP|"
    + _XML
    + rb"<(!DOCTYPE )?svg",
    "a page": rb"\s*<!doctype html",
    "a movie": rb"GIF8|....ftyp",
    "a netCDF file": rb"CDF[\x01\x02\x05]|\x89HDF\r\n\x1a\n",
    "a ParaView file": _XML + rb"<VTKFile",
    "Markdown": rb"# ",
    OWN_INPUT: rb"! written by sitedda|.*\n! \d+ blocks, made from the groups",
    OWN_RECORD: rb"# written by sitedda",
    OWN_SCRIPT: rb"# written by sitedda",
    OWN_TABLE: rb"displacement \(m\),largest \(m\),|# written by sitedda",
    "the example": rb"(?!)",  # a file with other content is never replaced
    "part of a study": rb'\{"format": \d|#!/bin/bash\n#SBATCH --job-name=|[0-9a-f]{32}\n',
}


def check_target(file, kind: str, inputs: Iterable = ()) -> Path:
    """Check that a file can be written: it does not exist yet, or it may be replaced.

    `kind`: ``'a picture'``, ``'a page'``, …, or `UNCHECKED`.
    `inputs`: files that the same command reads, which must not be replaced.
    """
    file = file_path(file)
    try:
        status = os.lstat(file)
    except FileNotFoundError:
        if file.parent.is_dir():
            return file
        raise OutputError(f"{file}: the folder {file.parent} does not exist") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"{file} cannot be written: {reason}") from None
    if stat.S_ISDIR(status.st_mode):
        raise OutputError(f"{file} is a folder, not a file name")
    if stat.S_ISLNK(status.st_mode):
        raise OutputError(f"{file} is a symbolic link, which is not followed; name another file")
    if not stat.S_ISREG(status.st_mode):
        raise OutputError(f"{file} is not a regular file and is not replaced; name another file")
    if not status.st_mode & stat.S_IWUSR:
        raise OutputError(f"{file} is write-protected and is not replaced; make it writable, or "
                          "name another file")  # fmt: skip
    for source in inputs:
        if is_same(file, source):
            raise OutputError(f"{file} would replace {source}, which this command reads; "
                              "name another file")  # fmt: skip
    if kind and status.st_size and not _may_replace(file, kind):
        raise OutputError(f"{file} exists and is not {kind}, so it is not replaced; move it away, "
                          "or name another file")  # fmt: skip
    return file


def is_same(file, other) -> bool:
    """Return whether two paths lead to the same file."""
    try:
        return os.path.samefile(file, other)
    except (OSError, ValueError, TypeError):
        return False


def _may_replace(file: Path, kind: str) -> bool:
    """Return whether a file begins with the first bytes of files of a kind."""
    try:
        with os.fdopen(os.open(file, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as stream:
            first_bytes = stream.read(min(_HEAD, os.fstat(stream.fileno()).st_size))
    except OSError as error:
        raise OutputError(f"{file} cannot be read: {error.strerror}") from error
    return bool(re.match(_KINDS[kind], first_bytes, re.DOTALL | re.IGNORECASE))


@contextmanager
def written(file, kind: str, inputs: Iterable = (), sync: bool = True) -> Iterator[Path]:
    """Yield a temporary path to write, which is renamed to the file after it has been written.

    `file`, `kind`, `inputs`: as for `check_target`.
    `sync`: flush the file to the disk before it is renamed.
    """
    file = check_target(file, kind, inputs)
    draft = None
    try:
        with _signals_as_exceptions(file):
            try:
                handle, name = tempfile.mkstemp(prefix=".new-", suffix=file.suffix, dir=file.parent)
                draft = Path(name)
                os.fchmod(handle, 0o666 & ~_process_umask())
                os.close(handle)
                yield draft
                if sync:
                    with draft.open("rb") as stream:
                        os.fsync(stream.fileno())
                check_target(file, kind, inputs)
                draft.replace(file)
                draft = None
            finally:
                if draft:
                    draft.unlink(missing_ok=True)
    except OutputError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise OutputError(f"{file} cannot be written: {reason}") from error


def write(file, data: bytes | str, kind: str, inputs: Iterable = (), sync: bool = True) -> Path:
    """Write a whole file unless its content is unchanged, see `written`; return its path."""
    data = data.encode("utf-8", "surrogateescape") if isinstance(data, str) else data
    if kind and _contains_exactly(Path(file), data):
        return Path(file)
    with written(file, kind, inputs, sync) as draft, draft.open("wb") as stream:
        stream.write(data)
    return Path(file)


def _contains_exactly(file: Path, data: bytes) -> bool:
    """Return whether a regular file already contains these bytes."""
    try:
        if not stat.S_ISREG(os.lstat(file).st_mode) or file.stat().st_size != len(data):
            return False
        return file.read_bytes() == data
    except OSError:
        return False


def make_folder(folder) -> Path:
    """Create a folder and its missing parents."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder} cannot be created: {error.strerror}") from error
    return folder


def is_below(folder: Path, name) -> bool:
    """Return whether a path, absolute or relative to a folder, lies within that folder."""
    name = os.fspath(name)
    if ".." in Path(name).parts:
        return False
    if not os.path.isabs(name):
        return True
    parent = Path(os.path.abspath(folder))
    return Path(name).is_relative_to(parent) or Path(name).is_relative_to(parent.resolve())


def plain_text(name: str, text: str) -> str:
    """Return a text; reject control characters, such as line ends."""
    from .errors import InputError

    if not text.isprintable() and (control := re.search(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]", text)):
        raise InputError(f"{name} = {text!r} contains the control character {control[0]!r}")
    return text


def _process_umask() -> int:
    """Return the umask of this process."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("Umask:"):
            return int(line.split()[1], 8)
    return 0o022


@contextmanager
def _signals_as_exceptions(file: Path) -> Iterator[None]:
    """Raise InterruptedRun for each signal that would end the process, so that cleanup runs."""

    def end(number, _) -> None:
        raise InterruptedRun(f"interrupted by {signal.Signals(number).name}; {file} is not written")

    handlers = {}
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is signal.SIG_DFL:
                handlers[number] = signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            with suppress(ValueError):
                signal.signal(number, handler)
