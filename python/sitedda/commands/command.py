# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional discontinuous deformation analysis of blocks that are shaken."""

import argparse
import sys
from importlib import import_module

from ..base.core import version
from ..base.errors import OutputError, SiteddaError
from .parser import Parser

# The commands, in the order of the help: its words, and the function that adds the arguments.
COMMANDS = {
    "run": ("run an input, print and draw what it asks for", "running.add_run"),
    "resume": ("go on with a run that ended early", "running.add_resume"),
    "check": ("say what a run will meet before it is started", "check.add_check"),
    "accuracy": (
        "run with smaller steps and stiffer contacts: figures with their bars",
        "accuracy.add_accuracy",
    ),
    "safety": ("find the factor of safety by strength reduction", "safety.add_safety"),
    "pushover": ("push a model past its peak by static steps", "pushover.add_pushover"),
    "build": ("turn joints and masonry of an input into blocks", "build.add_build"),
    "draw": ("draw the blocks of an input or an output", "viewing.add_draw"),
    "view": ("blocks to play with, in one HTML file", "viewing.add_view"),
    "live": ("edit, run and watch a model in the browser", "live.add_live"),
    "movie": ("film the blocks of an output", "viewing.add_movie"),
    "report": ("model, check, verdict, view in one page", "viewing.add_report"),
    "export": ("write an output for other programs", "viewing.add_export"),
    "site": ("a layered site as blocks and as a 1-D column", "site.add_site"),
    "surface": ("amplification along the surface of an output", "site.add_surface"),
    "record": ("read a record and draw its motion", "record.add_record"),
    "study": ("run many values of parameters; what is done stays done", "study.add_study"),
    "example": ("copy an input or study that runs as it is; list them", "example.add_example"),
    "validate": ("run the analytic cases", "validate.add_validate"),
    "paper": ("reproduce the results of the paper", "paper.add_paper"),
}


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status.

    0 done, 1 bad input, 2 refused by a check, 3 a step does not converge, 4 linear solver, 5 file,
    6 interrupted, 7 memory.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    if words[:1] == ["study"]:
        from .study import completed

        words[1:] = completed(words[1:])
    options = _parser(words[0] if words else "").parse_args(words)
    try:
        return options.act(options)
    except SiteddaError as error:
        print(f"sitedda: {error}", file=sys.stderr)
        return error.kind
    except OSError as trouble:  # of a picture, page or movie
        said = f"{trouble.filename}: {trouble.strerror}" if trouble.filename else trouble
        print(f"sitedda: {said}", file=sys.stderr)
        return OutputError.kind


def _parser(asked: str) -> argparse.ArgumentParser:
    """The parser, with the arguments of the one command that is asked for."""
    parser = Parser(prog="sitedda", description=__doc__)
    parser.add_argument("--version", action="version", version=f"sitedda {version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, (words, place) in COMMANDS.items():
        command = commands.add_parser(
            name, help=words, description=f"{words[0].upper()}{words[1:]}."
        )
        if name == asked:
            module, _, function = place.partition(".")
            getattr(import_module(f".{module}", __package__), function)(command)
    return parser


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."
