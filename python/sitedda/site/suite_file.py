# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a suite of motions from a TOML file."""

import inspect
import tomllib
from collections.abc import Mapping
from glob import glob
from pathlib import Path

import numpy as np

from ..base.errors import InputError, located
from ..base.files import is_below
from ..base.reading import read_bounded
from ..engine.records import read_record
from ..input.groups import nearest
from .nonlinear import nonlinear
from .profile import read_profile
from .randomization import randomized
from .suites import PERIODS

_LARGEST = 2**20  # largest size of a file, bytes
_ENDINGS = (".at2", ".smc", ".v2", ".v2c", ".esm", ".asc", ".ew", ".ns", ".knet")
_READING = {"format": str, "quantity": str, "unit": str, "time_step": float}  # of text records
_STEPPED = inspect.signature(nonlinear).parameters.values()
_KNOWN = {  # names by table
    "": ("profile", "motions", "analyses", "periods", "levels", "measure", "period", "kind",
         "water_table", "pressure_at_rest", "fill", "folder", "randomize", "nonlinear", *_READING),
    "randomize": ("count", "seed", "velocity", "sigma", "layering", "depth_to_rock", "curves",
                  "clip"),
    "nonlinear": [p.name for p in _STEPPED if p.kind is p.KEYWORD_ONLY and p.name != "kind"],
    "periods": ("from", "to", "count"),
}  # fmt: skip


def read_suite(file, folder=None) -> dict:
    """Read a suite; its file names are relative to its folder.

    `folder`: folder of the cases, instead of the one in the file.

    Returns
    -------
    dict
        Arguments of `suite`.

    Raises
    ------
    InputError
        If a name is unknown or a value is invalid; the message names file and table.
    """
    file = Path(file)
    with located(file, ValueError, TypeError, ArithmeticError, RecursionError):
        values = tomllib.loads(read_bounded(file, _LARGEST).decode("utf-8"))
        return _parse_suite(values, file, folder)


def _parse_suite(values: dict, file: Path, folder) -> dict:
    _check_names(values, "")
    for name in ("profile", "motions"):
        if name not in values:
            raise InputError(f"{name} is missing")
    root, values = file.parent, dict(values)
    name = values.pop("folder", f"{file.stem}_suite")
    if folder is None and not (isinstance(name, str) and is_below(root, name)):
        raise InputError(f"folder = {name!r} is not below the folder of the file")
    names = ("water_table", "pressure_at_rest")
    water: dict = {n: float(values.pop(n)) for n in names if n in values}
    profile = read_profile(root / values.pop("profile"), values.pop("fill", ""))
    random, nonlinear = (dict(values.pop(table, {})) for table in ("randomize", "nonlinear"))
    _check_names(random, "randomize")
    _check_names(nonlinear, "nonlinear")
    if random:
        profiles = randomized(profile, random.pop("count", 1), **random, **water)
    else:
        profiles = [(profile.column(), profile.curves(**water))]
    files = motion_files(values.pop("motions"), root)
    reading: dict = {n: kind(values.pop(n)) for n, kind in _READING.items() if n in values}
    motions = [read_record(path, **reading) for path in files]
    values["periods"] = _parse_periods(values.get("periods", PERIODS))
    arguments = {"profiles": profiles, "motions": motions, "folder": Path(folder or root / name)}
    return arguments | values | nonlinear


def motion_files(patterns, root: Path) -> list[Path]:
    """Return the distinct files of names, of patterns such as ``records/*.at2``, and of folders."""
    distinct: dict[Path, None] = {}
    for pattern in [patterns] if isinstance(patterns, str) else patterns:
        files = [root / name for name in sorted(glob(pattern, root_dir=root))]
        if (root / pattern).is_dir():
            files = [f for f in sorted((root / pattern).iterdir()) if f.suffix.lower() in _ENDINGS]
        if not files:
            raise InputError(f"motions: {pattern!r} matches no record")
        distinct |= dict.fromkeys(files)
    return list(distinct)


def _parse_periods(periods) -> np.ndarray:
    """Return periods of a list, or of ``{from, to, count}`` at equal ratios."""
    if not isinstance(periods, Mapping):
        return np.asarray(periods, dtype=float)
    _check_names(periods, "periods")
    if len(periods) < 3:
        raise InputError("periods: give a list, or `from`, `to` and `count`")
    return np.geomspace(periods["from"], periods["to"], int(periods["count"]))


def _check_names(values: Mapping, table: str) -> None:
    for name in values:
        if name not in _KNOWN[table]:
            prefix = f"[{table}] " if table else ""
            raise InputError(f"{prefix}there is no {name!r}{nearest(name, _KNOWN[table])}")
