# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of an input, wherever it comes from, and the blocks that are made from it."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ..base.errors import InputError
from ..base.reading import read_bounded
from .groups import group_text, is_made
from .schema import GROUPS

_ANY = re.compile(
    r"^[^!\n]*&(" + "|".join(filter(is_made, GROUPS)) + r")\b",
    re.IGNORECASE | re.MULTILINE,
)
_LARGEST = 2**30  # bytes of an input, as in the engine


@dataclass
class Built:
    """Blocks made from groups.

    Attributes
    ----------
    blocks : list of dict
        Variables of &block groups: name, material, joint, vertices, edge_joints; blank ones left
        out.
    groups : list of (str, dict)
        Other groups that were made: names and variables.
    messages : list of str
        What was removed, merged or left.
    slivers : list of str
        Blocks that are slivers.
    meshed : list of int
        Groups &block, by their place among all groups, that the cells of bodies replace.
    """

    blocks: list[dict] = field(default_factory=list)
    groups: list[tuple[str, dict]] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    slivers: list[str] = field(default_factory=list)
    meshed: list[int] = field(default_factory=list)


def blocks_text(blocks: Sequence[dict]) -> str:
    """The blocks as &block groups, one a line."""
    return "".join(group_text("block", block) for block in blocks)


def read_input(file: Path) -> str:
    """The text of an input file; errors in the words of the native executable."""
    data = read_bounded(file, _LARGEST)
    if b"\0" in data:
        raise InputError(f"{file} is not a text file: byte {data.index(0) + 1} is zero")
    return data.decode("utf-8", "surrogateescape")


@contextmanager
def opened_input(source) -> Iterator[tuple[Path, str]]:
    """The file name and the text of an input: a namelist file, or a `Model`."""
    if hasattr(source, "opened"):
        with source.opened() as opened:
            yield opened
    else:
        yield Path(source), read_input(Path(source))


@dataclass(frozen=True)
class InputOfRun:
    """An input as it was run, with the changes that were made: see `opened_input`.

    Attributes
    ----------
    file : Path
    text : str
    put : callable
        Turns the blocks that are made into text, see `built_text`.
    """

    file: Path
    text: str
    put: Callable[[Sequence[dict]], str] = blocks_text

    @contextmanager
    def opened(self) -> Iterator[tuple[Path, str]]:
        """File name and text."""
        yield self.file, self.text


def needs_building(text: str) -> bool:
    """Whether a text may have groups that are to be turned into blocks; quick."""
    return _ANY.search(text) is not None
