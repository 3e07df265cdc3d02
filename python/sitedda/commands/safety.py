# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda safety`: find the factor of safety of an input."""

import argparse
import json
import sys
from pathlib import Path

from ..base.arguments import NOT_NEGATIVE, POSITIVE, TOLERANCE, picture_name
from ..base.files import check_target
from .parser import add_changes


def add_safety(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument(
        "--factor", type=POSITIVE, help="compute the mechanism at this factor, without a search"
    )
    parser.add_argument("--tolerance", type=TOLERANCE, default=1e-3, help="tolerance of the factor")
    parser.add_argument("--displacement", type=POSITIVE, default=0.05, metavar="FRACTION",
        help="largest displacement of blocks of a stable model, as fraction of their median "
        "radius (0.05)")  # fmt: skip
    parser.add_argument("--least-area", type=NOT_NEGATIVE, default=0.0, metavar="AREA",
        help="remove the blocks of mechanisms with a smaller area, m² (0)")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print plain values as JSON")
    parser.add_argument("-o", "--output", type=picture_name, help="picture (FILE_mechanism.png)")
    add_changes(parser)
    parser.set_defaults(act=_run_safety)


def _run_safety(options: argparse.Namespace) -> int:
    """Print and draw the factor of safety of an input, or the mechanism at a given factor."""
    from ..report.style import save_picture
    from ..stability import mechanism, safety

    changes, share = dict(options.set), options.displacement
    picture = options.output or Path(f"{options.file.stem}_mechanism.png")
    check_target(picture, "a picture", [options.file])
    if options.factor is None:
        found = safety(
            options.file, tolerance=options.tolerance, displacement=share, changes=changes,
            least_area=options.least_area,
            progress=_show_trial if sys.stderr.isatty() else None,
        )  # fmt: skip
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


def _show_trial(trial) -> None:
    """Print factor and result of a trial to standard error."""
    print("strength divided by", str(trial).strip(), file=sys.stderr)
