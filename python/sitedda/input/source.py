# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of an input, from a file or a `Model`, and the blocks built from it."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ..base.errors import InputError
from ..base.reading import file_path, read_bounded
from .groups import group_text, is_made
from .schema import GROUPS

_ANY = re.compile(
    r"^[^!\n]*&(" + "|".join(filter(is_made, GROUPS)) + r")\b", re.IGNORECASE | re.MULTILINE
)
_LARGEST = 2**30  # largest size of an input in bytes, as in the engine


@dataclass
class Built:
    """Blocks built from groups.

    `blocks`: variables of &block groups: name, material, joint, vertices, edge_joints; blank
    variables are omitted.
    `groups`: names and variables of other generated groups.
    `messages`: notes on removed, merged and remaining blocks.
    `meshed`: positions, among all groups, of the &block groups that the cells of bodies replace.
    """

    blocks: list[dict] = field(default_factory=list)
    groups: list[tuple[str, dict]] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    slivers: list[str] = field(default_factory=list)  # descriptions of blocks that are slivers
    meshed: list[int] = field(default_factory=list)


def blocks_text(blocks: Sequence[dict]) -> str:
    """Return the blocks as &block groups, one per line."""
    return "".join(group_text("block", block) for block in blocks)


def read_input(file: Path) -> str:
    """Read the text of an input file; messages equal those of the native executable."""
    data = read_bounded(file, _LARGEST)
    if b"\0" in data:
        raise InputError(f"{file} is not a text file: byte {data.index(0) + 1} is zero")
    return data.decode("utf-8", "surrogateescape")


@contextmanager
def opened_input(source) -> Iterator[tuple[Path, str]]:
    """Yield file name and text of an input, which is a namelist file or a `Model`."""
    if hasattr(source, "opened"):
        with source.opened() as opened:
            yield opened
    else:
        file = file_path(source)
        yield file, read_input(file)


@dataclass(frozen=True)
class InputOfRun:
    """An input with the changes under which it was run; see `opened_input`.

    `put`: converts the built blocks into text, see `built_text`.
    """

    file: Path
    text: str
    put: Callable[[Sequence[dict]], str] = blocks_text

    @contextmanager
    def opened(self) -> Iterator[tuple[Path, str]]:
        """Yield file name and text."""
        yield self.file, self.text


def needs_building(text: str) -> bool:
    """Return whether a text may contain groups to be converted into blocks, by a quick test."""
    return _ANY.search(text) is not None
