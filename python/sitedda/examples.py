# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda example`: inputs that run as they are, copied with the files that they name."""

from __future__ import annotations

import argparse
import re
from importlib.resources import files
from pathlib import Path

from .errors import InputError, OutputError
from .groups import nearest

_SUFFIX = ".nml"
_QUOTED = re.compile(r"'([^'\n]+)'|\"([^\"\n]+)\"")


def examples() -> dict[str, str]:
    """What examples there are.

    Returns
    -------
    dict
        Name and first sentence of each.
    """
    found = {one.name: one for one in _inputs().iterdir() if one.name.endswith(_SUFFIX)}
    return {
        name.removesuffix(_SUFFIX): _first_sentence(found[name].read_text(encoding="utf-8"))
        for name in sorted(found)
    }


def copy_example(name: str, folder=".") -> list[Path]:
    """Copy an example and the records that it names.

    Parameters
    ----------
    name : str
        Of `examples`.
    folder : path
        Where to; the present one.

    Returns
    -------
    list of Path
        The files, the input first.

    Raises
    ------
    InputError
        If there is no such example.
    OutputError
        If a file of the same name and other content is there; then nothing is written.
    """
    known = examples()
    if name not in known:
        hint = nearest(name, known) or f"; there are {', '.join(known)}"
        raise InputError(f"there is no example {name!r}{hint}")
    contents = _with_named_files(name + _SUFFIX)
    targets = {Path(folder) / path: content for path, content in contents.items()}
    for target, content in targets.items():
        if target.exists() and target.read_bytes() != content:
            raise OutputError(f"{target} exists and is another file; nothing has been copied")
    try:
        for target, content in targets.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
    except OSError as trouble:
        raise OutputError(f"{target} cannot be written: {trouble.strerror}") from trouble
    return list(targets)


def _inputs():
    """The folder of inputs of the installed package."""
    return files(__package__) / "inputs"


def _with_named_files(path: str) -> dict[str, bytes]:
    """Content of an input and of the files of the package that it names, by their paths."""
    content = (_inputs() / path).read_bytes()
    found = {path: content}
    for one, other in _QUOTED.findall(content.decode("utf-8")):
        named = _inputs() / (one or other)
        if named.is_file():
            found[one or other] = named.read_bytes()
    return found


def _first_sentence(text: str) -> str:
    """The first sentence of the comment that an input begins with."""
    comment = re.match(r"(?:!.*\n)*", text)[0]
    words = " ".join(line.lstrip("! ") for line in comment.splitlines())
    return re.split(r"(?<=[a-z)])[.:] ", words)[0].rstrip(".")


def add_example_command(commands) -> None:
    """Add the sub-command to those of the command line."""
    parser = commands.add_parser("example", help="copy an input that runs as it is; list them")
    parser.add_argument("name", nargs="?", metavar="NAME", help="(all are listed)")
    parser.add_argument("folder", nargs="?", type=Path, default=Path(), help="where to (here)")
    parser.set_defaults(act=_example)


def _example(options: argparse.Namespace) -> int:
    if options.name is None:
        for name, words in examples().items():
            print(f"{name:20} {words}")
        return 0
    copied = copy_example(options.name, options.folder)
    print(f"copied: {', '.join(map(str, copied))}")
    print(f"to run it: sitedda run {copied[0]}")
    return 0
