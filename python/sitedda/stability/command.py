# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda safety` finds the factor of safety, `sitedda pushover` the capacity curve."""

import argparse
import json
import sys
from pathlib import Path

from ..base.arguments import COUNT, NOT_NEGATIVE, POSITIVE, TOLERANCE, picture_name
from ..base.errors import InputError
from ..base.files import OWN_TABLE, check_target, write
from ..input.changes import add_changes


def add_safety(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda safety`."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument(
        "--factor", type=POSITIVE, help="compute the mechanism at this factor, without a search"
    )
    parser.add_argument("--tolerance", type=TOLERANCE, default=1e-3, help="tolerance of the factor")
    parser.add_argument("--displacement", type=POSITIVE, default=0.05, metavar="FRACTION",
        help="largest displacement of blocks of a stable model, as fraction of their median "
        "radius (0.05)")  # fmt: skip
    parser.add_argument("--least-area", type=NOT_NEGATIVE, default=0.0, metavar="AREA",
        help="ignore mechanisms with an area below this value, m²: remove their blocks "
        "and continue (0)")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print plain values as JSON")
    parser.add_argument("-o", "--output", type=picture_name, help="picture (FILE_mechanism.png)")
    add_changes(parser)
    parser.set_defaults(act=_run_safety)


def _run_safety(options: argparse.Namespace) -> int:
    """Print and draw the factor of safety of an input, or the mechanism at a given factor."""
    from ..report.style import save_picture
    from . import mechanism, safety

    settings = {"displacement": options.displacement, "changes": dict(options.set)}
    picture = options.output or Path(f"{options.file.stem}_mechanism.png")
    check_target(picture, "a picture", [options.file])
    if options.factor is None:
        result = safety(options.file, tolerance=options.tolerance, least_area=options.least_area,
                        progress=_show_trial if sys.stderr.isatty() else None,
                        **settings)  # fmt: skip
        moving = result.mechanism
    else:
        result = moving = mechanism(options.file, options.factor, **settings)
    print(json.dumps(result.to_dict(), indent=1) if options.json else result)
    if moving is None:
        return 0
    picture = save_picture(result.draw().figure, picture, [options.file], dpi=130)
    if not options.json:
        print(f"\npicture: {picture}")
    return 0


def _show_trial(trial) -> None:
    """Print factor and result of a trial to standard error."""
    print("strength divided by", str(trial).strip(), file=sys.stderr)


def add_pushover(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda pushover`."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument(
        "--point", required=True, metavar="NAME", help="measured point whose displacement is shown"
    )
    parser.add_argument("--load", choices=("horizontal", "tilt", "mode"), default="horizontal")
    parser.add_argument("--sense", type=int, choices=(1, -1), default=1, help="sign along x (1)")
    parser.add_argument("--displacement", type=POSITIVE, metavar="M",
        help="largest displacement (a tenth of the height of the point)")  # fmt: skip
    parser.add_argument("--steps", type=COUNT, default=200, help="number of static steps (200)")
    parser.add_argument("--ec8", nargs=2, metavar=("PEAK", "GROUND"), help="print the performance "
        "point of Eurocode 8: peak acceleration on rock (m/s²), ground A to E")  # fmt: skip
    parser.add_argument("--method", choices=("n2", "mechanism"), help="method of the "
        "performance point with --ec8: N2, or rocking mechanism of the Italian code "
        "(Circolare 617/2009) (n2)")  # fmt: skip
    parser.add_argument("--limits", action="store_true", help="add limit loads of rigid blocks")
    parser.add_argument("-o", "--output", type=picture_name, help="picture (FILE_pushover.png)")
    add_changes(parser)
    parser.set_defaults(act=_run_pushover)


def _run_pushover(options: argparse.Namespace) -> int:
    """Compute a capacity curve; write picture and table, and print the performance point."""
    from ..report.style import save_picture
    from . import limit_analysis, performance_point, pushover
    from .code_spectra import eurocode8

    spectrum = None
    if options.method and not options.ec8:
        raise InputError(f"--method {options.method} requires a spectrum: add --ec8 PEAK GROUND")
    if options.ec8:
        peak, ground = options.ec8
        spectrum = eurocode8(POSITIVE.check("--ec8", peak), ground)
    picture = options.output or options.file.with_name(f"{options.file.stem}_pushover.png")
    check_target(picture, "a picture", [options.file])
    changes = dict(options.set)
    curve = pushover(options.file, options.point, load=options.load, sense=options.sense,
                     displacement=options.displacement, steps=options.steps,
                     changes=changes)  # fmt: skip
    print(curve)
    limits = None
    if options.limits:
        limits = limit_analysis(options.file, direction=(options.sense, 0.0), changes=changes)
        print(f"limit analysis: {limits.lower.factor:.4g} without dilation (lowest of "
              f"{limits.starts} starts), {limits.upper.factor:.4g} with dilation")  # fmt: skip
    picture = save_picture(curve.draw(limits), picture, [options.file], dpi=130)
    print(f"picture: {picture}")
    table = write(picture.with_suffix(".csv"), curve.to_csv(), OWN_TABLE, [options.file])
    print(f"curve: {table}")
    if spectrum:
        point = performance_point(curve, spectrum, method=options.method or "n2")
        print(f"performance: {point}")
        figure = picture.with_name(f"{picture.stem}_performance{picture.suffix}")
        print(f"picture: {save_picture(point.draw(), figure, [options.file], dpi=130)}")
    return 0
