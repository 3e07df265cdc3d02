# SPDX-License-Identifier: GPL-3.0-or-later
"""Words of pages: short sentences that begin with their subject; valid file names and facts."""

import re
from pathlib import Path

import pytest

from sitedda.base.errors import SiteddaError
from sitedda.commands.command import COMMANDS
from sitedda.schema import GROUPS
from sitedda.site.layers import CONVENTIONS

ROOT = Path(__file__).parents[2]
LATER: set[str] = set()
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
LONGEST = 35  # words of a sentence
CODE = re.compile(
    r"^( *`{3,})[^\n]*\n.*?^\1$|\$\$.*?\$\$|^(?:\||#|!\[|:|<|\(|    )[^\n]*$", re.M | re.S
)
ITEM = re.compile(r"^ *(?:[-*]|\d+\.) ", re.M)
INLINE = re.compile(r"`[^`]*`|\$[^$]+\$")
SHORT = re.compile(r"\b(e\.g|i\.e|et al|Fig|vol|pp|Mech|Min|Sci|Int|J|Numer|Anal)\.")
END = re.compile(r"(?<=[.?!])[*)]*\s+(?=[A-Z0-9α-ω\"`*\[(“&])")
OPENING = re.compile(r"[*\[(\"]*(What|Where|Who|Whatever|Whose)\b")
PATH = re.compile(r"`(?:python )?((?:docs|fortran|inputs|python|tests)/[\w./]+)")
FILE = re.compile(r"`(\w+\.f90)`")
OWN = {"crest.f90", "record_NAME.f90"}  # files of the reader


def sentences(page: str) -> list[str]:
    """Sentences of a page, without code, formulas, tables and headings."""
    text = ITEM.sub("\n\n", CODE.sub("\n", page))
    results = []
    for paragraph in re.split(r"\n\s*\n", text):
        sentence_text = INLINE.sub("Code", " ".join(paragraph.split()))
        sentence_text = SHORT.sub(r"\1", re.sub(r"\]\([^)]*\)", "]", sentence_text))
        results += END.split(sentence_text)
    return results


@pytest.mark.parametrize(
    "page",
    [one for one in PAGES if one.name not in LATER],
    ids=lambda one: str(one.relative_to(ROOT)),
)
def test_sentences_are_short_and_begin_with_their_subject(page):
    page_sentences = sentences(page.read_text())
    wordy = [
        sentence
        for sentence in page_sentences
        if len(re.findall(r"[^\W\d_]{2,}", sentence)) > LONGEST
    ]
    inverted = [
        sentence
        for sentence in page_sentences
        if OPENING.match(sentence) and not sentence.rstrip("*").endswith("?")
    ]
    assert not wordy and not inverted


def test_long_and_turned_sentences_are_found():
    assert OPENING.match("What is left is zero.") and not OPENING.match("Whatsoever")
    assert sentences("# What\n\nA `b.c` is. Two.\n\n- Three\n- `d`\n\n```sh\nx\n```\n") == [
        "", "A Code is.", "Two.", "Three", "Code", "",
    ]  # fmt: skip


def test_files_named_in_pages_exist():
    names = {file.name for top in ("fortran", "python", "tests") for file in
             (ROOT / top).rglob("*.f90")}  # fmt: skip
    for page in PAGES:
        text = page.read_text()
        missing = [path for path in PATH.findall(text) if not (ROOT / path.rstrip(".")).exists()]
        missing += [path for path in FILE.findall(text) if path not in names]
        assert {Path(path).name for path in missing} <= OWN, page.name


def words_of(group: str, variable: str) -> set[str]:
    """Return the permitted words of a variable of the input."""
    variable_found = next(
        candidate for candidate in GROUPS[group].variables if candidate.name == variable
    )
    return set(re.findall(r"'(\w+)'", variable_found.values))


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("docs/joints.md", words_of("joint", "law")),
        ("docs/boundaries.md", words_of("boundary", "kind")),
        ("docs/material_laws.md", words_of("material", "law") - {"linear"}),
        ("docs/method.md", words_of("control", "integration")),
        ("docs/site.md", set(CONVENTIONS)),
    ],
)
def test_each_word_of_the_program_is_in_its_page(page, words):
    page_words = set(re.findall(r"'(\w+)'", (ROOT / page).read_text()))
    assert words and not words - page_words


def test_each_command_is_documented():
    text = "\n".join(page.read_text() for page in PAGES)
    assert not [name for name in COMMANDS if f"sitedda {name}" not in text]


def test_exit_statuses_are_those_of_the_errors():
    kinds = {type(SiteddaError.of(kind, "")).__name__: kind for kind in range(1, 8)}
    statuses = dict(re.findall(r"`(\w+)` (\d)", (ROOT / "docs/howto/python.md").read_text()))
    assert {name: int(status) for name, status in statuses.items()} == kinds
