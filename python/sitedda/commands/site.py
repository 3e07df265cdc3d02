# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda site`: blocks and column of a layered site; `sitedda surface`: hills and valleys."""

import argparse
from pathlib import Path

from ..base.arguments import DAMPING_RATIO, NOT_NEGATIVE, POSITIVE, picture_name
from ..base.errors import InputError


def add_site(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda site`."""
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="output, namelist input to run, or CSV profile"
    )
    parser.add_argument(
        "-o", "--output", type=picture_name, metavar="PICTURE", help="file to write"
    )
    parser.add_argument("--surface", help="measured point (that of &amplification)")
    parser.add_argument("--base", help="measured point (that of &amplification)")
    parser.add_argument(
        "--damping",
        type=DAMPING_RATIO,
        metavar="RATIO",
        help="of the column's layers, 0.05 is 5 %% (that of the run's time integration)",
    )
    parser.add_argument("--record", type=Path, help="of a CSV profile: ground motion")
    parser.add_argument(
        "--within", action="store_true", help="the record is of the base itself, not of an outcrop"
    )
    parser.add_argument(
        "--water-table", type=NOT_NEGATIVE, default=float("inf"), metavar="M",
        help="depth, of effective stresses of a CSV profile (none)",
    )  # fmt: skip
    parser.set_defaults(act=_site)


def add_surface(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda surface`."""
    parser.add_argument("file", type=Path, metavar="FILE.nc")
    parser.add_argument(
        "-o", "--output", type=picture_name, metavar="PICTURE", help="file to write"
    )
    parser.add_argument("--axis", choices=("x", "y"), default="x", help="of the motion (x)")
    parser.add_argument("--lowest", type=POSITIVE, default=0.5, metavar="HZ", help="(0.5)")
    parser.add_argument("--highest", type=POSITIVE, default=15.0, metavar="HZ", help="(15)")
    parser.add_argument("--section", action="store_true",
        help="draw the velocities of the points over time beside each other")  # fmt: skip
    parser.set_defaults(act=_surface)


def _surface(options: argparse.Namespace) -> int:
    from ..output.scene import open_output
    from ..site.surface import surface

    try:
        found = surface(open_output(options.file), options.axis, options.lowest, options.highest)
    except ValueError as trouble:
        raise InputError(f"{options.file}: {trouble}") from trouble
    print(found)
    name = "section" if options.section else "surface"
    picture = options.output or options.file.with_name(f"{options.file.stem}_{name}.png")
    _save(found.section(options.axis) if options.section else found.plot(), picture, options.file)
    return 0


def _save(figure, picture: Path, source: Path) -> None:
    from ..report.style import save_picture

    print(f"picture: {save_picture(figure, picture, [source], dpi=130)}")


def _profile(options: argparse.Namespace) -> int:
    """A CSV profile: its table and picture, and its columns under a record."""
    from ..engine.records import read_record
    from ..site import analyses, read_profile

    path, profile = options.file, read_profile(options.file)
    print(profile)
    picture = options.output or path.with_name(f"{path.stem}_profile.png")
    if options.record is None:
        _save(profile.plot(), picture, path)
        return 0
    motion, curves = read_record(options.record), profile.curves(options.water_table)
    kind = "within" if options.within else "outcrop"
    try:
        if any(curves):
            found = analyses(profile.column(), curves, motion, kind=kind)
        else:
            found = profile.column().response(motion, kind=kind)
    except ValueError as trouble:
        raise InputError(f"{path}: {trouble}") from trouble
    print(found)
    _save(profile.plot(), path.with_name(f"{path.stem}_profile.png"), path)
    _save(found.plot(), options.output or path.with_name(f"{path.stem}_site.png"), path)
    return 0


def _site(options: argparse.Namespace) -> int:
    if options.file.suffix.lower() in (".csv", ".txt"):
        return _profile(options)
    return _beside(options)


def _beside(options: argparse.Namespace) -> int:
    from ..facade.run import run
    from ..output.scene import open_output
    from ..site.beside import beside

    path = options.file
    if path.suffix == ".nc":
        history = open_output(path)
    else:
        result = run(path, True)
        print(f"output: {result.output}")
        path, history = result.output, result.history
    try:
        found = beside(history, options.surface, options.base, options.damping)
    except ValueError as trouble:
        raise InputError(f"{options.file}: {trouble}") from trouble
    print(found)
    _save(found.plot(), options.output or path.with_name(f"{path.stem}_site.png"), options.file)
    return 0
