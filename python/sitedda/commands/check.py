# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda check`: check a model before its run."""

import argparse
import json
from pathlib import Path

from ..base.core import folded, print_notes
from ..base.errors import CheckError
from ..engine.checking import check
from ..engine.simulation import Simulation
from ..input.changes import add_changes


def add_check(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument("--json", action="store_true", help="print plain values as JSON")
    add_changes(parser)
    parser.set_defaults(act=check_input)


def check_input(options: argparse.Namespace) -> int:
    """Print the check of an input; raise CheckError if its verdict is 'fail'."""
    with Simulation(options.file, changes=dict(options.set)) as simulation:
        notes, description = simulation.block_notes(), simulation.description
        report = check(simulation)
    if getattr(options, "json", False):
        print(json.dumps(report.to_dict(), indent=1))
    else:
        print(folded(description))
        print_notes(notes)
        print(f"{report}\n\n{report.conclusion}")
    if report.verdict == "fail":
        raise CheckError(f"{options.file}: the check fails")
    return 0
