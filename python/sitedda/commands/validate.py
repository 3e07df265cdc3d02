# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda validate`: cases with exact answers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..validation import Result


def add_validate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of cases (all)")
    parser.add_argument(
        "--report", type=Path, metavar="FOLDER", help="write a report with pictures"
    )
    parser.add_argument("--short", action="store_true", help="smaller variants, as the tests use")
    parser.add_argument("--list", action="store_true", help="list the cases and stop")
    parser.set_defaults(act=_validate)


def _validate(options: argparse.Namespace) -> int:
    from ..validation import CASES
    from ..validation.report import write_report

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


def _results(names: list[str], short: bool, passed: list[bool]) -> Iterator[Result]:
    from ..validation import run_case
    from ..validation.report import terminal_text

    for name in names:
        result = run_case(name, short)
        passed.append(result.passed)
        print(terminal_text(result), flush=True)
        yield result
