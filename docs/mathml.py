# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas as MathML, which browsers render without a network or a script."""

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.util.docutils import SphinxTranslator


def setup(app) -> dict:
    """Register the renderer `mathml` of the HTML pages."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def inline(translator: SphinxTranslator, node: nodes.math) -> None:
    """Write a formula within a line."""
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def display(translator: SphinxTranslator, node: nodes.math_block) -> None:
    """Write a formula on lines of its own, with its number."""
    text = node.astext().replace("{aligned}", "{align*}")  # the converter knows the latter
    translator.body.append(f'<div class="formula" id="{"".join(node.get("ids", []))}">')
    translator.body.append(convert(text, display="block"))
    if node.get("number"):
        translator.body.append(f'<span class="eqno">({node["number"]})</span>')
    translator.body.append("</div>\n")
    raise nodes.SkipNode
