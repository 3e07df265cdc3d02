# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda study`: run a study of a TOML file on this machine, a Dask cluster or Slurm."""

import argparse
import shlex
import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..base.arguments import WORKERS
from ..base.errors import InterruptedRun, SiteddaError, located
from ..base.files import check_target
from ..base.numbers import counted
from .api import gather, run, shown
from .plan import Plan, plan_of_folder
from .settings import Settings, read_settings
from .slurm import SCRIPT, submit, write_batch
from .solving import SolveFor
from .store import MANIFEST
from .table import check_table, collect, counts

_FIRST = ("run", "plan", "collect", "status", "-h", "--help")
_MOST_PRINTED = 5  # largest number of different messages of cases that are printed

TLS = {"ca": "authority", "cert": "certificate", "key": "key"}


def add_study(parser: argparse.ArgumentParser) -> None:
    """Add the commands of a study and their arguments."""
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, action, description in (
        ("run", _run_study, "run the missing cases, then collect (same: sitedda study FILE.toml)"),
        ("plan", _plan_study, "write the inputs of the cases and a script for sbatch"),
        ("collect", _collect_results, "collect the results of finished cases in one table"),
        ("status", _print_status, "print the number of finished cases; run none"),
    ):
        command = commands.add_parser(name, help=description)
        meaning = "the study" + ", or its folder" * (name in ("collect", "status"))
        command.add_argument("file", type=Path, metavar="FILE.toml", help=meaning)
        command.add_argument("--folder", type=Path, help="folder of the study (as in the file)")
        command.set_defaults(act=_run_command, part=action, slurm=False, dask="")
        if name == "status":
            continue
        command.add_argument("-o", "--output", type=Path, metavar="TABLE", help=".nc or .zarr file")
        command.add_argument("--report", action="store_true", help="write a report as one page")
        command.add_argument("-w", "--workers", type=WORKERS, help="processes (one per processor)")
        command.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
        command.add_argument("--retry", action="store_true", help="repeat failed cases")
        if name == "run":
            command.add_argument("--dask", default="", metavar="ADDRESS",
                help="address of a Dask scheduler whose workers run the cases")  # fmt: skip
            for part in TLS:
                command.add_argument(f"--tls-{part}", default="", metavar="PEM",
                    help=f"file with the {TLS[part]} for a scheduler with TLS")  # fmt: skip
            command.add_argument("--slurm", action="store_true", help="write and submit a script")
        if name != "collect":
            command.add_argument("--program", default="", help="sitedda-native on compute nodes")


def completed(arguments: list[str]) -> list[str]:
    """Insert the word ``run``, which may be omitted, into the words of the command line."""
    return arguments if not arguments or arguments[0] in _FIRST else ["run", *arguments]


def _run_command(options: argparse.Namespace) -> int:
    """Call the function of a command; print an error and return its exit status."""
    try:
        return options.part(options)
    except (SiteddaError, ImportError) as error:
        print(f"sitedda study: {error}", file=sys.stderr)
        return getattr(error, "kind", 1)
    except KeyboardInterrupt:
        print("sitedda study: interrupted; to continue, repeat the command", file=sys.stderr)
        return InterruptedRun.kind


def _run_study(options: argparse.Namespace) -> int:
    """Run the missing cases of a study, or submit them, and report the results."""
    settings = read_settings(options.file, options.folder)
    _check_targets(settings, options)
    if options.slurm:
        print(submit(_write_script(settings, options)))
        print(f"when all jobs have ended: {_collect_command(options)}")
        return 0
    plan = _write_plan(settings, options.file)
    print(f"{counted(plan.count, 'case', 'cases')} in {plan.folder}", flush=True)
    with _dask_executor(options) as executor, shown(not options.quiet, plan.count) as show:
        limits = settings.limits | {"retry": options.retry, "show": show}
        run(plan, executor, options.workers, **limits)
    return _report_study(settings, options)


def _write_plan(settings: Settings, file: Path) -> Plan:
    """Write the plan of a study and its inputs; an error names the file of the study."""
    with located(file):
        return settings.plan.write()


def _check_targets(settings: Settings, options: argparse.Namespace) -> None:
    """Check, before any case runs, that table and report can be written."""
    targets = [(options.output or settings.table, check_table)]
    if options.report:
        page = settings.plan.folder / "report.html"
        targets.append((page, lambda file: check_target(file, "a page")))
    for file, check in targets:
        if file.parent.exists() or file.absolute().parent != settings.plan.folder:
            check(file)


def _dask_executor(options: argparse.Namespace):
    """Return a context with the executor of a Dask cluster, or with None."""
    if not options.dask:
        return nullcontext()
    from .dask import dask_client

    return dask_client(options.dask, options.tls_ca, options.tls_cert, options.tls_key)


def _plan_study(options: argparse.Namespace) -> int:
    """Write the inputs and the script of a study; print how to submit them."""
    settings = read_settings(options.file, options.folder)
    script = _write_script(settings, options)
    print(f"{counted(settings.plan.count, 'case', 'cases')} in {settings.plan.folder}")
    print(f"submit: sbatch {shlex.quote(str(script))}")
    print(f"then: {_collect_command(options)}")
    return 0


