# SPDX-License-Identifier: GPL-3.0-or-later
"""The groups of an input text in their order, read fast: a large model has 10⁵ of them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial

import f90nml

_QUOTED = r"'(?:''|[^'])*'|\"(?:\"\"|[^\"])*\""
_COMMENT = re.compile(rf"({_QUOTED})|![^\n]*")
_GROUP = re.compile(rf"&\s*(\w+)((?:{_QUOTED}|[^'\"/&])*)/")
_TEXT = re.compile(rf"(?<![\w%])(name|material|joint)\s*=\s*({_QUOTED})", re.IGNORECASE)
_EDGES = re.compile(rf"(?<![\w%])edge_joints\s*=\s*((?:(?:{_QUOTED})[\s,]*)+)", re.IGNORECASE)
_COUNT = re.compile(r"(?<![\w%])(count|bricks|courses)\s*=\s*(\d+)", re.IGNORECASE)
_STEMS = {"layers": "layer", "drums": "drum", "wall": "brick"}


def groups(text: str) -> Iterator[tuple[str, str]]:
    """Names (lower case) and bodies of the groups of a namelist text, comments taken out."""
    plain = _COMMENT.sub(lambda found: found.group(1) or "", text)
    for found in _GROUP.finditer(plain):
        yield found.group(1).lower(), found.group(2)


def small_groups(text: str) -> f90nml.Namelist:
    """All groups but those of blocks, parsed; empty where the text is not a namelist."""
    kept = [f"&{name} {body} /" for name, body in groups(text) if not _is_block(name)]
    try:
        return f90nml.Parser().reads("\n".join(kept) + "\n")
    except Exception:  # a parser of foreign text may raise anything; pictures do without
        return f90nml.Namelist()


def listed(parsed: f90nml.Namelist, name: str) -> list[dict]:
    """The groups of a name, none, one or many, as a list."""
    found = parsed.get(name, [])
    return list(found) if isinstance(found, list) else [found]


def block_labels(text: str) -> tuple[list[str], list[str], list[list[str]]]:
    """Names, materials and joints of the blocks that an input makes, in the engine's order.

    The first joint of a block is that of its edges, those after it are of single edges; a blank
    one stands for the first.  A blank material or joint is the first of the input, as the engine
    takes it.
    """
    names, materials, joints = [], [], []
    for group, body in groups(text):
        if not _is_block(group):
            continue
        texts = {key.lower(): _unquoted(value) for key, value in _TEXT.findall(body)}
        made = _names_of(group, body, texts)
        names += made
        materials += [texts.get("material", "")] * len(made)
        edges = _EDGES.search(body) if group == "block" else None
        own = list(map(_unquoted, re.findall(_QUOTED, edges[1]))) if edges else []
        joints += [[texts.get("joint", ""), *own]] * len(made)
    return names, materials, joints


def _is_block(group: str) -> bool:
    return group == "block" or group in _STEMS


def _names_of(group: str, body: str, texts: dict[str, str]) -> list[str]:
    if group == "block":
        return [texts.get("name", "")]
    counts = {key.lower(): int(value) for key, value in _COUNT.findall(body)}
    number = partial(counts.get)
    stem = texts.get("name", _STEMS[group])
    if group == "wall":
        return [f"{stem}_{i + 1}" for i in range(_wall(number("bricks", 1), number("courses", 1)))]
    return [f"{stem}_{i + 1}" for i in range(number("count", 1))]


def _wall(bricks: int, courses: int) -> int:
    """Bricks of a running bond: every second course has one more, of halves at the ends."""
    return courses * bricks + courses // 2


def _unquoted(text: str) -> str:
    quote = text[0]
    return text[1:-1].replace(2 * quote, quote).strip()
