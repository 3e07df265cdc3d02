# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional discontinuous deformation analysis of blocks under ground motion."""

import argparse
import os
import signal
import sys
from collections.abc import Callable
from importlib import import_module
from typing import NoReturn

from ..base.core import version
from ..base.errors import MissingLibrary, OutputError, SiteddaError

# The commands in the order of the help: help text, and the module whose function `add_NAME` adds
# the arguments. The module is imported when its command is called, so the packages above this one
# are only named here. It is blank if an entry point of another distribution names the function.
COMMANDS = {
    "run": ("run an input, print and draw its results", "commands.running"),
    "resume": ("resume a run that ended early", "commands.running"),
    "check": ("check a model before its run", "commands.check"),
    "accuracy": (
        "estimate the accuracy by smaller steps and stiffer contacts",
        "study.error_bars.command",
    ),
    "safety": ("find the factor of safety by strength reduction", "stability.command"),
    "pushover": ("compute the capacity curve by static steps", "stability.command"),
    "calibrate": ("estimate stiffnesses from measured modes", "calibration.command"),
    "build": ("convert joints and masonry of an input into blocks", "build.command"),
    "draw": ("draw the blocks of an input or an output", "drawing.command"),
    "view": ("show blocks in one interactive HTML file", "facade.command"),
    "live": ("edit, run and watch a model in the browser", "live.command"),
    "movie": ("make a movie of an output", "drawing.command"),
    "report": ("write model, check, verdict and view to one page", "facade.command"),
    "export": ("write an output for other programs", "drawing.command"),
    "site": ("compare a layered site as blocks with a 1-D column", "site.command"),
    "surface": ("compute the amplification along the surface of an output", "site.command"),
    "record": ("read a record and draw its motion", "facade.command"),
    "study": ("run an input for many parameter values, or resume such runs", "study.command"),
    "editor": ("provide language server, schema and completion for editors", "editor.command"),
    "example": ("list the shipped inputs and studies, or copy one", "commands.example"),
    "validate": ("run the analytic cases", ""),
    "paper": ("reproduce the results of the paper", ""),
}


class Parser(argparse.ArgumentParser):
    """Argument parser that exits with status 1 (bad input) instead of 2 (failed check)."""

    def error(self, message: str) -> NoReturn:
        """Report an error of the command line in one sentence, and exit."""
        line = " ".join(message.split())
        self.exit(1, f"{self.prog}: {line}; see {self.prog} --help\n")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status.

    0: done; error of 1: input, 2: check, 3: convergence, 4: linear solver, 5: file, 7: memory; 6:
    interrupted; 141: the reader of the printed text has closed the pipe.
    """
    command_line = sys.argv[1:] if arguments is None else list(arguments)
    if command_line[:1] == ["study"]:
        from ..study.command import completed

        command_line[1:] = completed(command_line[1:])
    try:
        options = _make_parser(*command_line[:1]).parse_args(command_line)
        if not sys.stderr.isatty():
            options.quiet = True  # progress bars would fill a log
        status = options.act(options)
        if sys.stdout and not sys.stdout.closed:  # the language server may have closed the output
            sys.stdout.flush()
        return status
    except BrokenPipeError:  # the reader has closed the pipe
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE
    except SiteddaError as error:
        print(f"sitedda: {error}", file=sys.stderr)
        return error.kind
    except OSError as trouble:  # writing a picture, page or movie failed
        message = f"{trouble.filename}: {trouble.strerror}" if trouble.filename else trouble
        print(f"sitedda: {message}", file=sys.stderr)
        return OutputError.kind


def whole_parser() -> argparse.ArgumentParser:
    """Return the parser with the arguments of all installed commands."""
    from importlib.metadata import entry_points

    installed = entry_points(group="sitedda.commands").names
    return _make_parser(
        *(name for name, (_, module) in COMMANDS.items() if module or name in installed)
    )


def _make_parser(*requested: str) -> argparse.ArgumentParser:
    """Return the parser with the arguments of the requested commands only."""
    parser = Parser(prog="sitedda", description=__doc__)
    parser.add_argument("--version", action="version", version=f"sitedda {version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, (description, module) in COMMANDS.items():
        command = commands.add_parser(
            name, help=description, description=f"{description[0].upper()}{description[1:]}."
        )
        if name in requested:
            _argument_function(name, module)(command)
    return parser


def _argument_function(name: str, module: str) -> Callable[[argparse.ArgumentParser], None]:
    """Return the function that adds the arguments of a command."""
    if module:
        return getattr(import_module(f"..{module}", __package__), f"add_{name}")
    from importlib.metadata import entry_points  # 0.04 s

    for entry_point in entry_points(group="sitedda.commands", name=name):
        return entry_point.load()
    raise MissingLibrary(f"sitedda {name} needs the distribution sitedda-evidence: in a clone, "
                         "pip install ./python/evidence")  # fmt: skip
