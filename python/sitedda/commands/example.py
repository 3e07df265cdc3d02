# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda example`: inputs and studies that run as they are."""

import argparse
from pathlib import Path

from ..input.examples import copy_example, examples

_COMMANDS = {".nml": "run", ".toml": "study"}  # by the suffix of a file


def add_example(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="(all are listed)")
    parser.add_argument("folder", nargs="?", type=Path, default=Path(), help="where to (here)")
    parser.set_defaults(act=_example)


def _example(options: argparse.Namespace) -> int:
    if options.name is None:
        for name, words in examples().items():
            print(f"{name:22} {words}")
        return 0
    copied = copy_example(options.name, options.folder)
    print(f"copied: {', '.join(map(str, copied))}")
    print(f"to run it: sitedda {_COMMANDS[copied[0].suffix]} {copied[0]}")
    return 0
