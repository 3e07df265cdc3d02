# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda view` and `report` write pages; `sitedda record` reads and draws a ground motion."""

import argparse
import sys
from pathlib import Path

from ..base.arguments import picture_name
from ..base.errors import InputError, OutputError
from ..base.files import check_target
from ..drawing.command import add_absolute_option, add_files, add_modes_option
from ..engine.record_options import add_record_options, read_described


def add_view(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda view`."""
    add_files(parser, _show_view, "PAGE")
    parser.add_argument("other", type=Path, nargs="?", metavar="OTHER",
        help="another output, shown beside the first with a common time cursor")  # fmt: skip
    parser.add_argument("--difference", action="store_true",
        help="colour the first output by its values minus the values of the second")  # fmt: skip
    add_modes_option(parser)
    from ..drawing.quantities import COLORINGS

    parser.add_argument("--color", choices=COLORINGS, help="initial colour of blocks")
    add_absolute_option(parser)
    parser.add_argument("--no-open", action="store_true", help="do not open a browser")


def add_report(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda report`."""
    add_files(parser, _write_report, "PAGE")
    parser.add_argument("--open", action="store_true", help="open the page in a browser")


def _show_view(options: argparse.Namespace) -> int:
    """Write the interactive view of an input or output to a page, and open it."""
    from ..drawing.view import write_view
    from ..output.scene import Scene
    from .page import bars_of

    target = options.output or options.file.with_suffix(".view.html")
    check_target(target, "a page", [options.file])
    if options.difference and not options.other:
        raise InputError("--difference needs two outputs: sitedda view A.nc B.nc --difference")
    source, color = options.file, options.color
    if options.modes:
        from ..drawing.modes import mode_scene

        source, color = mode_scene(options.file, options.modes)[0], color or "displacement"
    scene = Scene.of(source, options.absolute)
    page = write_view(scene, target, color=color, other=options.other,
                      difference=options.difference, below=bars_of(scene),
                      absolute=options.absolute)  # fmt: skip
    _print_page(page, not options.no_open)
    return 0


def _write_report(options: argparse.Namespace) -> int:
    """Write the report of an input or output to a page."""
    from ..report import write_html
    from .page import report_page

    target = options.output or options.file.with_suffix(".html")
    check_target(target, "a page", [options.file])
    _print_page(write_html(report_page(options.file), target), options.open)
    return 0


def _print_page(file: Path, show: bool) -> None:
    """Print name and size of a page; open it in a browser if requested."""
    print(f"page: {file} ({file.stat().st_size / 1e6:.2g} MB)")
    if show:
        import webbrowser

        webbrowser.open(file.resolve().as_uri())


def add_record(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `sitedda record`."""
    parser.add_argument("file", type=Path, metavar="RECORD")
    add_record_options(parser)
    parser.add_argument("-o", "--output", type=picture_name, metavar="PICTURE",
        help="picture to write (RECORD.png)")  # fmt: skip
    parser.add_argument("-f", "--force", action="store_true", help="overwrite an existing picture")
    parser.set_defaults(act=_run_record)


def _run_record(options: argparse.Namespace) -> int:
    """Print the intensity measures of a record, and draw its motion."""
    from ..site.intensity import intensity
    from .plot import record_panels

    picture = options.output or Path(f"{options.file.stem}.png")
    if not options.force:
        _confirm_overwriting(picture)
    motion = read_described(options.file, options)
    print(f"{motion.attrs['station']} {motion.attrs['description']}".strip())
    print(f"{motion.time.size} samples, {float(motion.time[-1]):.3f} s; {motion.attrs['method']}")
    for name in ("acceleration", "velocity", "displacement"):
        print(f"largest {name}: {float(abs(motion[name]).max()):.6g} {motion[name].units}")
    if motion.acceleration.any():
        print(intensity(motion))
    print(f"picture: {record_panels(motion, picture)}")
    return 0


def _confirm_overwriting(file: Path) -> None:
    """Raise OutputError if a file exists and the user does not agree to overwrite it."""
    if not file.exists():
        return
    if sys.stdin.isatty() and input(f"{file} exists. Overwrite it? [y/N] ").lower() in ("y", "yes"):
        return
    raise OutputError(f"{file} exists: --force overwrites it, --output names another file")
