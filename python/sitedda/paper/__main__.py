# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: python -m sitedda.paper [NAME …] [--folder F]."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from ..base.errors import SiteddaError
from ..commands.command import Parser
from . import STUDIES, reproduce


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status: 0, or 1 if a requirement is not reached."""
    options = _parser().parse_args(arguments)
    bar = tqdm(unit="run", disable=options.quiet)

    def show(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    try:
        studies = reproduce(options.names, options.folder, show)
    except SiteddaError as error:
        print(f"sitedda: {error}", file=sys.stderr)
        return error.kind
    finally:
        bar.close()
    asked = [requirement for study in studies for requirement in study.requirements]
    for requirement in asked:
        mark = "reached    " if requirement.reached else "NOT REACHED"
        print(f"{mark}  {requirement.text}: {requirement.measured}")
    print(f"report: {options.folder / 'paper.html'}")
    return 0 if all(requirement.reached for requirement in asked) else 1


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="sitedda paper", description="Reproduce the results of the paper.")
    parser.add_argument(
        "names", nargs="*", choices=[*STUDIES, []], metavar="NAME", help=", ".join(STUDIES)
    )
    parser.add_argument("--folder", type=Path, default=Path("paper_report"), help="of the report")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    return parser


if __name__ == "__main__":
    sys.exit(main())
