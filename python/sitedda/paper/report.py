"""One report of all studies: self-contained HTML, and Markdown with pictures beside it."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path

from .. import __version__
from .rows import Row, Study, Table, per_cent, show

__all__ = ["write_html", "write_markdown", "write_pictures"]

_TITLE = "The paper's results, reproduced"
_LEAD = (
    "Every table and figure of “Site response analysis with two-dimensional numerical discontinuous"
    " deformation analysis method” (2013) that holds a result, run anew with sitedda. Paper values"
    " and formulas of the theory are data with their place in the paper; everything else is"
    " computed by the run that wrote this report."
)
_HEADS = ["quantity", "place", "paper", "theory", "sitedda", "to paper", "to theory",
          "what explains it"]  # fmt: skip
_CSS = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1120px; margin: 2rem auto; padding: 0 1rem;
  color: #222; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 3rem; border-top: 2px solid #1f5fa8;
  padding-top: .6rem; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 13px; }
th { text-align: left; border-bottom: 2px solid #444; padding: .25rem .6rem; vertical-align: bottom;
  position: sticky; top: 0; background: #fff; }
td { border-bottom: 1px solid #ddd; padding: .25rem .6rem; vertical-align: top; }
td.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
td.yes { color: #2c7a46; font-weight: 600; } td.no { color: #b3261e; font-weight: 600; }
figure { margin: 1.5rem 0; } figcaption { color: #555; font-size: 13px; }
img { max-width: 100%; } .wide { overflow-x: auto; } footer { color: #777; margin-top: 3rem; }
"""


def write_pictures(studies: list[Study], folder: Path) -> dict[str, Path]:
    """Draw all pictures into a folder; their files by name."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {}
    for study in studies:
        for picture in study.pictures:
            files[picture.name] = folder / f"{picture.name}.png"
            picture.draw(files[picture.name])
    return files


def _cells(row: Row) -> list[str]:
    return [
        row.quantity,
        row.place,
        show(row.paper, row.digits),
        show(row.theory, row.digits),
        show(row.sitedda, row.digits),
        per_cent(row.from_paper, sign=True),
        per_cent(row.from_theory, sign=True),
        row.why,
    ]


def _requirement_cells(studies: list[Study]) -> list[list[str]]:
    return [
        ["reached" if asked.reached else "not reached", asked.text, asked.measured]
        for study in studies
        for asked in study.requirements
    ]


# ---------------------------------------------------------------------------------------------
# HTML
# ---------------------------------------------------------------------------------------------


def write_html(studies: list[Study], pictures: dict[str, Path], file: Path, seconds: float) -> None:
    """Write the report as one HTML file with its pictures inside.

    Parameters
    ----------
    studies : list of Study
    pictures : dict
        Picture files by name, see `write_pictures`.
    file : Path
    seconds : float
        How long the runs took, s.
    """
    parts = [
        f"<h1>{_TITLE}</h1><p>{escape(_LEAD)}</p><h3>What it must reach</h3>",
        _html_table(["", "requirement", "measured"], _requirement_cells(studies)),
    ]
    parts += [_html_study(study, pictures) for study in studies]
    parts.append(f"<footer>sitedda {__version__}, computed in {seconds:.0f} s</footer>")
    head = f"<meta charset='utf-8'><title>{_TITLE}</title><style>{_CSS}</style>"
    body = "\n".join(parts)
    page = f"<!doctype html><html lang='en'><head>{head}</head><body>{body}</body></html>\n"
    file.write_text(page, encoding="utf-8")


def _html_study(study: Study, pictures: dict[str, Path]) -> str:
    parts = [f"<h2 id='{study.name}'>{escape(study.title)}</h2>"]
    parts += [f"<p>{escape(text)}</p>" for text in study.text]
    parts += [_html_picture(pictures[p.name], p.caption) for p in study.pictures]
    parts.append(_html_table(_HEADS, [_cells(row) for row in study.rows]))
    parts += [
        f"<h4>{escape(table.title)}</h4>{_html_table(table.heads, table.cells)}"
        for table in study.tables
    ]
    if study.notes:
        notes = "".join(f"<li>{escape(note)}</li>" for note in study.notes)
        parts.append(f"<h4>What differs, and why</h4><ul>{notes}</ul>")
    return "\n".join(parts)


def _html_picture(file: Path, caption: str) -> str:
    data = base64.b64encode(file.read_bytes()).decode()
    words = escape(caption)
    return (
        f"<figure><img alt='{words}' src='data:image/png;base64,{data}'>"
        f"<figcaption>{words}</figcaption></figure>"
    )


def _html_table(heads: list[str], rows: list[list[str]]) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = "".join(
        "<tr>" + "".join(f"<td{_class(text)}>{escape(text)}</td>" for text in row) + "</tr>"
        for row in rows
    )
    return (
        f"<div class='wide'><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody>"
        "</table></div>"
    )


def _class(text: str) -> str:
    if text in ("reached", "yes"):
        return " class='yes'"
    if text in ("not reached", "no"):
        return " class='no'"
    number = len(text) < 16 and (text[:1].isdigit() or text[:1] in "+-–×")
    return " class='n'" if number else ""


# ---------------------------------------------------------------------------------------------
# Markdown
# ---------------------------------------------------------------------------------------------


def write_markdown(studies: list[Study], pictures: dict[str, Path], file: Path) -> None:
    """Write the report as Markdown; the pictures stay where they are."""
    parts = [
        f"# {_TITLE}",
        _LEAD,
        "Written by `python -m sitedda.paper`; do not edit by hand.",
        "## What it must reach",
        _markdown_table(["", "requirement", "measured"], _requirement_cells(studies)),
    ]
    for study in studies:
        parts += _markdown_study(study, pictures, file.parent)
    file.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _markdown_study(study: Study, pictures: dict[str, Path], folder: Path) -> list[str]:
    parts = [f"## {study.title}", *study.text]
    for picture in study.pictures:
        place = pictures[picture.name].relative_to(folder).as_posix()
        parts.append(f"![{picture.caption}]({place})\n\n*{picture.caption}*")
    parts.append(_markdown_table(_HEADS, [_cells(row) for row in study.rows]))
    parts += [_titled(table) for table in study.tables]
    if study.notes:
        parts += ["**What differs, and why**", "\n".join(f"- {note}" for note in study.notes)]
    return parts


def _titled(table: Table) -> str:
    return f"**{table.title}**\n\n{_markdown_table(table.heads, table.cells)}"


def _markdown_table(heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(text.replace("|", "\\|").replace("\n", " ") for text in line) + " |"
        for line in lines
    )
