# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: a tree of parts, written as a single offline HTML file or as Markdown."""

from typing import TYPE_CHECKING

from ..base.on_access import import_on_access
from .provenance import provenance

if TYPE_CHECKING:
    from .html import to_html, write_html
    from .markdown import write_markdown
    from .page import Bullets, Facts, Listing, Page, Paragraph, Picture, Section, Table, View

import_on_access(globals())

__all__ = ["Bullets", "Facts", "Listing", "Page", "Paragraph", "Picture", "Section", "Table",
           "View", "provenance", "to_html", "write_html", "write_markdown"]  # fmt: skip
