# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda validate` and `sitedda paper`: run and report cases with known solutions."""

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path


def add_validate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda validate`."""
    _add_arguments(parser, "VALIDATION", None)


def add_paper(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda paper`."""
    _add_arguments(parser, "PAPER", Path("paper_report"))


def _add_arguments(parser: argparse.ArgumentParser, collection: str, folder: Path | None) -> None:
    """Add the arguments of a command for a collection; `folder` is the default of the report."""
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of cases (default: all)")
    parser.add_argument("--report", "--folder", type=Path, default=folder, metavar="FOLDER",
                        help=f"write a report with pictures ({folder or 'none'})")  # fmt: skip
    parser.add_argument(
        "--short", action="store_true", help="run a small version of each case, as in the tests"
    )
    parser.add_argument("--list", action="store_true", help="list the cases without running them")
    parser.add_argument("-q", "--quiet", action="store_true", help="omit the progress bar")
    parser.set_defaults(act=partial(_run_cases, collection))


def _run_cases(collection: str, options: argparse.Namespace) -> int:
    """Run and print the cases of a collection; return 1 if a case fails, otherwise 0."""
    from . import catalogue
    from .report import write_report

    cases = getattr(catalogue, collection)
    if options.list:
        for case in cases.cases.values():
            print(f"{case.name:16s} {case.title}")
        return 0
    passed: list[bool] = []
    results = _print_results(cases, options, passed)
    if options.report:
        print(f"report: {write_report(cases, results, options.report)}")
    else:
        for _ in results:
            pass
    print(f"{sum(passed)} of {len(passed)} cases pass")
    return 0 if all(passed) else 1


def _print_results(collection, options: argparse.Namespace, passed: list[bool]) -> Iterator:
    """Yield the results, and print each result before the next case runs."""
    from tqdm import tqdm

    from .report import terminal_text

    bar = tqdm(unit="run", disable=options.quiet, delay=1e-6)

    def show(completed: int, total: int) -> None:
        bar.total = total
        bar.update(completed - bar.n)
        if completed == total:
            bar.close()

    for result in collection.run(options.cases, options.short, show):
        passed.append(result.passed)
        print(terminal_text(result), flush=True)
        yield result
