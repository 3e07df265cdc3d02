# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda accuracy`: error bars of the results of an input."""

import argparse
import json
from pathlib import Path

from ...base.arguments import COUNT, WORKERS, picture_name
from ...input.changes import add_changes


def add_accuracy(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument(
        "--ensemble",
        type=COUNT,
        default=0,
        metavar="N",
        help="also run N twins, each with one displaced block; report 16, 50 and 84 %% fractiles",
    )
    parser.add_argument("-o", "--output", type=picture_name, help="picture (FILE_bands.png)")
    parser.add_argument("--folder", type=Path,
                        help="folder of the runs, to resume them (a temporary one)")  # fmt: skip
    parser.add_argument("-w", "--workers", type=WORKERS, help="processes (one per processor)")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    parser.add_argument("--json", action="store_true", help="print plain values as JSON")
    add_changes(parser)
    parser.set_defaults(act=_run_accuracy)


def _run_accuracy(options: argparse.Namespace) -> int:
    """Print the error bars of an input, and draw its ensemble if there is one."""
    from ...report.style import save_picture
    from . import accuracy

    estimate = accuracy(
        options.file, changes=dict(options.set), ensemble=options.ensemble, folder=options.folder,
        workers=options.workers, progress=not (options.quiet or options.json),
    )  # fmt: skip
    print(json.dumps(estimate.to_dict(), indent=1) if options.json else estimate)
    if estimate.bands:
        picture = options.output or Path(f"{options.file.stem}_bands.png")
        picture = save_picture(estimate.draw(), picture, [options.file], dpi=130)
        if not options.json:
            print(f"\npicture: {picture}")
    return 0
