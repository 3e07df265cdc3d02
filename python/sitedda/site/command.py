# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda site` compares blocks with a column; `sitedda surface` draws amplification along it."""

import argparse
import math
import warnings
from pathlib import Path

from ..base.arguments import DAMPING_RATIO, NOT_NEGATIVE, POSITIVE, WORKERS, picture_name
from ..base.errors import InputError, PeakWarning, located
from ..engine.record_options import add_record_options, read_described

# Options of `sitedda site` by the kind of the file, besides those that all kinds have.
_READING = ("within", "format", "quantity", "unit", "time_step")  # of a record
_OPTIONS = {
    "a CSV profile": ("record", *_READING, "water_table", "fill"),
    "a suite": ("folder", "workers", "retry"),
    "a model or its output": ("surface", "base", "damping"),
}


def add_site(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda site`."""
    _add_files(parser, "FILE", "output, input to run, CSV profile, or TOML file of a suite")
    parser.add_argument("--surface", help="measured point at the surface (as in &amplification)")
    parser.add_argument("--base", help="measured point at the base (as in &amplification)")
    parser.add_argument("--damping", type=DAMPING_RATIO, metavar="RATIO",
        help="damping ratio of the layers of the column, such as 0.05 (as in the run)")  # fmt: skip
    parser.add_argument("--record", type=Path, help="for a CSV profile: ground motion")
    parser.add_argument("--within", action="store_true",
        help="the record is a within motion, not an outcrop motion")  # fmt: skip
    add_record_options(parser)
    parser.add_argument("--water-table", type=NOT_NEGATIVE, metavar="M",
        help="for a CSV profile: depth of the water table, for effective stresses (none)",
    )  # fmt: skip
    parser.add_argument("--fill", choices=("above", "interpolate"),
        help="fill gaps of a CSV profile: value above, or linear interpolation")  # fmt: skip
    parser.add_argument("--folder", type=Path, help="for a suite: folder of cases and results")
    parser.add_argument("-w", "--workers", type=WORKERS, help="for a suite: number of processes")
    parser.add_argument("--retry", action="store_true", help="for a suite: repeat failed cases")
    parser.add_argument("-q", "--quiet", action="store_true", help="for a suite: no progress bar")
    parser.set_defaults(act=_compute_site)


def add_surface(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda surface`."""
    _add_files(parser, "FILE.nc")
    parser.add_argument("--axis", choices=("x", "y"), default="x", help="direction of motion (x)")
    for name, usual in (("lowest", 0.5), ("highest", 15.0)):
        parser.add_argument(f"--{name}", type=POSITIVE, default=usual, metavar="HZ",
            help=f"{name} frequency ({usual:g})")  # fmt: skip
    parser.add_argument("--section", action="store_true",
        help="draw a section: velocity histories of the points, side by side")  # fmt: skip
    parser.set_defaults(act=_compute_surface)


def _add_files(parser: argparse.ArgumentParser, file: str, description: str | None = None) -> None:
    """Add the arguments of the file to read, and of the picture."""
    parser.add_argument("file", type=Path, metavar=file, help=description)
    parser.add_argument("-o", "--output", type=picture_name, metavar="PICTURE",
        help="file to write")  # fmt: skip


def _compute_surface(options: argparse.Namespace) -> int:
    """Print and draw the amplification along the surface of an output."""
    from ..output.scene import open_output
    from .surface import surface

    with located(options.file, ValueError):
        result = surface(open_output(options.file), options.axis, options.lowest, options.highest)
    print(result)
    name = "section" if options.section else "surface"
    picture = options.output or options.file.with_name(f"{options.file.stem}_{name}.png")
    figure = result.section(options.axis) if options.section else result.plot()
    _save_figure(figure, picture, options.file)
    return 0


def _save_figure(figure, picture: Path, source: Path) -> None:
    """Save a figure, and print its file name."""
    from ..report.style import save_picture

    print(f"picture: {save_picture(figure, picture, [source], dpi=130)}")


def _compute_profile(options: argparse.Namespace) -> int:
    """Print and draw a CSV profile, and its response to a record if one is given."""
    from . import analyses, read_profile

    if options.record is None and (unused := _given(options, _READING)):
        raise InputError(f"{_option(unused[0])} needs --record")
    path, profile = options.file, read_profile(options.file, options.fill or "")
    water_table = math.inf if options.water_table is None else options.water_table
    print(profile)
    if strength_text := profile.strength_words(water_table):
        print(strength_text)
    picture = options.output or path.with_name(f"{path.stem}_profile.png")
    if options.record is None:
        _save_figure(profile.plot(), picture, path)
        return 0
    motion, curves = read_described(options.record, options), profile.curves(water_table)
    kind = "within" if options.within else "outcrop"
    with located(path, ValueError):
        if any(curves):
            result = analyses(profile.column(), curves, motion, kind=kind)
        else:
            result = profile.column().response(motion, kind=kind)
        print(result)
    if options.output is None:  # otherwise the output names the picture of the response
        _save_figure(profile.plot(), picture, path)
    _save_figure(result.plot(), options.output or path.with_name(f"{path.stem}_site.png"), path)
    return 0


def _compute_suite(options: argparse.Namespace) -> int:
    """Compute the response to a suite of motions; write table, CSV, picture and page."""
    from . import read_suite, suite

    settings = read_suite(options.file, options.folder)
    result = suite(**settings, workers=options.workers, retry=options.retry,
                  progress=not options.quiet)  # fmt: skip
    print(result)
    folder = settings["folder"]
    print(f"table: {result.to_netcdf(folder / 'suite.nc')}")
    print(f"statistics: {result.to_csv(folder / 'suite.csv')}")
    _save_figure(result.plot(), options.output or folder / "suite.png", options.file)
    print(f"page: {result.write_page(folder / 'suite.html')}")
    return 0


def _compute_site(options: argparse.Namespace) -> int:
    """Carry out `sitedda site` for the kind of the file: profile, suite, input or output."""
    kinds = {".csv": "a CSV profile", ".txt": "a CSV profile", ".toml": "a suite"}
    kind = kinds.get(options.file.suffix.lower(), "a model or its output")
    others = [name for other, names in _OPTIONS.items() if other != kind for name in names]
    if wrong := _given(options, others):
        raise InputError(f"{_option(wrong[0])} does not apply to {kind}, whose options are "
                         f"{', '.join(map(_option, _OPTIONS[kind]))}")  # fmt: skip
    compute = {"a CSV profile": _compute_profile, "a suite": _compute_suite}
    return compute.get(kind, _compare_with_column)(options)


def _given(options: argparse.Namespace, names) -> list[str]:
    """Return the names of options in the command."""
    values = {name: getattr(options, name) for name in names}
    return [name for name, value in values.items() if value is not None and value is not False]


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _compare_with_column(options: argparse.Namespace) -> int:
    """Compare an output, or the run of an input, with a one-dimensional column."""
    from ..engine.simulation import completed_run
    from ..output.scene import open_output
    from .beside import beside

    path = options.file
    if path.suffix != ".nc":
        with completed_run(path, True) as (path, simulation):
            for message in simulation.peak_warnings:
                warnings.warn(message, PeakWarning, stacklevel=1)
        print(f"output: {path}")
    history = open_output(path)
    with located(options.file, ValueError):
        result = beside(history, options.surface, options.base, options.damping)
    print(result)
    picture = options.output or path.with_name(f"{path.stem}_site.png")
    _save_figure(result.plot(), picture, options.file)
    return 0
