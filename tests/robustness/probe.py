# SPDX-License-Identifier: GPL-3.0-or-later
"""The probe of fuzz.py for the installed package: reads requests, writes one answer to each.

``input FILE`` and ``record FILE`` are those of the native probe (tests/fortran/probe.f90);
``outlines FILE`` reads lines and polygons; ``blocks FILE`` runs a model of a block file.
"""

import os
import sys

import numpy as np

import sitedda

STEPS = 5
MOST_BLOCKS = 300  # of models that run some steps; larger ones are only set up


def state(run: sitedda.Simulation) -> list[np.ndarray]:
    """Return all numerical results of a run."""
    energies = np.array(list(run.energies.values()))
    return [
        run.coordinates,
        run.rates,
        run.stresses,
        run.point_motions,
        energies,
        *run.contacts.values(),
    ]


def judge(values) -> str:
    """Return ``ok``, or which of the arrays is not finite."""
    infinite = [i for i, value in enumerate(values) if not np.all(np.isfinite(value))]
    return f"not finite: array {infinite[0]}" if infinite else "ok"


def answer_input(model: str | sitedda.Model) -> str:
    """Set up an input file or a model, and run a few steps."""
    with sitedda.Simulation(model) as run:
        if len(run.coordinates) <= MOST_BLOCKS:
            run.advance(STEPS)
        return judge(state(run))


def answer_record(file: str) -> str:
    """Read and integrate a record."""
    record = sitedda.read_record(file)
    return judge([record[name].values for name in (*record.data_vars, "time")])


def answer_outlines(file: str) -> str:
    """Read all lines and polygons."""
    from sitedda.importing import read_outlines

    return judge([outline.points for outline in read_outlines(file)])


def answer_blocks(file: str) -> str:
    """Set up and run a model of a block file."""
    model = sitedda.Model(time_step=1e-3, steps=STEPS)
    model.material("rock", density=2e3, young_modulus=1e9, poisson_ratio=0.2)
    model.joint("bed", friction_angle=30.0)
    model.blocks(file)
    return answer_input(model)


ANSWERS = {"input": answer_input, "record": answer_record, "outlines": answer_outlines,
           "blocks": answer_blocks}  # fmt: skip


def main() -> None:
    """Answer requests to their end; redirect what the engine itself prints."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", errors="backslashreplace")
    os.dup2(2, 1)
    for request in sys.stdin:
        kind, argument = request.rstrip("\n").split(" ", 1)
        try:
            answer = ANSWERS[kind](argument)
        except sitedda.SiteddaError as error:
            answer = f"refused {error.kind} {error}".replace("\n", " ")
        answers.write(answer + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
