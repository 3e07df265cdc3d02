# SPDX-License-Identifier: GPL-3.0-or-later
"""Common parts of the commands: argument parser, option --set and printing of notes."""

import argparse
from typing import NoReturn

from ..base.core import wrapped
from ..input.changes import Typed


class Parser(argparse.ArgumentParser):
    """Argument parser that exits with status 1 (bad input) instead of 2 (failed check)."""

    def error(self, message: str) -> NoReturn:
        """Report an error of the command line in one sentence, and exit."""
        line = " ".join(message.split())
        self.exit(1, f"{self.prog}: {line}; see {self.prog} --help\n")


def add_changes(parser: argparse.ArgumentParser) -> None:
    """Add the option --set; ``dict(options.set)`` then maps variables to values."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        type=_parse_assignment,
        help="change a variable of the input: time_step=5e-4, output.file=fine.nc, "
        "material.clay.density=1900, joint[bed].friction_angle=30, joint[*].cohesion=0",
    )


def _parse_assignment(text: str):
    """Return name and value of NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip(), Typed(value)


def folded(words: str) -> str:
    """Wrap each line of a text to the width of the screen, as the native executable does."""
    return "\n".join(wrapped(line, 6) for line in words.splitlines() if line)


def tell(words: str) -> None:
    """Print notes, one per line of a text."""
    for line in filter(None, words.splitlines()):
        print(folded(f"note: {line}"))
