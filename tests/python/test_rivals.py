# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparison with other programs: inputs, outputs and errors, without these programs."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import numpy as np
import pytest
import rivals
import speed_report
import wall_ntdda
from speed_models import DENSITY, GRAVITY, YOUNG_MODULUS, touching_wall

MODEL = touching_wall(20)


def test_lines_for_ntdda_cut_the_wall_into_its_edges():
    lines = wall_ntdda.lines(MODEL)
    for polygon in MODEL.polygons:
        for (x1, y1), (x2, y2) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            assert any(
                min(a, c) <= min(x1, x2) and max(x1, x2) <= max(a, c)
                and min(b, d) <= min(y1, y2) and max(y1, y2) <= max(b, d)
                for a, b, c, d in lines if (a == c == x1) or (b == d == y1)
            )  # fmt: skip
    assert wall_ntdda.geometry(MODEL).count("<Joint ") == len(lines)


def test_analysis_for_ntdda_has_the_steps_and_the_penalty():
    text = wall_ntdda.analysis(60, 0.005)
    assert 'timesteps="60"' in text and 'maxtimestep="0.005"' in text and 'pfactor="50.0"' in text


@pytest.mark.parametrize("reaction, force", [("reaction 12.5\n", 12.5), ("", np.nan)])
def test_output_of_a_driver_is_read(reaction, force):
    output = f"noise\ntime 0.25\n{reaction}0 0 1 0 1 1 0 1\n1 0 2 0 2 1 1 1\n"
    time, read_force, vertices = rivals.parsed(output)
    assert time == 0.25 and vertices.shape == (2, 4, 2) and vertices[1, 2, 0] == 2
    np.testing.assert_equal(read_force, force)


def test_blocks_are_brought_into_the_order_of_the_model():
    polygons = np.array(MODEL.polygons)
    shuffled = np.roll(polygons[::-1], 1, axis=1) + 1e-5
    np.testing.assert_allclose(rivals.in_order(MODEL, shuffled), polygons, atol=2e-5)


def test_errors_of_closed_forms():
    polygons = np.array(MODEL.polygons)
    bricks = len(polygons) - 1
    courses = round(2 * MODEL.top)
    base = sum(polygon[0, 1] == 0 for polygon in polygons[1:])
    weight = DENSITY * GRAVITY * MODEL.top * polygons[1:, 1, 0].max()
    closed_form = DENSITY * GRAVITY * MODEL.top**2 / (2 * YOUNG_MODULUS)
    assert bricks >= courses * base
    sunk = polygons.copy()
    sunk[1:, :, 1] -= weight / (2 * base * rivals.FACTOR * YOUNG_MODULUS)
    result = rivals.Result(1.0, sunk, rivals.base_force(MODEL, sunk))
    settlement, asymmetry, reaction = rivals.errors(MODEL, result)
    assert reaction == pytest.approx(0.0, abs=1e-6) and asymmetry == 0.0
    assert settlement == pytest.approx((polygons - sunk).max() / closed_form)
    shifted = rivals.Result(1.0, polygons + [3 * closed_form, 0], 0.5 * weight)
    assert rivals.errors(MODEL, shifted)[1:] == pytest.approx((6.0, -0.5))


def test_a_program_that_fails_leaves_no_result():
    def fail():
        raise ValueError

    good = rivals.Result(0.002, np.array(MODEL.polygons), 1.0)
    results = rivals.compared(lambda: good, fail, 2)
    assert results == ([good, good], [])
    assert rivals.cells(MODEL, results, 2) == ["1", "fails", "–", "–", "–", "–"]
    both = rivals.cells(MODEL, ([good], [good]), 2)
    assert both[:3] == ["1 (1–1)", "1 (1–1)", "1"]


def test_the_section_survives_a_new_page(tmp_path):
    page = tmp_path / "benchmarks.md"
    page.write_text(speed_report.text("machine", []))
    for row in ("|first|", "|second|"):
        speed_report.write_rivals(page, {"ntdda": [row]})
    section = speed_report.others_of(page.read_text())
    assert section.endswith("|second|") and "|first|" not in section
    assert section in speed_report.text("other machine", [], section)
    assert page.read_text().count("## Design choices") == 1
