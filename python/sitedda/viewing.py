"""Sub-commands that show a model or an output: draw."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_viewing_commands(commands) -> None:
    """Add the sub-commands to those of the command line."""
    drawing = commands.add_parser("draw", help="draw the blocks of an input or an output")
    drawing.add_argument("file", type=Path, metavar="FILE", help="namelist input or output")
    _add_look(drawing)
    drawing.add_argument("-t", "--time", type=float, metavar="S", help="of the frame (the last)")
    drawing.add_argument(
        "-o", "--output", type=Path, metavar="PICTURE", help=".png, .svg or .pdf (FILE.blocks.png)"
    )
    drawing.add_argument("--dpi", type=float, default=150.0, help="dots per inch (150)")
    drawing.set_defaults(act=_draw)


def _add_look(parser: argparse.ArgumentParser) -> None:
    """What blocks and contacts are coloured by; the words are those of `pictures.draw`."""
    parser.add_argument(
        "--color",
        choices=("material", "displacement", "velocity", "rotation", "stress"),
        help="what blocks are coloured by (a model: material; an output: displacement)",
    )
    parser.add_argument(
        "--contacts", choices=("force", "slip", "open"), help="draw forces, slip or opening"
    )
    parser.add_argument(
        "--deformation", type=float, default=1.0, metavar="FACTOR", help="on displacements (1)"
    )


def _draw(options: argparse.Namespace) -> int:
    from .pictures import draw

    axes = draw(options.file, options.time, options.color, options.contacts, options.deformation)
    target = options.output or options.file.with_suffix(".blocks.png")
    axes.figure.savefig(target, dpi=options.dpi)
    print(f"picture: {target}")
    return 0
