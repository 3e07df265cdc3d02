# SPDX-License-Identifier: GPL-3.0-or-later
"""The report, the command, and reference solutions of the validation cases."""

import re
from html import escape

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sitedda.command import main
from sitedda.errors import InputError
from sitedda_evidence.case import VALIDATION
from sitedda_evidence.catalogue import run_case
from sitedda_evidence.report import number, write_report
from sitedda_evidence.validation.packing import overlap
from sitedda_evidence.validation.rocking import (
    RATE,
    RATIO,
    SLENDER,
    housner,
    housner_duration,
    pulse_duration,
)
from sitedda_evidence.validation.sliding import read_smc, record_file, rigid_slide
from sitedda_evidence.validation.stability import toe_force


def test_the_report_contains_rows_and_picture(tmp_path):
    result = run_case("damping", short=True)
    text = write_report(VALIDATION, [result], tmp_path / "out").read_text(encoding="utf-8")
    text = re.sub(r" data-head='[^']*'", "", text).replace("\N{MINUS SIGN}", "-")
    for row in result.rows:
        cells = [f"<td class='n'>{number(value)}</td>" for value in (row.expected, row.computed)]
        assert f"<td>{escape(row.quantity)}</td>{''.join(cells)}" in text
    assert "<td class='good'>ok</td>" in text and "href='#damping'" in text
    assert "src='data:image/svg+xml;base64," in text


def test_the_command_runs_a_case(capsys):
    assert main(["validate", "damping", "--short"]) == 0
    assert "1 of 1 cases pass" in capsys.readouterr().out
    assert main(["validate", "--list"]) == 0
    assert "Newmark" in capsys.readouterr().out
    assert main(["validate", "nonsense"]) == 1
    assert "there is no case nonsense" in capsys.readouterr().err


def test_an_unknown_case_is_reported():
    with pytest.raises(InputError, match="no case"):
        run_case("nonsense")


def test_rows_of_a_wall_that_never_rests_fail(monkeypatch):
    for module in ("masonry_limits", "slopes"):
        monkeypatch.setattr(f"sitedda_evidence.validation.{module}.rest_of", lambda *_: None)
    result = run_case("tilting_wall", short=True)
    assert not result.passed and len(result.rows) == 3


@pytest.mark.parametrize(
    ("width", "height", "ratio"), [(0.05, 2.0, 2.0), (0.3, 2.0, 1.2), (0.5, 2.0, 3.0), (1, 1.5, 2)]
)
def test_the_least_pulse_solves_the_rocking_equation(width, height, ratio):
    """θ'' = −p² [sin(α − θ) − (a/g) cos(α − θ)] integrated by scipy, with bisected duration."""
    slender, rate = np.arctan2(width, height), np.sqrt(1.5 * 9.81 / np.hypot(width, height))
    ratio_of_gravity = ratio * np.tan(slender)

    def falls(duration):
        def rates(time, state, acceleration):
            angle = slender - state[0]
            return [state[1], -(rate**2) * (np.sin(angle) - acceleration * np.cos(angle))]

        def overturns(_, state, acceleration):
            return state[0] - 1.5 * slender

        def returns_upright(_, state, acceleration):
            return state[1]

        overturns.terminal = returns_upright.terminal = True
        exact = {"rtol": 1e-10, "atol": 1e-13}
        end_of_pulse = solve_ivp(rates, (0, duration), [0.0, 0.0], args=(ratio_of_gravity,),
                                 **exact).y[:, -1]  # fmt: skip
        if end_of_pulse[0] > slender:
            return True
        free_rocking = solve_ivp(rates, (0, 20 / rate), end_of_pulse, args=(0.0,),
                                 events=(overturns, returns_upright), **exact)  # fmt: skip
        return len(free_rocking.t_events[0]) > 0

    low, high = 0.01 / rate, 5 / rate
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if falls(middle) else (middle, high)
    duration = pulse_duration(width, height, 9.81 * ratio_of_gravity)
    assert duration == pytest.approx(0.5 * (low + high), rel=1e-5)
    if slender <= 0.15:
        assert housner_duration(width, height, 9.81 * ratio_of_gravity) == pytest.approx(
            duration, rel=3e-3
        )


def test_rigid_slide_under_constant_acceleration():
    time = np.linspace(0, 1, 101)
    slip, velocity = rigid_slide(time, np.full(101, -3.0), 0.0, 10.0)
    rate = 3.0 - 9.81 * np.tan(np.radians(10.0))
    assert slip[-1] == pytest.approx(0.5 * rate) and velocity[-1] == pytest.approx(rate)


def test_rigid_slide_stops_inside_an_interval():
    base = np.where(np.linspace(0, 2, 201) < 0.495, -4.0, 0.0)
    slip, velocity = rigid_slide(np.linspace(0, 2, 201), base, 0.0, 10.0)
    assert velocity[-1] == 0.0 and slip[-1] > 0.0 and np.ptp(slip[150:]) == 0.0


def test_the_validation_reads_the_record():
    time, acceleration = read_smc(record_file())
    assert len(time) == 7183 and time[1] == pytest.approx(0.005)
    assert np.abs(acceleration).max() == pytest.approx(2.225, abs=1e-3)


def test_housner_amplitudes_decrease_with_each_impact():
    time, angle, impacts = housner(3.0, 0.5 * SLENDER)
    after = np.abs(angle[(time > impacts[0]) & (time < impacts[1])]).max()
    before, left = (np.cos(SLENDER - a) - np.cos(SLENDER) for a in (0.5 * SLENDER, after))
    assert np.sqrt(left / before) == pytest.approx(RATIO, rel=1e-5)
    quarter = np.arccosh(1 / (1 - 0.5)) / RATE  # Housner's linear formula
    assert impacts[0] == pytest.approx(quarter, rel=2e-2)


def test_goodman_and_bray_stability_at_the_published_friction():
    angle = np.degrees(np.arctan(0.7855))
    assert toe_force(angle + 0.05) <= 0.0 < toe_force(angle - 0.05)


def test_overlap_of_squares():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    assert overlap(square, square + [0.9, 0.3]) == pytest.approx(0.1)
    assert overlap(square, square + [1.2, 0.3]) < 0
