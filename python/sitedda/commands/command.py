# SPDX-License-Identifier: GPL-3.0-or-later
"""Two-dimensional discontinuous deformation analysis of blocks that are shaken."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import NoReturn

from .. import __version__
from ..base.arguments import POSITIVE, TOLERANCE, file_name, picture_name
from ..base.errors import CheckError, OutputError, SiteddaError
from ..base.files import check_target, save_picture
from ..engine.checking import check, transfer
from ..engine.simulation import Simulation
from ..error_bars.command import add_accuracy_command
from ..facade.run import Run, _run
from ..input.changes import Typed
from .examples import add_example_command
from .live_command import add_live_command
from .record_command import add_record_command
from .site_command import add_site_command
from .viewing import add_viewing_commands


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status.

    0 done, 1 bad input, 2 refused by a check, 3 a step does not close, 4 linear solver, 5 file,
    6 interrupted, 7 memory.
    """
    words = sys.argv[1:] if arguments is None else arguments
    if words[:1] == ["paper"]:
        from ..paper.__main__ import main as reproduce

        return reproduce(words[1:])
    if words[:1] == ["study"]:
        from ..study.command import main as study

        return study(words[1:])
    if words[:1] == ["validate"]:
        from ..validation.__main__ import main as validate

        return validate(words[1:])
    options = _parser().parse_args(words)
    try:
        return options.act(options)
    except SiteddaError as error:
        print(f"sitedda: {error}", file=sys.stderr)
        return error.kind
    except OSError as trouble:  # of a picture, page or movie
        words = f"{trouble.filename}: {trouble.strerror}" if trouble.filename else trouble
        print(f"sitedda: {words}", file=sys.stderr)
        return OutputError.kind


