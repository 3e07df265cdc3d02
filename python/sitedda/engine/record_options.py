# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of commands that read a ground motion."""

import argparse

from ..base.arguments import NOT_NEGATIVE
from ..base.errors import InputError
from ..input.schema import GROUPS
from .records import read_record

# Phrases in messages of the engine, and the options that supply the missing value.
_OPTIONS = {
    "give its unit": "--unit",
    "does not state its unit": "--unit",
    "give time_step": "--time-step",
    "name one of": "--format",
}


def add_record_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that describe a record."""
    allowed = {v.name: v.values for v in GROUPS["motion"].variables}
    parser.add_argument(
        "--format", help=f"{allowed['format']}, or 'obspy' for its formats of records (auto)"
    )
    for name in ("quantity", "unit"):
        parser.add_argument(f"--{name}", help=f"{allowed[name]}, if the record does not state it")
    parser.add_argument("--time-step", type=NOT_NEGATIVE, metavar="S",
                        help="time step of a record with one column, s")  # fmt: skip


def read_described(file, options: argparse.Namespace):
    """Read a record; an error also names the options that may supply a missing value."""
    try:
        return read_record(file, options.format or "auto", options.quantity or "",
                           options.unit or "", options.time_step or 0.0)  # fmt: skip
    except InputError as error:
        hints = [option for cause, option in _OPTIONS.items() if cause in str(error)]
        raise InputError("; ".join([str(error), *(f"try {hint}" for hint in hints)])) from error
