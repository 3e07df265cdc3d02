# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure and wrap the texts of figures, in the font of matplotlib."""

from functools import lru_cache
from textwrap import wrap

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path


def plain(text: str) -> str:
    """Escape a user's text for matplotlib, which reads $ as a formula and hides labels with _."""
    text = text.replace("$", r"\$")
    return f"\u200b{text}" if text.startswith("_") else text


@lru_cache(maxsize=4096)
def _line_width(text: str, size: float, bold: bool) -> float:
    """Return the width of a line of text, inches."""
    font = FontProperties(size=size, weight="bold" if bold else "normal")
    return text_to_path.get_text_width_height_descent(text, font, False)[0] / 72.0


def folded(text: str, width: float, size: float, bold: bool = False, most_lines: int = 3) -> str:
    """Wrap a text to lines that fit; the last line ends with … if the text is cut.

    `text`: the text; its line breaks are kept.
    `width`: largest width of a line, inches.
    `size`: font size, points.
    `most_lines`: largest number of lines.
    """
    lines: list[str] = []
    for line in text.split("\n"):
        columns = len(line) + 1
        pieces_of_line = [line]
        while columns > 1 and max(_line_width(part, size, bold) for part in pieces_of_line) > width:
            widest = max(_line_width(part, size, bold) for part in pieces_of_line)
            columns = max(1, min(columns - 1, int(columns * max(width / widest, 0.5))))
            pieces_of_line = wrap(line, columns) or [line]
        lines += pieces_of_line
    if len(lines) > most_lines:
        lines = [*lines[: most_lines - 1], lines[most_lines - 1][:-1].rstrip() + "…"]
    return "\n".join(lines)
