# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's layered sites (section 2.3, tables I and II) from the time domain."""

from pathlib import Path

import numpy as np
import pytest
from linear_theory import FIXED_RATIO, Rock, stack
from numpy.testing import assert_allclose

import sitedda
from sitedda.response import amplifications

TIME_STEP = 1e-3
PENALTY = 1.5e12
POISSON = 0.25

ROCKS = {
    "layered_site.nml": [Rock(2643.0, 4.788e9, POISSON)] * 16,
    "layered_site_table2.nml": [
        Rock(2643.0, 4.8e9, POISSON),  # the base block
        *(
            Rock(density, young, POISSON)
            for young, density in (
                (4.8e9, 2643.0),
                (4.0e9, 2483.0),
                (4.2e9, 2243.0),
                (4.1e9, 2162.0),
                (4.5e9, 2403.0),
            )
            for _ in range(3)
        ),
    ],
}
PAPER = {"layered_site.nml": (13.95, 29.1), "layered_site_table2.nml": (14.23, 28.8)}


@pytest.fixture(scope="module", params=sorted(ROCKS))
def site(request):
    """Name of an input, its amplification in the time domain, and its history."""
    file = Path(__file__).parents[2] / "inputs" / request.param
    history = sitedda.run(file).history
    return request.param, amplifications(history)[0], history


def on_base_block(name):
    """The site on its base block, which four moving springs hold."""
    blocks = stack(ROCKS[name], PENALTY, bottom=-1.0)
    force = sum(
        blocks.hold(0, x, y, FIXED_RATIO * PENALTY) for x in (2.5, 12.5) for y in (-0.25, -0.75)
    )
    return blocks, force[:, 0], blocks.motion(15, 7.5, 15.0)[0], blocks.motion(0, 7.5, -0.5)[0]


def on_rigid_base(name):
    """The layers alone, their lowest contacts on a rigid base: surface over base."""
    blocks = stack(ROCKS[name][1:], PENALTY)
    force = np.zeros(blocks.size)
    for x in (0.0, 15.0):
        rows = blocks.motion(0, x, 0.0)
        springs = np.diag([PENALTY / 2.5, PENALTY])
        blocks.stiffness += rows.T @ springs @ rows
        force += rows.T @ springs @ [1.0, 0.0]
    surface = blocks.motion(14, 7.5, 15.0)[0]

    def ratio(frequency):
        z = np.exp(2j * np.pi * frequency * TIME_STEP)
        inertia = 2 * blocks.mass / TIME_STEP**2
        matrix = (inertia + blocks.stiffness) * z - inertia - 2 * inertia * (z - 1) / (z + 1)
        return surface @ np.linalg.solve(matrix, force * z)

    return blocks, ratio


def peak_of(ratio, low, high, rounds=6):
    """Frequency and height of the only maximum of a smooth curve between two frequencies."""
    for _ in range(rounds):
        grid = np.linspace(low, high, 21)
        values = np.array([abs(ratio(f)) for f in grid])
        best = int(np.argmax(values))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, 20)]
    return grid[best], values[best]


def test_peak_is_the_papers(site):
    name, found, _ = site
    frequency, amplitude = PAPER[name]
    print(f"{name}: {found.peak.amplitude:.3f} at {found.peak.frequency:.4f} Hz")
    assert abs(found.peak.frequency - frequency) <= 0.02
    assert abs(found.peak.amplitude - amplitude) <= 0.3


def test_peak_is_that_of_the_exact_discrete_theory_on_a_rigid_base(site):
    name, found, _ = site
    frequency, amplitude = peak_of(on_rigid_base(name)[1], 12.0, 16.0)
    print(f"{name}: theory {amplitude:.3f} at {frequency:.4f} Hz")
    assert abs(found.peak.frequency - frequency) <= 0.01
    assert abs(found.peak.amplitude / amplitude - 1) <= 2e-3


def test_peak_is_that_of_the_exact_discrete_theory_with_the_base_block(site):
    name, found, _ = site
    blocks, *points = on_base_block(name)
    frequency, amplitude = peak_of(lambda f: blocks.transfer(*points, f, TIME_STEP)[0], 12.0, 16.0)
    assert abs(found.peak.frequency - frequency) <= 1e-4
    assert abs(found.peak.amplitude / amplitude - 1) <= 1e-5


def test_the_whole_curve_is_that_of_the_exact_discrete_theory(site):
    name, found, _ = site
    blocks, *points = on_base_block(name)
    some = np.linspace(0, found.frequency.size - 1, 60).astype(int)
    expected = abs(blocks.transfer(*points, found.frequency[some], TIME_STEP))
    assert_allclose(found.ratio[some], expected, rtol=1e-4)


def test_first_mode_is_the_one_of_the_notes(site):
    # undamped eigenfrequencies, which check the theory of this very file
    blocks, _ = on_rigid_base(site[0])
    expected = {"layered_site.nml": 13.961, "layered_site_table2.nml": 14.251}[site[0]]
    assert abs(blocks.modes()[0][0] / (2 * np.pi) - expected) < 6e-4


def test_a_bonded_stack_never_opens_or_slides(site):
    _, _, history = site
    assert int(history.iterations.max()) == 1
    rounding = 1e-12 * float(history.energy_kinetic.max())
    assert float(abs(history.energy_friction).max()) < rounding
    assert float(history.energy_fracture[-1]) == 0.0


def test_the_audit_explains_every_joule(site):
    _, _, history = site
    scale = float(history.energy_kinetic.max())
    assert float(abs(history.energy_balance).max()) < 1e-6 * scale
