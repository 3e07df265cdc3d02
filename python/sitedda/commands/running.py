# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda run` and `sitedda resume`: run an input, print and draw its results."""

import argparse
import shlex
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from ..base.arguments import COUNT, file_name
from ..base.core import folded, print_notes
from ..base.errors import SiteddaError
from ..engine.checking import transfer
from ..engine.simulation import Simulation
from ..facade.run import Run, _run_or_resume
from ..input.changes import add_changes
from ..output.response import amplifications
from ..output.verdict_lines import NO_BARS
from .check import check_input

_BAR_FORMAT = "{l_bar}{bar}| {n:.5g}/{total:.5g} s [{elapsed}<{remaining}]"
_DRAWN_FREQUENCIES = 1250  # number of computed frequencies, three for two pixels of a picture


def add_run(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda run`."""
    parser.add_argument("--check", action="store_true", help="do not run if the check fails")
    parser.add_argument(
        "--accuracy", action="store_true", help="also estimate the accuracy by additional runs"
    )
    parser.add_argument("--ensemble", type=COUNT, default=0, metavar="N",
                        help="also run N twins, each with one displaced block")  # fmt: skip
    _add_common_arguments(parser)
    parser.set_defaults(act=_run_to_end, resume=False)


def add_resume(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda resume`."""
    _add_common_arguments(parser)
    parser.set_defaults(act=_run_to_end, resume=True, check=False, accuracy=False, ensemble=0)


def _add_common_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that `sitedda run` and `sitedda resume` have in common."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument("-o", "--output", type=file_name, help="output file to write")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    parser.add_argument("--no-plot", action="store_true", help="draw no pictures")
    parser.add_argument("--report", action="store_true", help="write a report as one page")
    add_changes(parser)


def _run_to_end(options: argparse.Namespace) -> int:
    """Run or resume an input, print the verdict and draw the results; return the exit status."""
    if options.check:
        check_input(options)
    changes, resume = dict(options.set), options.resume
    with ExitStack() as stack:
        advance, thread_notes = [], [""]

        def show(simulation: Simulation) -> None:
            if not advance:
                if resume:
                    print(simulation.notice, flush=True)
                print(folded(simulation.description))
                print_notes("\n".join([simulation.notes, simulation.block_notes()]))
                advance.append(_progress_callback(stack, simulation.duration, options.quiet))
            advance[0](simulation.time)
            thread_notes[:] = [simulation.thread_notes]

        light = not (options.accuracy or options.ensemble or options.report)
        output = options.output or True
        result = _run_or_resume(
            options.file, output, show, changes, resume, program=True, light=light
        )
    print_notes(thread_notes[0])
    if not result.complete:
        print(f"{result.verdict}\noutput: {result.output}")
        message = f"interrupted at t = {float(result.history.time[-1]):g} s"
        print(f"sitedda: {message}; to continue: {_resume_command(options)}", file=sys.stderr)
        return 6
    if options.accuracy or options.ensemble:
        _store_accuracy(result, not options.quiet, options.ensemble)
    print(f"{result.verdict}\n")
    for amplification in amplifications(result.history):
        print(folded(str(amplification)))
    print(f"output: {result.output}")
    if not options.no_plot:
        print(f"picture: {_write_picture(result, options.file, changes)}")
    if not (options.accuracy or options.ensemble):
        print(NO_BARS)
    if options.report:
        print(f"page: {result.report()}")
    return 0


def _progress_callback(stack: ExitStack, duration: float, quiet: bool) -> Callable[[float], None]:
    """Return a function of time that updates a progress bar; if quiet, it does nothing."""
    if quiet:
        return lambda time: None
    from tqdm import tqdm

    bar = stack.enter_context(tqdm(total=duration, bar_format=_BAR_FORMAT))
    return lambda time: bar.update(time - bar.n)


def _store_accuracy(result: Run, progress: bool, ensemble: int) -> None:
    """Estimate the error bars of the results and store them in the output."""
    from ..study.error_bars import store_accuracy

    assert result.output is not None  # commands always write an output
    options = {"ensemble": ensemble} if ensemble else {}
    accuracy = result.accuracy(progress=progress, output=result.output, **options)
    store_accuracy(accuracy, result.output, result.history.attrs)


def _resume_command(options: argparse.Namespace) -> str:
    """Return the command line that continues an interrupted run."""
    command = ["sitedda", "resume", str(options.file)]
    if options.output:
        command += ["--output", str(options.output)]
    for name, value in options.set:
        command += ["--set", f"{name}={value}"]
    return shlex.join(command)


def _discrete_transfer(source: Path, changes: dict, amplification):
    """Return the exact transfer function for an amplification; None if it cannot be computed.

    It is computed at `_DRAWN_FREQUENCIES` frequencies or more, and interpolated between them.
    """
    bins = amplification.frequency
    frequencies = np.union1d(bins[:: 1 + bins.size // _DRAWN_FREQUENCIES], bins[-1:])
    try:
        with Simulation(source, changes=changes) as model:
            values = transfer(model, frequencies, amplification.surface, amplification.base,
                              amplification.direction)  # fmt: skip
            return np.interp(bins, frequencies, values)
    except SiteddaError:
        return None


def _write_picture(result: Run, source: Path, changes: dict) -> Path:
    """Draw the picture of a run to a file beside the output; return the file."""
    from ..facade.plot import purpose_of, run_picture
    from ..report.style import save_picture

    subject = purpose_of(result.history)
    amplification = subject.of if subject.kind == "site" else None
    discrete = _discrete_transfer(source, changes, amplification) if amplification else None
    picture = result.output.with_suffix(".png")
    return save_picture(run_picture(subject, discrete), picture, [source], dpi=130)
