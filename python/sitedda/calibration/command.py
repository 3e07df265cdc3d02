# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda calibrate`: estimate unknown stiffnesses of a model from measured modes."""

import argparse
from pathlib import Path

from ..base.arguments import COUNT, NOT_NEGATIVE, picture_name
from ..base.core import folded
from ..base.errors import InputError
from ..base.files import OWN_TABLE, check_target, write
from ..input.changes import add_changes


def add_calibrate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, metavar="FILE.nml", help="the input")
    parser.add_argument("modes", type=Path, metavar="MODES.csv",
        help="measured modes; with --record, a record of ambient vibrations")  # fmt: skip
    parser.add_argument("--record", type=_parse_range, metavar="LOW:HIGH",
        help="read MODES as a vibration record; identify its modes in this band (Hz)")  # fmt: skip
    parser.add_argument("--unknown", action="append", required=True, type=_parse_unknown,
        metavar="NAME=LOW:HIGH", help="unknown stiffness, and its range with a probability "
        "of 90 %%: contact.normal_stiffness=5e7:1e9")  # fmt: skip
    parser.add_argument("--discrepancy", type=_parse_discrepancy, default=0.02, metavar="R",
        help="relative error of the model's frequencies (0.02), or 'unknown'")  # fmt: skip
    parser.add_argument(
        "--sampler", choices=("laplace", "ensemble"), default="laplace", help="method (laplace)"
    )
    parser.add_argument("--samples", type=COUNT, default=1000, help="number of samples (1000)")
    parser.add_argument("-o", "--output", type=picture_name, help="picture (FILE_calibration.png)")
    add_changes(parser)
    parser.set_defaults(act=_run_calibrate)


def _parse_unknown(text: str) -> tuple[str, tuple[float, float]]:
    """Return name and range of an unknown, NAME=LOW:HIGH."""
    name, _, limits = text.rpartition("=")
    return name.strip(), _parse_range(limits, text, "NAME=LOW:HIGH")


def _parse_range(limits: str, text: str = "", form: str = "LOW:HIGH") -> tuple[float, float]:
    """Return both ends of a range LOW:HIGH; an error shows the whole text and the right form."""
    try:
        low, high = map(float, limits.split(":"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text or limits!r} is not {form}") from None
    return low, high


def _parse_discrepancy(text: str) -> float | None:
    """Return the relative error of the model's frequencies; None for 'unknown'."""
    return None if text == "unknown" else NOT_NEGATIVE(text)


def _run_calibrate(options: argparse.Namespace) -> int:
    """Estimate the unknowns of an input from measured modes; write picture and samples."""
    from ..report.style import save_picture
    from . import calibrate, identify
    from .picture import draw_calibration

    picture = options.output or options.file.with_name(f"{options.file.stem}_calibration.png")
    inputs = [options.file, options.modes]
    check_target(picture, "a picture", inputs)
    sample = check_target(picture.with_suffix(".csv"), OWN_TABLE, inputs)
    changes, modes, unknowns = dict(options.set), options.modes, dict(options.unknown)
    if len(unknowns) < len(options.unknown):
        raise InputError(f"--unknown: a name is repeated; the names are {', '.join(unknowns)}")
    if options.record:
        modes = picture.with_name(f"{options.modes.stem}_modes.csv")
        table = identify(options.modes, options.record)
        identified_modes = table.to_csv(index=False, float_format="%.6g")
        identified_modes = f"# written by sitedda\n{identified_modes}"
        print(f"modes: {write(modes, identified_modes, OWN_TABLE, inputs)}")
    result = calibrate(options.file, modes, unknowns, discrepancy=options.discrepancy,
                      sampler=options.sampler, samples=options.samples,
                      changes=changes)  # fmt: skip
    print(folded(str(result)))
    figure = draw_calibration(options.file, result, changes)
    print(f"picture: {save_picture(figure, picture, inputs, dpi=130)}")
    print(f"samples: {write(sample, result.to_csv(), OWN_TABLE, inputs)}")
    return 0
