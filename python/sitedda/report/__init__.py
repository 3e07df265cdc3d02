# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: a tree of parts, written as a single offline HTML file or as Markdown."""

from .html import to_html, write_html
from .markdown import write_markdown
from .page import Bullets, Facts, Listing, Page, Paragraph, Picture, Section, Table, View
from .provenance import provenance

__all__ = [
    "Bullets",
    "Facts",
    "Listing",
    "Page",
    "Paragraph",
    "Picture",
    "Section",
    "Table",
    "View",
    "provenance",
    "to_html",
    "write_html",
    "write_markdown",
]