def _collect_command(options: argparse.Namespace) -> str:
    """Return the command line that collects the cases of the study."""
    folder = ["--folder", str(options.folder)] if options.folder else []
    return shlex.join(["sitedda", "study", "collect", str(options.file), *folder])


def _write_script(settings: Settings, options: argparse.Namespace) -> Path:
    """Write inputs and Slurm script of a study; return the path of the script."""
    slurm = replace(settings.slurm, program=options.program)
    return write_batch(_write_plan(settings, options.file), slurm)


def _collect_results(options: argparse.Namespace) -> int:
    """Collect the finished cases of a study, and report the results."""
    settings = _read_settings(options.file, options.folder)
    _check_targets(settings, options)
    plan = settings.plan
    if (plan.folder / SCRIPT).exists():
        with shown(not options.quiet, len(plan.keys)) as show:
            gather(plan, options.workers, show, options.retry)
    return _report_study(settings, options)


def _read_settings(file: Path, folder: Path | None) -> Settings:
    """Read the settings of a TOML file or of the folder of a study."""
    if file.is_dir():
        plan = plan_of_folder(file)
        return Settings(plan, plan.folder / "table.nc")
    settings = read_settings(file, folder)
    _write_plan(settings, file)
    return settings


def _report_study(settings: Settings, options: argparse.Namespace) -> int:
    """Write table and report of a study, and print its results; return the exit status."""
    file = options.output or settings.table
    with collect(settings.plan.folder, file.absolute()) as table:
        failed = _print_counts(table)
        _print_messages(table, None, "warning")
        if isinstance(settings.plan.task, SolveFor):
            _print_roots(table, settings.plan.task)
        print(f"table: {file}")
        if options.report:
            from .page import write_report

            page = write_report(table, settings.plan.folder / "report.html", settings.figures)
            print(f"page: {page}")
    return int(failed > 0)


def _print_status(options: argparse.Namespace) -> int:
    """Print the numbers of finished and missing cases of a study."""
    folder = options.file
    if not folder.is_dir():
        folder = read_settings(options.file, options.folder).plan.folder
        if not (folder / MANIFEST).exists():
            print(f"{folder}: not started")
            return 0
    with collect(folder, arrays=False) as table:
        failed = _print_counts(table)
        if counts(table).get("missing") and not options.file.is_dir():
            file = shlex.quote(str(options.file))
            print(f"to run the missing cases: sitedda study {file}")
        return int(failed > 0)


def _print_counts(table) -> int:
    """Print counts of cases by status, and messages of failures; return the number of failures."""
    numbers = counts(table)
    text = ", ".join(f"{number} {status}" for status, number in sorted(numbers.items()))
    print(f"{counted(table.status.size, 'case', 'cases')}: {text}")
    _print_messages(table, "failed", "message")
    failed = numbers.get("failed", 0)
    if failed:
        print("to repeat the failed cases, correct the file, or use --retry")
    return failed


def _print_messages(table, status: str | None, name: str) -> None:
    """Print the first messages, each with the parameters of the first case that has it."""
    texts = table[name].values
    mask = texts != "" if status is None else table.status.values == status
    cases_of_message: dict[str, list[tuple]] = {}
    for case in _chosen_indices(mask):
        cases_of_message.setdefault(texts[case].splitlines()[0], []).append(case)
    for message, cases in list(cases_of_message.items())[:_MOST_PRINTED]:
        remainder = f" and {len(cases) - 1} more" if len(cases) > 1 else ""
        parameters = _format_parameters(table, cases[0]) + remainder
        print(": ".join(filter(None, [status or name, parameters, message])))
    if (unprinted := len(cases_of_message) - _MOST_PRINTED) > 0:
        print(f"… and {unprinted} other messages")


def _print_roots(table, task: SolveFor) -> None:
    """Print the first roots, with the parameters of their cases."""
    from ..base.numbers import with_bar

    if "root" not in table:
        return
    roots, bars = table.root.values, table.root_bar.values
    cases = _chosen_indices(np.isfinite(roots))
    for case in cases[:_MOST_PRINTED]:
        text = f"{task.parameter} = {with_bar(float(roots[case]), float(bars[case]))}"
        print(": ".join(filter(None, ["root", _format_parameters(table, case), text])))
    if (unprinted := len(cases) - _MOST_PRINTED) > 0:
        print(f"… and {unprinted} more")


def _chosen_indices(mask: np.ndarray) -> list[tuple]:
    """Return the index tuples of the cases for which `mask` is true."""
    return [index for index in np.ndindex(mask.shape) if mask[index]]


def _format_parameters(table, index: tuple) -> str:
    """Return names and values of the parameters of a case as text."""
    return ", ".join(f"{dim} = {table[dim].values[i]}" if dim in table.coords else f"{dim} {i}"
                     for dim, i in zip(table.status.dims, index, strict=True))  # fmt: skip
