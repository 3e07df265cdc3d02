# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda paper`: the results of the paper, reproduced."""

import argparse
from pathlib import Path


def add_paper(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    from ..paper import STUDIES

    parser.add_argument(
        "names", nargs="*", choices=[*STUDIES, []], metavar="NAME", help=", ".join(STUDIES)
    )
    parser.add_argument("--folder", type=Path, default=Path("paper_report"), help="of the report")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    parser.set_defaults(act=_reproduce)


def _reproduce(options: argparse.Namespace) -> int:
    from tqdm import tqdm

    from ..paper import reproduce

    bar = tqdm(unit="run", disable=options.quiet)

    def show(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    with bar:
        studies = reproduce(options.names, options.folder, show)
    asked = [requirement for study in studies for requirement in study.requirements]
    for requirement in asked:
        mark = "reached    " if requirement.reached else "NOT REACHED"
        print(f"{mark}  {requirement.text}: {requirement.measured}")
    print(f"report: {options.folder / 'paper.html'}")
    return 0 if all(requirement.reached for requirement in asked) else 1
