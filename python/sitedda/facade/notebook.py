# SPDX-License-Identifier: GPL-3.0-or-later
"""Representations of models and simulations in a notebook."""

from ..base.errors import SiteddaError
from ..report.html import fragment
from ..report.page import Facts, Part, Picture

_MOST_DRAWN = 3000  # largest number of blocks that are drawn, so that a notebook does not wait


def simulation_fragment(simulation) -> str:
    """Return title, blocks, time and a picture of a simulation as HTML."""
    if not simulation.is_open:
        return fragment(Facts([("simulation", f"of {simulation.file}, closed")]))
    blocks = len(simulation.block_names)
    facts = [
        ("simulation", simulation.title or "Untitled"),
        ("input", str(simulation.file)),
        ("blocks", f"{blocks:,}"),
        ("time", f"{simulation.time:g} of {simulation.duration:g} s, {simulation.steps:,} steps"),
    ]
    if simulation.ending:
        facts.append(("end", simulation.ending))
    return fragment(Facts(facts), *_draw_picture(simulation, blocks))


def model_fragment(model) -> str:
    """Return title, groups and a picture of a model as HTML."""
    from ..engine.simulation import Simulation

    groups = ", ".join(f"{count} {name}" for name, count in model.counts.items()) or "none"
    facts = [("model", model.title or "Untitled"), ("groups", groups)]
    try:
        with Simulation(model) as simulation:
            blocks = len(simulation.block_names)
            facts.append(("blocks", f"{blocks:,}"))
            picture = _draw_picture(simulation, blocks)
    except SiteddaError as error:
        return fragment(Facts([*facts, ("cannot run yet", str(error))]))
    return fragment(Facts(facts), *picture)


def _draw_picture(simulation, blocks: int) -> list[Part]:
    """Return a picture of a simulation; nothing if it has too many blocks."""
    from ..drawing.pictures import draw

    if blocks > _MOST_DRAWN:
        return []
    return [Picture(draw(simulation).figure, simulation.title or "Blocks", "blocks")]
