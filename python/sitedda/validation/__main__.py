# SPDX-License-Identifier: GPL-3.0-or-later
"""Run validation cases: ``python -m sitedda.validation [CASE …] [--report FOLDER]``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from ..commands.command import Parser
from . import CASES, Result, run_case
from .report import terminal_text, write_report


def main(arguments: list[str] | None = None) -> int:
    """Run cases, print their rows, write a report; 0 if all pass, 1 if one fails or is unknown."""
    options = _parser().parse_args(arguments)
    if options.list:
        for case in CASES.values():
            print(f"{case.name:16s} {case.title}")
        return 0
    unknown = [name for name in options.cases if name not in CASES]
    if unknown:
        known = ", ".join(CASES)
        print(f"sitedda: there is no case {', '.join(unknown)}; known are {known}", file=sys.stderr)
        return 1
    passed: list[bool] = []
    results = _results(options.cases or list(CASES), options.short, passed)
    if options.report:
        print(f"report: {write_report(results, options.report)}")
    else:
        for _ in results:
            pass
    print(f"{sum(passed)} of {len(passed)} cases pass")
    return 0 if all(passed) else 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command, for a parser that holds it as a sub-command too."""
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of cases (all)")
    parser.add_argument(
        "--report", type=Path, metavar="FOLDER", help="write a report with pictures"
    )
    parser.add_argument("--short", action="store_true", help="smaller variants, as the tests use")
    parser.add_argument("--list", action="store_true", help="list the cases and stop")


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="sitedda validate", description=main.__doc__)
    add_arguments(parser)
    return parser


def _results(names: list[str], short: bool, passed: list[bool]) -> Iterator[Result]:
    for name in names:
        result = run_case(name, short)
        passed.append(result.passed)
        print(terminal_text(result), flush=True)
        yield result


if __name__ == "__main__":
    sys.exit(main())
