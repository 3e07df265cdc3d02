# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a page as a single HTML file that works offline.

All texts are escaped for their context.  The content-security policy of the page permits only the
style and script of the page, by their hashes, and embedded pictures.  Network access, forms, frames
and scripts within texts are blocked.
"""

import base64
import hashlib
import json
import re
from collections.abc import Iterable
from html import escape
from importlib.resources import files
from pathlib import Path

from ..base.files import check_target, write
from .page import Bullets, Facts, Listing, Page, Paragraph, Part, Picture, Section, Table, View

_NUMBER = re.compile(
    r"[+−×<≤~-]?\s?\d([\d .]|,(?! ))*(·10\^?[+−-]?\d+|e[+-]?\d+)?\s?[^\s\d]{0,6}", re.I
)
# Modules of the view, in order of their dependencies.
VIEW_MODULES = ("words", "streams", "model", "painters", "marks", "legend", "chart", "save",
                "controls", "view", "page")  # fmt: skip
_MOST_ROWS = 40  # largest number of rows of a table that does not scroll
GOOD = ("ok", "reached")  # words that are coloured in a column of verdicts
BAD = ("fail", "FAILS", "not reached")
WARNED = ("warn",)


def write_html(page: Page, file) -> Path:
    """Write a page as an HTML file."""
    return write(check_target(file, "a page"), to_html(page), "a page")


def to_html(page: Page) -> str:
    """Return a page as HTML."""
    body = _PartWriter()
    sections = "\n".join(body.section(section) for section in page.sections)
    style, script = page_style(), ""
    if body.views:
        style += _read_page_file("view.css", "drawing/view")
        modules = "\n".join(_read_page_file(f"{name}.js", "drawing/view") for name in VIEW_MODULES)
        scripts_text = re.sub(r"^(import [^;]*;\n|export )", "", modules, flags=re.MULTILINE)
        script = f'"use strict";\n(() => {{\n{scripts_text}}})();\n'
    facts = _facts_html(page.provenance)
    return "\n".join(
        [
            "<!doctype html>",
            "<html lang='en'>",
            f"<head>{_page_head(page.title, style, script)}</head>",
            "<body>",
            f"<header><h1>{escape(page.title)}</h1>",
            f"<p class='lead'>{escape(page.lead)}</p></header>" if page.lead else "</header>",
            "<div class='frame'>",
            _contents_list(page.sections),
            f"<main>{sections}",
            f"<footer id='provenance'><h2>Provenance</h2>{facts}</footer>" if facts else "",
            "</main></div>",
            f"<script>{script}</script>" if script else "",
            "</body></html>\n",
        ]
    )


def fragment(*parts: Part) -> str:
    """Return parts as HTML for a notebook, without the style and the script of a page."""
    body = _PartWriter()
    return "\n".join(map(body.part, parts))


def _page_head(title: str, style: str, script: str) -> str:
    """Return the content of the head of a page, with its content-security policy."""
    scripts = f"'sha256-{_content_hash(script)}'" if script else "'none'"
    policy = (
        f"default-src 'none'; style-src 'sha256-{_content_hash(style)}'; script-src {scripts}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    return (
        "<meta charset='utf-8'>"
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        "<meta name='color-scheme' content='light dark'>"
        f"<title>{escape(title)}</title><style>{style}</style>"
    )


def _content_hash(text: str) -> str:
    """Return the hash of a style or script, as in a content-security policy."""
    return base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


def _read_page_file(name: str, folder: str = "report") -> str:
    """Return the text of a style sheet or script of the package."""
    return files("sitedda").joinpath(folder, name).read_text(encoding="utf-8")


def page_style() -> str:
    """Return the style sheet of pages: variables of colours, then rules."""
    from .colors import css_variables

    return css_variables() + _read_page_file("page.css")


def json_for_script(value) -> str:
    """Return a value as JSON for a script element; no text in it can end the element."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def inline(text: str, markup: bool) -> str:
    """Escape a text for HTML; with markup, format `code`, **bold**, *italic* and 10^-3."""
    safe = escape(str(text))
    if not markup:
        return safe
    pieces = re.split(r"(`[^`]+`)", safe)
    return "".join(
        f"<code>{piece[1:-1]}</code>" if piece.startswith("`") else _format_emphasis(piece)
        for piece in pieces
    )


def _format_emphasis(text: str) -> str:
    """Convert **bold**, *italic* and 10^-3 to HTML."""
    text = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", text)
    text = re.sub(r"(?<![\w*])\*([^*\s][^*]*)\*(?![\w*])", r"<em>\1</em>", text)
    return re.sub(r"\^([-−+]?\d+(?:\.\d+)?)", r"<sup>\1</sup>", text)


def _contents_list(sections: list[Section]) -> str:
    """Return the table of contents as HTML; blank for a single section."""
    if len(sections) < 2:
        return ""
    items = "".join(
        f"<li><a href='#{escape(section.anchor)}'>{escape(section.title)}</a></li>"
        for section in sections
    )
    return (
        "<nav aria-label='Contents'><details open><summary>Contents</summary>"
        f"<ol>{items}</ol></details></nav>"
    )


