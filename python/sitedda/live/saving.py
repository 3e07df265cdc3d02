# SPDX-License-Identifier: GPL-3.0-or-later
"""Save the input (namelist), script, report, movie or output of a run in the working folder."""

import os
import shutil
from pathlib import Path

from ..base.errors import InputError
from ..base.files import OWN_INPUT, OWN_SCRIPT, is_below, make_folder, plain_text, write, written
from ..input.input_text import find_groups
from .script import changes_outside_stages, written_script

ENDINGS = {"namelist": ".nml", "script": ".py", "report": ".html", "movie": ".mp4", "output": ".nc"}
_FIRST_LINE = "! written by sitedda\n"


def place(folder: Path, name: str, kind: str) -> Path:
    """Return the path of a file to save in a folder; add the ending of its kind."""
    if kind not in ENDINGS:
        raise InputError(f"{kind!r} cannot be saved; use one of {', '.join(ENDINGS)}")
    plain_text("name", name)
    if not name.strip() or not is_below(folder, name):
        raise InputError(f"{name!r} is not the name of a file in {folder}")
    file = folder / name
    file = file if file.suffix == ENDINGS[kind] else file.with_name(file.name + ENDINGS[kind])
    if not file.parent.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{name!r} is outside of {folder}; choose a name in this folder")
    return file


def save_namelist(text: str, source: Path, target: Path, actions: list[dict]) -> list[Path]:
    """Write an input; copy the files that it names if its folder is another one.

    `text`: the input with the stages that were added during the run.
    `source`: original file of the input.
    `target`: file to write.
    `actions`: actions of the run; comments list the actions that no stage can express.
    """
    changes = changes_outside_stages(actions)
    comments = "".join(f"! only in the script: {change}\n" for change in changes)
    text = text if text.startswith(_FIRST_LINE) else _FIRST_LINE + text
    text = text.replace(_FIRST_LINE, _FIRST_LINE + comments, 1)
    copies = [] if source.parent.resolve() == target.parent.resolve() else _named_files(
        text, source, target.parent
    )  # fmt: skip
    for file, data in copies:
        make_folder(file.parent)
        write(file, data, "the example")
    return [write(target, text, OWN_INPUT), *(file for file, _ in copies)]


def _named_files(text: str, source: Path, folder: Path) -> list[tuple[Path, bytes]]:
    """Return the content of each file that groups name, and its path below another folder."""
    contents = {}
    for group in find_groups(text, source, ("block",)):
        name = group.values.get("file", "")
        if group.name == "output" or not name or os.path.isabs(name):
            continue
        if not is_below(source.parent, name):
            raise InputError(
                f"&{group.name} refers to {name}, outside of {source.parent} and therefore "
                "not copied; move it into this folder, or give an absolute path"
            )
        contents[folder / name] = (source.parent / name).read_bytes()
    return list(contents.items())


def save_script(
    model: Path, target: Path, title: str, actions: list[dict], steps: int | None
) -> Path:
    """Write a script that repeats a run of the input `model`; see `written_script`."""
    name = os.path.relpath(model, target.parent)
    output = target.with_suffix(".nc").name
    return write(target, written_script(name, output, title, actions, steps), OWN_SCRIPT)


def save_report(output: Path, target: Path) -> Path:
    """Write the report of a run."""
    from ..facade.page import report_page
    from ..report import write_html

    return write_html(report_page(output), target)


def save_movie(output: Path, target: Path) -> Path:
    """Write a movie of the blocks of a run."""
    from ..drawing.movie import write_movie

    write_movie(output, target, progress=False)
    return target


def save_output(output: Path, target: Path) -> Path:
    """Copy the output of a run."""
    with written(target, "a netCDF file") as temporary:
        shutil.copyfile(output, temporary)
    return target
