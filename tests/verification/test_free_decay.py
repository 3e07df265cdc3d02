# SPDX-License-Identifier: GPL-3.0-or-later
"""Free decay of the paper's column in its first mode: the damping of the scheme, no other."""

from types import SimpleNamespace

import numpy as np
import pytest
from model_text import BONDED, ROCK, group, namelist

import sitedda
from sitedda_evidence.paper.discrete import DiscreteModel

PENALTY = 1.5e12
PLACES = [(x, y) for x in (2.5, 12.5) for y in (-0.25, -0.75)]
AMPLITUDE = 1e-5  # m at the surface: linear to rounding
CYCLES = 12
TIME_STEPS = [1e-3, 2e-3, 5e-4]


def column(time_step: float, steps: int, **control) -> list:
    """15 layers of table I on a base block that is held still."""
    return [
        ("control", {"time_step": time_step, "steps": steps, **control}),
        group("contact", normal_stiffness=PENALTY),
        ("material", dict(ROCK)),
        ("joint", dict(BONDED)),
        group("layers", name="base", bottom=-1.0, width=15.0, thickness=1.0),
        group("layers", name="layer", width=15.0, thickness=1.0, count=15),
        *(group("fixed_point", x=x, y=y) for x, y in PLACES),
        group("measured_point", name="surface", x=7.5, y=15.0),
    ]


@pytest.fixture(scope="module")
def theory(tmp_path_factory) -> DiscreteModel:
    """The same column in numpy."""
    file = tmp_path_factory.mktemp("theory") / "column.nml"
    file.write_text(namelist(column(1e-3, 1)))
    return DiscreteModel.of(file)


def scheme_decay(omega: float, time_step: float) -> tuple[float, float]:
    """Trace and determinant of the amplification matrix: docs/method.md.

    Damping ratio and frequency follow from them.
    """
    square = (omega * time_step) ** 2
    return (4 - square) / (2 + square), 2 / (2 + square)


@pytest.fixture(scope="module", params=TIME_STEPS, ids=lambda step: f"{step:g} s")
def decay(request, theory, tmp_path_factory):
    """The decay at a time step, sampled at every step, and what the theory says of it."""
    omega, shape = theory.omega, theory.mode(0) / (theory.row("surface") @ theory.mode(0))
    steps = round((CYCLES + 1) * 2 * np.pi / omega[0] / request.param)
    file = tmp_path_factory.mktemp("decay") / "column.nml"
    file.write_text(namelist(column(request.param, steps)))
    samples = [0.0]
    with sitedda.Simulation(file) as simulation:
        simulation.rates = (AMPLITUDE * omega[0] * shape).reshape(16, 6)
        while not simulation.done:
            simulation.advance()
            samples.append(simulation.point_motions[0, 0, 0])
        last = simulation.coordinates[:, 3:].ravel()
    return SimpleNamespace(
        samples=np.array(samples),
        last_strains=last,
        strains_of_shape=shape.reshape(16, 6)[:, 3:].ravel(),
        theory=scheme_decay(omega[0], request.param),
    )


def test_first_mode_is_the_one_of_the_paper(theory):
    # a hair below 13.961 Hz on a rigid base: here the base block and its springs give way
    assert theory.frequencies[0] == pytest.approx(13.961, abs=5e-3)


def test_every_sample_obeys_the_amplification_matrix(decay):
    # Cayley-Hamilton: x[n+1] = trace x[n] - determinant x[n-1]; fitted to the whole decay
    x = decay.samples
    fitted, *_ = np.linalg.lstsq(np.column_stack([x[1:-1], -x[:-2]]), x[2:], rcond=None)
    assert fitted == pytest.approx(decay.theory, rel=1e-6)


def test_the_mode_stays_alone(decay):
    strains, shape = decay.last_strains, decay.strains_of_shape
    factor = strains @ shape / (shape @ shape)
    assert np.linalg.norm(strains - factor * shape) < 1e-3 * np.linalg.norm(strains)


def test_no_damping_is_added_or_taken_by_the_penalty(write_input, theory):
    """Each of the five lowest modes decays as its own frequency says, at one step of 1e-3 s."""
    omega = theory.omega
    file = write_input(column(1e-3, 400))
    for mode in range(5):
        shape = theory.mode(mode) / np.max(np.abs(theory.mode(mode)))
        points = [0.0]
        weight = theory.mass @ shape  # projects on this mode alone
        with sitedda.Simulation(file) as simulation:
            start = simulation.coordinates
            simulation.rates = (1e-6 * omega[mode] * shape).reshape(16, 6)
            for _ in range(200):
                simulation.advance()
                points.append(weight @ (simulation.coordinates - start).ravel())
        x = np.array(points)
        fitted, *_ = np.linalg.lstsq(np.column_stack([x[1:-1], -x[:-2]]), x[2:], rcond=None)
        assert fitted == pytest.approx(scheme_decay(omega[mode], 1e-3), rel=1e-5), mode