def _facts_html(lines: Iterable[tuple[str, str]]) -> str:
    """Return names and values as a definition list."""
    items = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in lines)
    return f"<dl class='facts'>{items}</dl>" if items else ""


class _PartWriter:
    """Writer of the parts of a page; it numbers the views."""

    def __init__(self):
        self.views = 0

    def section(self, section: Section) -> str:
        title, anchor = escape(section.title), escape(section.anchor)
        parts = "\n".join(map(self.part, section.parts))
        link = f"<a class='anchor' href='#{anchor}' aria-label='link to {title}'>#</a>"
        return f"<section id='{anchor}'><h2>{title} {link}</h2>\n{parts}</section>"

    def part(self, part: Part) -> str:
        match part:
            case Paragraph():
                return f"<p>{inline(part.text, part.markup)}</p>"
            case Facts():
                return _facts_html(part.lines)
            case Table():
                return _table_html(part)
            case Bullets():
                items = "".join(f"<li>{inline(line, part.markup)}</li>" for line in part.lines)
                return f"{_subtitle_html(part.title)}<ul>{items}</ul>"
            case Listing():
                return _listing_html(part)
            case Picture():
                return _picture_html(part)
            case View():
                self.views += 1
                return _view_html(part, f"view{self.views}")
        raise TypeError(f"not a part of a page: {type(part).__name__}")


def _subtitle_html(title: str) -> str:
    """Return the title of a part as a heading; blank without a title."""
    return f"<h3>{escape(title)}</h3>" if title else ""


def _listing_html(part: Listing) -> str:
    """Return a listing as HTML."""
    text = f"<pre>{escape(part.text)}</pre>"
    if part.folded:
        return f"<details><summary>{escape(part.title)}</summary>{text}</details>"
    return _subtitle_html(part.title) + text


def _picture_html(part: Picture) -> str:
    """Return a picture as HTML, embedded in the colours for light and for dark screens."""
    dark, light = (
        f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"
        for kind, data in map(part.encoded, ("dark", "light"))
    )
    caption = escape(part.caption)
    return (
        "<figure class='picture'><picture>"
        f"<source media='screen and (prefers-color-scheme: dark)' srcset='{dark}'>"
        f"<img alt='{caption}' src='{light}'></picture>"
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _table_html(table: Table) -> str:
    """Return a table as HTML; columns of numbers are aligned at the right."""
    numeric = [_are_numeric([row[k] for row in table.rows]) for k in range(len(table.heads))]
    head = "".join(
        f"<th scope='col'{_classes(['n'] if numeric[k] else [])}>{inline(text, table.markup)}</th>"
        if text
        else "<td></td>"
        for k, text in enumerate(table.heads)
    )
    is_verdict = [head in ("", "verdict") for head in table.heads]
    markup = [table.markup] * len(is_verdict)
    body = "".join(
        f"<tr>{''.join(map(_cell_html, row, table.heads, numeric, is_verdict, markup))}</tr>"
        for row in table.rows
    )
    stacked = " class='stacked'" if len(table.heads) > 2 else ""  # used on narrow pages
    scrolls = " long" if len(table.rows) > _MOST_ROWS else ""
    return (
        f"{_subtitle_html(table.title)}<div class='wide{scrolls}' tabindex='0'><table{stacked}>"
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _cell_html(text: str, heading: str, numeric: bool, is_verdict: bool, markup: bool) -> str:
    """Return a cell of a table as HTML; verdicts are coloured if `is_verdict`."""
    names = ["n"] if numeric else []
    text = re.sub(r"(?<![\w.])-(?=\d)|(?<=e)-(?=\d)", "\u2212", text) if numeric else text
    for name, words in (("good", GOOD), ("bad", BAD), ("middle", WARNED)):
        if is_verdict and text in words:
            names.append(name)
    data_attribute = f" data-head='{escape(str(heading))}'" if heading else ""
    return f"<td{_classes(names)}{data_attribute}>{inline(text, markup)}</td>"


def _classes(names: list[str]) -> str:
    """Return the attribute `class` of an element; blank without classes."""
    return f" class='{' '.join(names)}'" if names else ""


def _are_numeric(cells: list[str]) -> bool:
    """Return whether each cell is empty or a number, which may have a short unit."""
    cells = [str(cell).strip() for cell in cells]
    cells = [cell for cell in cells if cell not in ("", "–", "-")]
    return bool(cells) and all(_NUMBER.fullmatch(cell) for cell in cells)


def _view_html(view: View, name: str) -> str:
    """Return the element and the data of an interactive view as HTML."""
    streams = "".join(
        f"<script type='text/plain' id='{name}-{escape(key)}'>{data}</script>"
        for key, data in view.streams.items()
    )
    meta = json_for_script(view.meta)
    return (
        f"<div class='block-view' id='{name}'><noscript>The interactive view needs scripts; the "
        "pictures of this page do not.</noscript></div>"
        f"<script type='application/json' id='{name}-meta'>{meta}</script>{streams}"
    )
