# SPDX-License-Identifier: GPL-3.0-or-later
"""The groups of an input text in their order, read fast: a large model has 10⁵ of them."""

from __future__ import annotations

import re
from collections.abc import Iterator

import f90nml

_QUOTED = r"'(?:''|[^'])*'|\"(?:\"\"|[^\"])*\""
_COMMENT = re.compile(rf"({_QUOTED})|![^\n]*")
_GROUP = re.compile(rf"&\s*(\w+)((?:{_QUOTED}|[^'\"/&])*)/")
_BLOCKS = ("block", "layers", "drums", "wall")


def groups(text: str) -> Iterator[tuple[str, str]]:
    """Names (lower case) and bodies of the groups of a namelist text, comments taken out."""
    plain = _COMMENT.sub(lambda found: found.group(1) or "", text)
    for found in _GROUP.finditer(plain):
        yield found.group(1).lower(), found.group(2)


def small_groups(text: str) -> f90nml.Namelist:
    """All groups but those of blocks, parsed; empty where the text is not a namelist."""
    kept = [f"&{name} {body} /" for name, body in groups(text) if name not in _BLOCKS]
    try:
        return f90nml.Parser().reads("\n".join(kept) + "\n")
    except Exception:  # a parser of foreign text may raise anything; pictures do without
        return f90nml.Namelist()


def listed(parsed: f90nml.Namelist, name: str) -> list[dict]:
    """The groups of a name, none, one or many, as a list."""
    found = parsed.get(name, [])
    return list(found) if isinstance(found, list) else [found]
