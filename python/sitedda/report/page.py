# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a report: sections of paragraphs, facts, tables, pictures, listings and views."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_SVG = 600_000  # largest size of an SVG picture, bytes; larger pictures are PNG
_DPI = 140


@dataclass(frozen=True)
class Paragraph:
    """A plain text; `markup` permits `code`, **bold**, *italic* and 10^-3 in it."""

    text: str
    markup: bool = False


@dataclass(frozen=True)
class Facts:
    """A list of short values with their names; markup is not interpreted."""

    lines: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Table:
    """A table of texts; verdicts are coloured in columns with the head "verdict" or ""."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    markup: bool = False  # see `Paragraph`


@dataclass(frozen=True)
class Bullets:
    """A list of texts under a heading."""

    lines: Sequence[str]
    title: str = ""
    markup: bool = False


@dataclass(frozen=True)
class Listing:
    """A text of fixed width, such as an input; only its title is visible if `folded`."""

    text: str
    title: str = ""
    folded: bool = False


@dataclass(frozen=True)
class Picture:
    """A drawing with its caption."""

    figure: Figure
    caption: str
    name: str = "picture"  # file name without ending, if pictures are written to files

    def encoded(self, scheme: str = "light") -> tuple[str, bytes]:
        """Return media type and bytes of the picture in a colour scheme: SVG if small, else PNG."""
        import matplotlib

        from .style import dressed

        settings = {"svg.hashsalt": "sitedda", "svg.fonttype": "path"}
        stream = io.BytesIO()
        with matplotlib.rc_context(settings), dressed(self.figure, scheme):
            self.figure.savefig(stream, format="svg", metadata={"Date": None})
        if stream.tell() <= _MOST_SVG:
            return "image/svg+xml", stream.getvalue()
        return "image/png", self.png(scheme=scheme)

    def png(self, dpi: float = _DPI, scheme: str = "light") -> bytes:
        """Return the picture as PNG."""
        from .style import dressed

        stream = io.BytesIO()
        with dressed(self.figure, scheme):
            self.figure.savefig(stream, format="png", dpi=dpi)
        return stream.getvalue()


@dataclass(frozen=True)
class View:
    """The interactive view of a scene."""

    meta: dict  # plain values for the script of the view
    streams: dict[str, str]  # data arrays as base64 texts


Part = Paragraph | Facts | Table | Bullets | Listing | Picture | View


@dataclass
class Section:
    """A heading with its content."""

    title: str
    parts: list[Part] = field(default_factory=list)
    anchor: str = ""  # name of the link to the section; derived from the title if empty

    def __post_init__(self):
        if not self.anchor:
            self.anchor = re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-") or "section"


@dataclass
class Page:
    """A report."""

    title: str
    lead: str = ""  # a few sentences under the title
    sections: list[Section] = field(default_factory=list)
    provenance: Sequence[tuple[str, str]] = ()  # version, date, command …, at the end of the page

    def add(self, title: str, *parts: Part, anchor: str = "") -> Section:
        """Append a section."""
        section = Section(title, [part for part in parts if part is not None], anchor)
        self.sections.append(section)
        return section
