# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda record`: read a ground motion, print its intensity measures and draw it."""

import argparse
import sys
from pathlib import Path

from ..base.arguments import NOT_NEGATIVE, picture_name
from ..base.errors import InputError, OutputError
from ..engine.records import read_record
from ..input.schema import GROUPS

# Phrases in messages of the engine, and the options that supply the missing value.
_OPTIONS = {
    "give quantity or unit": "--quantity, --unit",
    "give time_step": "--time-step",
    "name one of": "--format",
}


def add_record(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    allowed = {v.name: v.values for v in GROUPS["motion"].variables}
    parser.add_argument("file", type=Path, metavar="RECORD")
    parser.add_argument(
        "--format", default="auto", help=f"{allowed['format']}, or 'obspy' for its formats (auto)"
    )
    parser.add_argument(
        "--quantity", default="", help=f"{allowed['quantity']}, if the file does not state it"
    )
    parser.add_argument(
        "--unit", default="", help=f"{allowed['unit']}, if the file does not state it"
    )
    parser.add_argument(
        "--time-step",
        type=NOT_NEGATIVE,
        default=0.0,
        metavar="S",
        help="time step of a file with one column",
    )
    parser.add_argument("-o", "--output", type=picture_name, metavar="PICTURE",
        help="picture to write (RECORD.png)")  # fmt: skip
    parser.add_argument("-f", "--force", action="store_true", help="overwrite an existing picture")
    parser.set_defaults(act=_run_record)


def _run_record(options: argparse.Namespace) -> int:
    """Print the intensity measures of a record, and draw its motion."""
    from ..facade.plot import record_panels
    from ..site.intensity import intensity

    picture = options.output or Path(f"{options.file.stem}.png")
    if not options.force:
        _confirm_overwriting(picture)
    motion = _read_record_file(options)
    print(f"{motion.attrs['station']} {motion.attrs['description']}".strip())
    print(f"{motion.time.size} samples, {float(motion.time[-1]):.3f} s; {motion.attrs['method']}")
    for name in ("acceleration", "velocity", "displacement"):
        print(f"largest {name}: {float(abs(motion[name]).max()):.6g} {motion[name].units}")
    if motion.acceleration.any():
        print(intensity(motion))
    print(f"picture: {record_panels(motion, picture)}")
    return 0


def _read_record_file(options: argparse.Namespace):
    """Read a record; an error also names the options that may supply a missing value."""
    try:
        return read_record(
            options.file, options.format, options.quantity, options.unit, options.time_step
        )
    except InputError as trouble:
        hints = [option for words, option in _OPTIONS.items() if words in str(trouble)]
        raise InputError("; ".join([str(trouble), *(f"try {hint}" for hint in hints)])) from trouble


def _confirm_overwriting(file: Path) -> None:
    """Raise OutputError if a file exists and the user does not agree to overwrite it."""
    if not file.exists():
        return
    if sys.stdin.isatty() and input(f"{file} exists. Overwrite it? [y/N] ").lower() in ("y", "yes"):
        return
    raise OutputError(f"{file} exists: --force overwrites it, --output names another file")
