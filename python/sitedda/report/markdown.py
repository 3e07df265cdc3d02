# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a page as Markdown with picture files."""

import io
from collections.abc import Iterable
from pathlib import Path

from ..base.files import make_folder, write
from .page import Bullets, Facts, Listing, Page, Paragraph, Part, Picture, Table, View

_COLORS = 64  # number of colours of a picture


def write_markdown(page: Page, file, folder: str = "", dpi: float = 110) -> Path:
    """Write a page as Markdown.

    `folder`: folder of the pictures, relative to that of the file; created if it is
    missing; `dpi`: dots per inch of the pictures.
    """
    file = Path(file)
    pictures = file.parent / folder
    make_folder(pictures)
    texts = [f"# {page.title}", page.lead]
    for section in page.sections:
        texts += [f'<a id="{section.anchor}"></a>', f"## {section.title}"]
        texts += [_part_markdown(part, pictures, folder, dpi) for part in section.parts]
    return write(file, "\n\n".join(text for text in texts if text) + "\n", "Markdown")


def _part_markdown(part: Part, pictures: Path, folder: str, dpi: float) -> str:
    """Return a part of a page as Markdown; write its picture to a file."""
    match part:
        case Paragraph():
            return part.text if part.markup else part.text.replace("<", "&lt;")
        case Facts():
            return "\n".join(f"- {name}: {value}" for name, value in part.lines)
        case Table():
            return _with_title(part.title, markdown_table(part.heads, part.rows))
        case Bullets():
            return _with_title(part.title, "\n".join(f"- {line}" for line in part.lines))
        case Listing():
            return _with_title(part.title, f"```\n{part.text}\n```")
        case Picture():
            _write_picture(part, pictures / f"{part.name}.png", dpi)
            file = (Path(folder) / f"{part.name}.png").as_posix()
            return f"![{part.caption}]({file})\n\n*{part.caption}*"
        case View():
            return ""
    raise TypeError(f"not a part of a page: {type(part).__name__}")


def _write_picture(part: Picture, file: Path, dpi: float) -> None:
    """Write a picture as a small PNG file with a palette of `_COLORS` colours."""
    from PIL import Image

    with Image.open(io.BytesIO(part.png(dpi))) as picture:
        small = io.BytesIO()
        picture.convert("RGB").quantize(_COLORS).save(small, "png", optimize=True)
    write(file, small.getvalue(), "a picture")


def _with_title(title: str, text: str) -> str:
    """Return a Markdown text under a bold title, if there is one."""
    return f"**{title}**\n\n{text}" if title else text


def markdown_table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table of texts."""
    heads = list(heads)
    escaped = (
        [str(cell).replace("|", "\\|").replace("\n", " ") for cell in line]
        for line in [heads, ["---"] * len(heads), *rows]
    )
    return "\n".join("| " + " | ".join(line) + " |" for line in escaped)
