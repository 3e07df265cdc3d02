# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda build`: convert joints and masonry of an input into blocks."""

import argparse
from pathlib import Path

from ..base.arguments import file_name
from ..base.core import print_notes


def add_build(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument("-o", "--output", type=file_name, help="input to write (FILE_blocks.nml)")
    parser.add_argument(
        "--block-file",
        action=argparse.BooleanOptionalAction,
        help="write the blocks to a separate netCDF file (default for 10,000 blocks or more)",
    )
    parser.set_defaults(act=_run_build)


def _run_build(options: argparse.Namespace) -> int:
    """Write an input with blocks instead of joints and masonry; print a summary."""
    from .building import build_file, summary

    output, built = build_file(options.file, options.output, options.block_file)
    print(summary(built))
    print_notes("\n".join(built.messages))
    print(f"output: {output}")
    return 0
