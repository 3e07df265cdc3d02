# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands that show a model or an output: draw, view, movie, export, report."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.arguments import (
    ANY,
    DOTS_PER_INCH,
    PICTURES_A_SECOND,
    SECONDS,
    file_name,
    picture_name,
)
from ..base.files import check_target, save_picture

COLORINGS = ("material", "displacement", "velocity", "rotation", "stress")


def add_draw(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda draw`."""
    _add(parser, _draw, "PICTURE", picture_name)
    parser.add_argument("-t", "--time", type=ANY, metavar="S", help="of the frame (the last)")
    parser.add_argument("--stage", metavar="NAME", help="that the frame is one of")
    parser.add_argument("--dpi", type=DOTS_PER_INCH, default=150.0, help="dots per inch (150)")
    _add_look(parser)


def add_view(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda view`."""
    _add(parser, _view, "PAGE")
    parser.add_argument("--color", choices=COLORINGS, help="what blocks are coloured by at first")
    parser.add_argument("--no-open", action="store_true", help="do not open a browser")


def add_movie(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda movie`."""
    _add(parser, _movie, "MOVIE")
    parser.add_argument(
        "--fps", type=PICTURES_A_SECOND, default=25.0, help="pictures a second (25)"
    )
    parser.add_argument("--seconds", type=SECONDS, default=10.0, help="that the movie lasts (10)")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    _add_look(parser)


def add_export(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda export`."""
    parser.add_argument("file", type=Path, metavar="FILE.nc")
    parser.add_argument("--vtk", type=Path, required=True, metavar="FOLDER", help="for ParaView")
    parser.set_defaults(act=_export)


def add_report(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda report`."""
    _add(parser, _report, "PAGE")
    parser.add_argument("--open", action="store_true", help="open it in a browser")


def _add(parser: argparse.ArgumentParser, act, target: str, kind=file_name) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="output, or namelist input")
    parser.add_argument("-o", "--output", type=kind, metavar=target, help="file to write")
    parser.set_defaults(act=act)


def _add_look(parser: argparse.ArgumentParser) -> None:
    """What blocks and contacts are coloured by; the words are those of `pictures.draw`."""
    parser.add_argument(
        "--color",
        choices=COLORINGS,
        help="what blocks are coloured by (a model: material; an output: displacement)",
    )
    parser.add_argument(
        "--contacts", choices=("force", "slip", "open"), help="draw forces, slip or opening"
    )
    parser.add_argument(
        "--deformation", type=ANY, default=1.0, metavar="FACTOR", help="on displacements (1)"
    )


def _draw(options: argparse.Namespace) -> int:
    from ..drawing.pictures import draw

    look = (options.color, options.contacts, options.deformation)
    target = check_target(
        options.output or options.file.with_suffix(".blocks.png"), "a picture", [options.file]
    )
    axes = draw(options.file, options.time, *look, stage=options.stage)
    target = save_picture(axes.figure, target, [options.file], dpi=options.dpi)
    print(f"picture: {target}")
    return 0


def _view(options: argparse.Namespace) -> int:
    from ..drawing.view import write_view

    target = check_target(
        options.output or options.file.with_suffix(".view.html"), "a page", [options.file]
    )
    _say_page(write_view(options.file, target, color=options.color), not options.no_open)
    return 0


def _report(options: argparse.Namespace) -> int:
    from ..facade.page import report_page
    from ..report import write_html

    target = check_target(
        options.output or options.file.with_suffix(".html"), "a page", [options.file]
    )
    _say_page(write_html(report_page(options.file), target), options.open)
    return 0


def _say_page(file: Path, show: bool) -> None:
    print(f"page: {file} ({file.stat().st_size / 1e6:.2g} MB)")
    if show:
        import webbrowser

        webbrowser.open(file.resolve().as_uri())


def _movie(options: argparse.Namespace) -> int:
    from ..drawing.movie import write_movie

    target = options.output or options.file.with_suffix(".mp4")
    write_movie(
        options.file,
        target,
        fps=options.fps,
        seconds=options.seconds,
        color=options.color,
        contacts=options.contacts,
        deformation=options.deformation,
        progress=not options.quiet,
    )
    print(f"movie: {target}")
    return 0


def _export(options: argparse.Namespace) -> int:
    from ..output.vtk import write_vtk

    print(f"ParaView opens {write_vtk(options.file, options.vtk)}")
    return 0
