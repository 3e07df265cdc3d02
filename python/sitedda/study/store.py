# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of a study: names, locks and atomic writes.

::

    STUDY/study.json              the manifest: settings of the study, and the key of each case
    STUDY/files/SUM.ext           records and other files that inputs name
    STUDY/cases/ab/ab…/           one case, by its key
        model.nml, out.nc         input and output (out.nc.checkpoint … while it runs)
        words.txt                 warnings of the run
        failed.txt                error with which a Slurm task failed
        result.json, result.npy   numbers; names of arrays, then the arrays
        lock                      lock of the process that executes the case

No file contains pickled objects.  No file outside the folder is read.  A file is written under
another name and then renamed.
"""

import fcntl
import hashlib
import inspect
import io
import json
import os
import re
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ..base.errors import InputError, OutputError, lacks_memory
from ..base.files import UNCHECKED, make_folder, write

MANIFEST = "study.json"
PART = "part of a study"  # kind of files in the folder of a study
INPUT, OUTPUT, WARNINGS, FAILED = "model.nml", "out.nc", "words.txt", "failed.txt"
_KEY = re.compile(r"[0-9a-f]{32}")
_ENDING = re.compile(r"\.[A-Za-z0-9]{1,8}")
_LARGEST_FILE = 1 << 30  # largest size of a JSON file, bytes
_LONGEST = 250  # largest length of the name of a result, limited by netCDF
_READ = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK  # fails at links and does not wait for pipes


def function_name(function: Callable) -> str:
    """Return module, name and checksum of the source of a function."""
    try:
        source = inspect.getsource(function)
    except (OSError, TypeError):
        source = ""
    name = f"{getattr(function, '__module__', '')}:{getattr(function, '__qualname__', function)}"
    return f"{name} {checksum(source)}"


def checksum(*texts: bytes | str) -> str:
    """Return 32 hexadecimal digits of SHA-256 over parts and their lengths."""
    digest = hashlib.sha256()
    for text in texts:
        data = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text
        digest.update(len(data).to_bytes(8, "little") + data)
    return digest.hexdigest()[:32]


def file_checksum(file) -> str:
    """Return 32 hexadecimal digits of SHA-256 over the content of a file."""
    with open(file, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()[:32]


def case_folder(study: Path, key: str) -> Path:
    """Return the folder of a case; raise OutputError if its key is invalid."""
    if not _KEY.fullmatch(key):
        raise OutputError(f"{study / MANIFEST} is damaged: {key!r} is not the key of a case")
    return Path(study) / "cases" / key[:2] / key


def keep_file(study: Path, data: bytes, ending: str) -> str:
    """Write data to a file of the study, named by its checksum; return its path for inputs."""
    ending = ending.lower() if _ENDING.fullmatch(ending) else ".txt"
    name = f"{checksum(data)}{ending}"
    target = Path(study) / "files" / name
    if not target.exists():
        make_folder(target.parent)
        write_whole(target, data)
    return f"../../../files/{name}"


def write_whole(file: Path, data: bytes | str, kind: str = UNCHECKED) -> None:
    """Write a file of a case atomically, without synchronisation of the disk."""
    write(file, data, kind, sync=False)


def read_json(file: Path):
    """Read a JSON file that is not a link; return None if it is missing or damaged."""
    try:
        with os.fdopen(os.open(file, _READ), "rb") as stream:
            return json.loads(stream.read(_LARGEST_FILE))
    except (OSError, ValueError, RecursionError):
        return None


def refuse_links(study: Path, file: Path) -> Path:
    """Return a path below the study; raise OutputError if it contains a link."""
    path = Path(study)
    for name in file.relative_to(study).parts:
        path = path / name
        if name == ".." or path.is_symlink():
            raise OutputError(f"{path} is a symbolic link: a study reads only files of its folder")
    return file


@contextmanager
def locked(folder: Path, wait: bool) -> Iterator[bool]:
    """Lock a case during the context; yield False if another process has locked it.

    The lock ends with the process, also on other machines that use the same network file system.
    """
    try:
        handle = os.open(folder / "lock", os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
    except OSError as error:
        raise OutputError(f"{folder / 'lock'} cannot be opened: {error.strerror}") from error
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
        else:
            yield True
    finally:
        os.close(handle)


def write_result(folder: Path, status: str, message: str = "", **extra) -> dict:
    """Write the results of a case: ``arrays`` to result.npy, everything else to result.json."""
    arrays = extra.pop("arrays", {})
    if arrays:
        data = io.BytesIO()
        for values in (list(arrays), *arrays.values()):
            np.save(data, values, allow_pickle=False)
        write_whole(folder / "result.npy", data.getvalue())
    record = {"status": status, "message": message, **extra, "host": socket.gethostname()}
    record["arrays"] = sorted(arrays)
    write_whole(folder / "result.json", json.dumps(record))
    return record


def read_result(folder: Path) -> dict | None:
    """Return the result of a case without its arrays; None if there is no valid result."""
    record = read_json(folder / "result.json")
    return record if isinstance(record, dict) and _is_result(record) else None


def _is_result(record: dict) -> bool:
    """Return whether status, numbers and shapes of a result are valid."""
    numbers, shapes = record.get("numbers", {}), record.get("shapes", {})
    if not isinstance(record.get("status"), str) or not _is_number(record.get("seconds", 0.0)):
        return False
    if not isinstance(numbers, dict) or not isinstance(shapes, dict):
        return False
    if any(len(name) > _LONGEST for name in (*numbers, *shapes)):
        return False
    return all(map(_is_number, numbers.values())) and all(map(_is_shape, shapes.values()))


def _is_shape(about) -> bool:
    """Return whether dimensions, shape and units of an array are valid."""
    if not isinstance(about, dict) or not isinstance(about.get("units", ""), str):
        return False
    dims, shape = about.get("dims"), about.get("shape")
    if not _are_texts(dims) or not isinstance(shape, list) or len(dims) != len(shape):
        return False
    return all(type(length) is int and 0 <= length < _LARGEST_FILE for length in shape)


def _is_number(value) -> bool:
    return isinstance(value, float) or (isinstance(value, int) and abs(value) < 1e300)


def _are_texts(values) -> bool:
    return isinstance(values, list) and all(isinstance(item, str) for item in values)


def read_arrays(folder: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a case by name."""
    try:
        handle = os.open(folder / "result.npy", _READ)
        with os.fdopen(handle, "rb") as stream:
            names = np.load(stream, allow_pickle=False).tolist()
            return {str(name): np.load(stream, allow_pickle=False) for name in names}
    except Exception as error:  # NumPy does not convert errors of its header reader
        if lacks_memory(error):
            raise
        raise OutputError(f"{folder / 'result.npy'} cannot be read: {error}") from error


