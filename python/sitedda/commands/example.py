# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda example`: list and copy the shipped inputs and studies."""

import argparse
from pathlib import Path

from ..input.examples import copy_example, examples

_COMMANDS = {".nml": "run", ".toml": "study"}  # command that runs a file, by its suffix


def add_example(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("name", nargs="?", metavar="NAME",
                        help="example to copy (without a name: list all examples)")  # fmt: skip
    parser.add_argument("folder", nargs="?", type=Path, default=Path(),
                        help="target folder (the current one)")  # fmt: skip
    parser.set_defaults(act=_list_or_copy)


def _list_or_copy(options: argparse.Namespace) -> int:
    """Copy the named example; without a name, print all names."""
    if options.name is None:
        for name, description in examples().items():
            print(f"{name:22} {description}")
        return 0
    files = copy_example(options.name, options.folder)
    print(f"copied: {', '.join(map(str, files))}")
    print(f"to run it: sitedda {_COMMANDS[files[0].suffix]} {files[0]}")
    return 0
