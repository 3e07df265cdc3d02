# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda example`: list and copy the shipped inputs and studies."""

import argparse
from pathlib import Path

from ..input.examples import copy_example, examples

_COMMANDS = {".nml": "run", ".toml": "study"}  # command that runs a file, by its suffix


def add_example(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="example to copy (none: list all)")
    parser.add_argument("folder", nargs="?", type=Path, default=Path(), help="target folder (here)")
    parser.set_defaults(act=_list_or_copy)


def _list_or_copy(options: argparse.Namespace) -> int:
    """Copy the named example; without a name, print all names."""
    if options.name is None:
        for name, words in examples().items():
            print(f"{name:22} {words}")
        return 0
    copied = copy_example(options.name, options.folder)
    print(f"copied: {', '.join(map(str, copied))}")
    print(f"to run it: sitedda {_COMMANDS[copied[0].suffix]} {copied[0]}")
    return 0
