# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda example`: copy shipped inputs and studies with the files that they name."""

import posixpath
import re
from importlib.resources import files
from pathlib import Path

from ..base.errors import InputError, OutputError
from ..base.files import make_folder, write
from ..input.groups import nearest

_QUOTED = re.compile(r"'([^'\n]+)'|\"([^\"\n]+)\"")


def inputs() -> Path:
    """Return the folder of inputs of the installed package."""
    return Path(str(files("sitedda") / "inputs"))


def examples() -> dict[str, str]:
    """Return the names of the examples and their first sentences.

    Returns
    -------
    dict
        Name and first sentence of each; names of studies begin with ``studies/``.
    """
    lines = {
        name: _first_sentence(_read_shipped(path).decode("utf-8"))
        for name, path in _example_paths().items()
    }
    return {name: lines[name] for name in sorted(lines, key=lambda name: ("/" in name, name))}


def example_files() -> dict[str, tuple[str, Path]]:
    """Return first sentence and file of each example that is an input, by name."""
    return {name: (sentence, inputs() / f"{name}.nml") for name, sentence in examples().items()
            if "/" not in name}  # fmt: skip


def record_files() -> dict[str, Path]:
    """Return the files of the shipped records by name."""
    files = sorted((inputs() / "records").iterdir())
    return {file.name: file for file in files if file.suffix != ".md"}


def copy_example(name: str, folder=".") -> list[Path]:
    """Copy an example and the files that it names, models and records.

    Parameters
    ----------
    name : str
        Of `examples`.
    folder : path
        Target folder; by default the present one.

    Returns
    -------
    list of Path
        The files; the input or study is first.

    Raises
    ------
    OutputError
        If a file of the same name with other content exists; then nothing is written.
    """
    paths = _example_paths()
    if name not in paths:
        hint = nearest(name, paths) or f"; there are {', '.join(paths)}"
        raise InputError(f"there is no example {name!r}{hint}")
    contents = _with_named_files(paths[name])
    targets = {Path(folder) / path: content for path, content in contents.items()}
    for target, content in targets.items():
        if target.exists() and target.read_bytes() != content:
            raise OutputError(f"{target} exists with other content; nothing has been copied")
    for target, content in targets.items():
        make_folder(target.parent)
        write(target, content, "the example")
    return list(targets)


def _example_paths() -> dict[str, str]:
    """Return the paths in the folder of inputs by the names of the examples."""
    files = [*inputs().glob("*.nml"), *inputs().glob("studies/*.toml")]
    paths = [file.relative_to(inputs()).as_posix() for file in files]
    return {posixpath.splitext(path)[0]: path for path in paths}


def _read_shipped(path: str) -> bytes:
    """Read the bytes of a file in the folder of inputs."""
    return (inputs() / path).read_bytes()


def _with_named_files(path: str) -> dict[str, bytes]:
    """Return the contents of an example and of all files that it needs, by relative path."""
    contents = {path: _read_shipped(path)}
    for single_quoted, double_quoted in _QUOTED.findall(contents[path].decode("utf-8", "ignore")):
        target = posixpath.normpath(posixpath.join(posixpath.dirname(path),
                                                   single_quoted or double_quoted))  # fmt: skip
        if posixpath.splitext(target)[1] and (inputs() / target).is_file():
            contents |= (
                _with_named_files(target)
                if target.endswith(".nml")
                else {target: _read_shipped(target)}
            )
    return contents


def _first_sentence(text: str) -> str:
    """Return the first sentence of the comment at the top of a file."""
    comment = re.match(r"(?:[!#].*\n)*", text)[0]
    sentences = " ".join(line.lstrip("!# ") for line in comment.splitlines())
    return re.split(r"(?<=[a-zA-Z)])(?<! al)[.:] ", sentences)[0].rstrip(".")
