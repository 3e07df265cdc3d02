# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda live`: edit, run and watch a model in the browser."""

import argparse
import os
from pathlib import Path

from ..base.arguments import Range
from ..input.examples import example_files, record_files

_PORT = Range(0, 65535, whole=True)


def add_live(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", nargs="?", type=Path, metavar="FILE.nml",
        help="input to open (none: start page)")  # fmt: skip
    parser.add_argument("--port", type=_PORT, default=0, help="port of the server (the last used)")
    parser.add_argument("--no-open", action="store_true", help="do not open a browser")
    parser.add_argument("--notebook", action="store_true", help="serve `LiveWidget` in a notebook")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="listen at another address than 127.0.0.1; the connection is not encrypted",
    )
    parser.set_defaults(act=_serve_live)


def _serve_live(options: argparse.Namespace) -> int:
    """Serve the live page until it is stopped."""
    from .server import run_server
    from .starts import BundledFiles

    file = Path(os.path.abspath(options.file)) if options.file else None
    folder = file.parent if file else Path.cwd()
    bundled_files = BundledFiles(example_files(), record_files())
    show = not (options.no_open or options.notebook)
    run_server(folder, file, bundled_files, options.host, options.port, show, options.notebook)
    return 0
