# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda draw`, `movie` and `export`: pictures, movies and VTK files."""

import argparse
from pathlib import Path

from ..base.arguments import (
    ANY_NUMBER,
    COUNT,
    DOTS_PER_INCH,
    PICTURES_A_SECOND,
    SECONDS,
    file_name,
    picture_name,
)
from ..base.files import check_target


def add_draw(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda draw`."""
    add_files(parser, _draw_picture, "PICTURE", picture_name)
    parser.add_argument("-t", "--time", type=ANY_NUMBER, metavar="S",
                        help="time of the frame, s (the last)")  # fmt: skip
    parser.add_argument("--stage", metavar="NAME", help="use the last frame of this stage")
    parser.add_argument("--dpi", type=DOTS_PER_INCH, default=150.0, help="dots per inch (150)")
    _add_look_options(parser)
    add_modes_option(parser)


def add_modes_option(parser: argparse.ArgumentParser) -> None:
    """Add the option --modes."""
    parser.add_argument("--modes", type=COUNT, default=0, metavar="N",
        help="for an input: draw its N lowest modes of vibration")  # fmt: skip


def add_movie(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda movie`."""
    add_files(parser, _make_movie, "MOVIE")
    parser.add_argument(
        "--fps", type=PICTURES_A_SECOND, default=25.0, help="frames per second (25)"
    )
    parser.add_argument("--seconds", type=SECONDS, default=10.0, help="duration of the movie (10)")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    _add_look_options(parser)


def add_export(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda export`."""
    parser.add_argument("file", type=Path, metavar="FILE.nc", help="the output")
    parser.add_argument("--vtk", type=Path, required=True, metavar="FOLDER", help="for ParaView")
    parser.set_defaults(act=_export_output)


def add_files(parser: argparse.ArgumentParser, act, target: str, kind=file_name) -> None:
    """Add the file to show and the file to write; set the function of the command."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="output (during a run, FILE.nc.partial) or namelist input",
    )
    parser.add_argument("-o", "--output", type=kind, metavar=target, help="file to write")
    parser.set_defaults(act=act)


def _add_look_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for colours, contacts and arrows, named as arguments of `pictures.draw`."""
    from .quantities import ARROWS, COLORINGS, CONTACTS

    parser.add_argument("--color", choices=COLORINGS,
        help="colour of blocks (material of an input, displacement of an output)")  # fmt: skip
    parser.add_argument("--contacts", choices=CONTACTS,
        help="draw contact forces (arrows), force chains, slip, or opening")  # fmt: skip
    parser.add_argument("--arrows", choices=ARROWS, help="draw arrows at the centroids of blocks")
    parser.add_argument("--deformation", type=ANY_NUMBER, default=1.0, metavar="FACTOR",
        help="factor on the displacements in the picture (1: to scale)")  # fmt: skip
    parser.add_argument("--since", metavar="STAGE",
        help="show displacements and rotations since the end of this stage")  # fmt: skip
    add_absolute_option(parser)
    parser.add_argument("--scheme", choices=("light", "dark", "print"), default="light",
        help="theme: colours of background, lines and texts (light)")  # fmt: skip


def add_absolute_option(parser: argparse.ArgumentParser) -> None:
    """Add the option --absolute."""
    parser.add_argument("--absolute", action="store_true",
        help="show absolute displacements instead of those relative to the base")  # fmt: skip


def _look_arguments(options: argparse.Namespace) -> dict:
    """Return the arguments of `pictures.draw` from the options of `_add_look_options`."""
    names = ("color", "contacts", "arrows", "deformation", "since", "absolute")
    return {name: getattr(options, name) for name in names}


def _draw_picture(options: argparse.Namespace) -> int:
    """Draw the blocks of an input or output, or the modes of an input, to a file."""
    from ..report.style import save_picture
    from .pictures import draw

    target = options.output or options.file.with_suffix(".blocks.png")
    check_target(target, "a picture", [options.file])
    if options.modes:
        from .modes import draw_modes

        figure = draw_modes(options.file, options.modes)
    else:
        axes = draw(options.file, options.time, stage=options.stage, **_look_arguments(options))
        figure = axes.figure
    target = save_picture(figure, target, [options.file], options.scheme, dpi=options.dpi)
    print(f"picture: {target}")
    return 0


def _make_movie(options: argparse.Namespace) -> int:
    """Write the movie of an output."""
    from .movie import write_movie

    target = options.output or options.file.with_suffix(".mp4")
    write_movie(
        options.file,
        target,
        fps=options.fps,
        seconds=options.seconds,
        scheme=options.scheme,
        progress=not options.quiet,
        **_look_arguments(options),
    )
    print(f"movie: {target}")
    return 0


def _export_output(options: argparse.Namespace) -> int:
    """Write the VTK files of an output."""
    from .vtk import write_vtk

    print(f"file for ParaView: {write_vtk(options.file, options.vtk)}")
    return 0
