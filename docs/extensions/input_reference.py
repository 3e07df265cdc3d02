# SPDX-License-Identifier: GPL-3.0-or-later
"""The directive `input-reference`: all groups and variables, as the engine publishes them."""

from __future__ import annotations

import re
from itertools import groupby

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from sitedda.engine import InputVariable, engine_names, input_catalogue

HEADINGS = ("variable", "kind, unit", "default", "range", "meaning")
WIDTHS = (18, 12, 16, 18, 40)
_EXPONENT = re.compile(r"[-+]?\d\.\d+E[-+]\d+")  # as Fortran writes it


def rows() -> dict[str, list[InputVariable]]:
    """The variables of each group, in the order in which the engine publishes them."""
    return {name: list(found) for name, found in groupby(input_catalogue(), lambda v: v.group)}


class InputReference(SphinxDirective):
    """A section with a table for each group."""

    def run(self) -> list[nodes.Node]:
        """Make the sections."""
        single = engine_names("single groups")
        return [_section(name, name in single, found) for name, found in rows().items()]


def _section(name: str, single: bool, variables: list[InputVariable]) -> nodes.section:
    section = nodes.section(ids=[f"group-{name.replace('_', '-')}"], names=[name])
    section += nodes.title("", "", nodes.literal("", f"&{name}"))
    section += nodes.paragraph("", "At most once." if single else "As often as needed.")
    section += _table(variables)
    return section


def _table(variables: list[InputVariable]) -> nodes.table:
    group = nodes.tgroup(cols=len(HEADINGS))
    group.extend(nodes.colspec(colwidth=width) for width in WIDTHS)
    head, body = nodes.thead(), nodes.tbody()
    head += _row([nodes.Text(word) for word in HEADINGS])
    for one in variables:
        kind = ", ".join(filter(None, (one.kind, one.unit)))
        allowed = _EXPONENT.sub(lambda found: f"{float(found[0]):g}", one.range)
        cells = [kind, one.default, allowed, one.meaning]
        body += _row([nodes.literal("", one.name), *map(nodes.Text, cells)])
    group += [head, body]
    return nodes.table("", group)


def _row(cells: list[nodes.Node]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", cell)) for cell in cells))


def setup(app) -> dict:
    """Add the directive."""
    app.add_directive("input-reference", InputReference)
    return {"parallel_read_safe": True}