class Parser(argparse.ArgumentParser):
    """Ends with the status of bad input; that of argparse means a refused check here."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the command line in one sentence, and end."""
        line = " ".join(message.split())
        self.exit(1, f"{self.prog}: {line}; see {self.prog} --help\n")


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="sitedda", description=__doc__)
    parser.add_argument("--version", action="version", version=f"sitedda {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    running = commands.add_parser("run", help="run an input, print and draw what it asks for")
    running.add_argument("--check", action="store_true", help="refuse a run that fails the check")
    resuming = commands.add_parser("resume", help="go on with a run that ended early")
    for command, act in ((running, _start), (resuming, _resume)):
        command.add_argument("file", type=Path, metavar="FILE.nml")
        command.add_argument("-o", "--output", type=file_name, help="in place of the input's")
        command.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
        command.add_argument("--no-plot", action="store_true", help="draw no pictures")
        command.add_argument("--report", action="store_true", help="write a report in one page")
        command.set_defaults(act=act)
    running.add_argument(
        "--accuracy", action="store_true", help="and say how sure the figures are, by more runs"
    )
    add_record_command(commands)
    add_example_command(commands)
    commands.add_parser("study", help="run many values of parameters", add_help=False)
    commands.add_parser("validate", help="run the analytic cases", add_help=False)
    commands.add_parser("paper", help="reproduce the results of the paper", add_help=False)
    add_viewing_commands(commands)
    add_live_command(commands)
    add_site_command(commands)
    checking = commands.add_parser("check", help="say what a run will meet before it is started")
    checking.add_argument("file", type=Path, metavar="FILE.nml")
    checking.add_argument("--json", action="store_true", help="print plain values as JSON")
    checking.set_defaults(act=_check)
    building = commands.add_parser("build", help="turn joints and masonry of an input into blocks")
    building.add_argument("file", type=Path, metavar="FILE.nml")
    building.add_argument("-o", "--output", type=file_name, help="(beside it, FILE_blocks.nml)")
    building.add_argument(
        "--block-file",
        action=argparse.BooleanOptionalAction,
        help="put the blocks into a netCDF file beside it (from 10,000 on)",
    )
    building.set_defaults(act=_build)
    saving = commands.add_parser("safety", help="find the factor of safety by strength reduction")
    saving.add_argument("file", type=Path, metavar="FILE.nml")
    saving.add_argument(
        "--factor", type=POSITIVE, help="look at one factor, not for the critical one"
    )
    saving.add_argument("--tolerance", type=TOLERANCE, default=1e-3, help="of the factor (1e-3)")
    saving.add_argument("--displacement", type=POSITIVE, default=0.05, metavar="SHARE",
        help="largest at rest, of the median radius of the blocks (0.05)")  # fmt: skip
    saving.add_argument("--json", action="store_true", help="print plain values as JSON")
    saving.add_argument("-o", "--output", type=picture_name, help="(FILE_mechanism.png)")
    saving.set_defaults(act=_safety)
    measuring = add_accuracy_command(commands)
    for command in (running, resuming, checking, saving, measuring):
        command.add_argument(
            "--set",
            action="append",
            default=[],
            metavar="NAME=VALUE",
            type=_assignment,
            help="change a variable of the input: time_step=5e-4, output.file=fine.nc, "
            "material.clay.density=1900, joint[bed].friction_angle=30, joint[*].cohesion=0",
        )
    return parser


def _assignment(text: str):
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip(), Typed(value)


def _build(options: argparse.Namespace) -> int:
    from ..input.building import build_file, summary

    output, built = build_file(options.file, options.output, options.block_file)
    print(summary(built))
    _tell("\n".join(built.messages))
    print(f"output: {output}")
    return 0


def _notes(simulation: Simulation) -> str:
    return "\n".join([simulation.notes, simulation.block_notes()])


def _tell(words: str) -> None:
    for line in filter(None, words.splitlines()):
        print(f"note: {line}")


def _check(options: argparse.Namespace) -> int:
    with Simulation(options.file, changes=dict(options.set)) as simulation:
        notes, description = simulation.block_notes(), simulation.description
        found = check(simulation)
    if getattr(options, "json", False):
        print(json.dumps(found.to_dict(), indent=1))
    else:
        print(description)
        _tell(notes)
        print(f"{found}\n\n{found.conclusion}")
    if found.verdict == "fail":
        raise CheckError(f"{options.file}: the check fails")
    return 0


def _safety(options: argparse.Namespace) -> int:
    from ..stability import mechanism, safety

    changes, share = dict(options.set), options.displacement
    picture = options.output or Path(f"{options.file.stem}_mechanism.png")
    check_target(picture, "a picture", [options.file])
    if options.factor is None:
        found = safety(
            options.file, tolerance=options.tolerance, displacement=share, changes=changes
        )
        moving = found.mechanism
    else:
        found = moving = mechanism(
            options.file, options.factor, displacement=share, changes=changes
        )
    print(json.dumps(found.to_dict(), indent=1) if options.json else found)
    if moving is None:
        return 0
    picture = save_picture(found.draw().figure, picture, [options.file], dpi=130)
    if not options.json:
        print(f"\npicture: {picture}")
    return 0


def _start(options: argparse.Namespace) -> int:
    if options.check:
        _check(options)
    return _to_end(options, resume=False)


def _resume(options: argparse.Namespace) -> int:
    return _to_end(options, resume=True)


def _to_end(options: argparse.Namespace, resume: bool) -> int:
    from tqdm import tqdm

    look = "{l_bar}{bar}| {n:.2f}/{total:.2f} s [{elapsed}<{remaining}]"
    changes = dict(options.set)
    with ExitStack() as stack:
        bars, said = [], [""]

        def show(simulation: Simulation) -> None:
            if not bars:
                if resume:
                    print(simulation.notice, flush=True)
                print(simulation.description)
                _tell(_notes(simulation))
                total = simulation.duration
                bar = tqdm(total=total, disable=options.quiet, bar_format=look)
                bars.append(stack.enter_context(bar))
            bars[0].update(simulation.time - bars[0].n)
            said[:] = [simulation.thread_notes]

        result = _run(options.file, options.output or True, show, changes, resume, program=True)
    print(result.summary)
    _tell(said[0])
    print(f"output: {result.output}")
    if not result.complete:
        words = f"interrupted at t = {result.history.time[-1].item():g} s"
        print(f"sitedda: {words}; to go on: {_resume_command(options)}", file=sys.stderr)
        return 6
    _report(result, options.file, changes, draw=not options.no_plot)
    if getattr(options, "accuracy", False):
        print(f"\n{_with_accuracy(result, not options.quiet)}")
    else:
        print("these figures have no error bars: sitedda accuracy FILE.nml gives them")
    if options.report:
        print(f"page: {result.report()}")
    return 0


def _with_accuracy(result: Run, progress: bool):
    """The figures with their bars, kept in the output as well."""
    from ..error_bars import keep_accuracy

    found = result.accuracy(progress=progress)
    keep_accuracy(found, result.output, result.history.attrs)
    return found


def _resume_command(options: argparse.Namespace) -> str:
    """What to type to go on with an interrupted run."""
    words = ["sitedda", "resume", str(options.file)]
    if options.output:
        words += ["--output", str(options.output)]
    for name, value in options.set:
        words += ["--set", f"{name}={value}"]
    return shlex.join(words)


def _discrete_transfer(source: Path, changes: dict, found):
    """The model's own transfer function where an amplification is asked for, or None."""
    try:
        with Simulation(source, changes=changes) as model:
            return transfer(model, found.frequency, found.surface, found.base, found.direction)
    except SiteddaError:
        return None


def _report(result: Run, source: Path, changes: dict, draw: bool) -> None:
    """Print the amplifications that the input asks for and the verdict; draw beside the output."""
    from ..output.response import amplifications

    found = amplifications(result.history)
    for one in found:
        print(one)
    print(result.verdict)
    if not draw:
        return
    from ..facade.plot import run_picture

    discrete = _discrete_transfer(source, changes, found[0]) if found else None
    picture = result.output.with_suffix(".png")
    save_picture(run_picture(result.history, found, discrete), picture, [source], dpi=130)
    print(f"picture: {picture}")