def read_manifest(study: Path) -> dict:
    """Return the manifest of a study."""
    file = Path(study) / MANIFEST
    data = read_json(file)
    if not isinstance(data, dict):
        raise InputError(f"{study} is not the folder of a study: it contains no valid {MANIFEST}")
    if data.get("format") != 1:
        raise InputError(f"{file} has format {data.get('format')!r}; only format 1 is supported")
    if fault := _find_invalid_part(data):
        raise InputError(f"{file} is damaged: {fault} was not written by a study")
    return data


def _find_invalid_part(manifest: dict) -> str:
    """Return the name of the first invalid part of a manifest; blank if all parts are valid."""
    dims, coordinates = manifest.get("dims"), manifest.get("coordinates")
    if not isinstance(dims, dict) or not all(type(n) is int and n >= 0 for n in dims.values()):
        return "dims"
    if not isinstance(manifest.get("model"), str):
        return "model"
    for name in ("cases", "quantities"):
        if not _are_texts(manifest.get(name)):
            return name
    if not isinstance(coordinates, dict):
        return "coordinates"
    for name, item in coordinates.items():
        if not isinstance(item, dict) or not _is_coordinate(item, dims):
            return f"coordinate {name!r}"
    return ""


def _is_coordinate(item: dict, dims: dict) -> bool:
    """Return whether values, dimensions and attributes of a coordinate are valid."""
    attributes = item.get("attrs", {})
    if not _are_texts(item.get("dims")) or not isinstance(attributes, dict):
        return False
    try:
        values = np.asarray(item.get("values"))
    except (ValueError, OverflowError):  # rows of different lengths
        return False
    fits = values.shape == tuple(dims.get(name, -1) for name in item["dims"])
    are_plain = all(isinstance(value, str | int | float) for value in attributes.values())
    return fits and are_plain and values.dtype.kind in "biufUS"
