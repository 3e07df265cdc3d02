# SPDX-License-Identifier: GPL-3.0-or-later
"""The fast parts of the reproduction of the paper: required results, and a complete report."""

import base64
import re

import numpy as np
import pytest

from sitedda.errors import InputError
from sitedda.scheme import Scheme
from sitedda_evidence.catalogue import PAPER
from sitedda_evidence.comparison import Comparison, deviation, per_cent, show
from sitedda_evidence.paper.cantilever import kinetic_damping_roots
from sitedda_evidence.paper.discrete import DiscreteModel
from sitedda_evidence.report import terminal_text, write_report
from sitedda_evidence.runs import input_file

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def studies():
    """All studies, without sensitivities that no requirement uses."""
    return {result.case.name: result for result in PAPER.run(short=True)}


@pytest.mark.parametrize("name", list(PAPER.cases))
def test_the_study_meets_its_requirements(studies, name):
    assert studies[name].rows
    assert studies[name].passed, terminal_text(studies[name])


def rows_of(study, *parts) -> list[Comparison]:
    rows = [row for row in study.outcome.comparisons if all(part in row.quantity for part in parts)]
    assert rows, parts
    return rows


def test_layers_follow_the_exact_discrete_theory(studies):
    for row in rows_of(studies["layers"], "mid-layer") + rows_of(studies["layers"], "surface"):
        assert abs(row.from_theory) < 1e-4, row


@pytest.mark.parametrize(
    ("parts", "frequency", "amplitude"),
    [(("table I,", "mid-layer"), 13.948, 29.065), (("table II,", "mid-layer"), 14.238, 28.761)],
)
def test_layers_have_their_known_results(studies, parts, frequency, amplitude):
    values = [row.sitedda for row in rows_of(studies["layers"], *parts)]
    assert values == pytest.approx([frequency, amplitude], rel=1e-4)


def test_surface_amplifies_more_than_the_middle_of_the_top_layer(studies):
    middle = rows_of(studies["layers"], "amplification", "mid-layer")[0].sitedda
    surface = rows_of(studies["layers"], "amplification", "surface")[0].sitedda
    assert surface == pytest.approx(29.156, rel=1e-4)
    assert surface > middle


def test_the_shear_wave_follows_the_exact_discrete_theory(studies):
    for row in rows_of(studies["shear_wave"], "amplitude error"):
        assert abs(row.from_theory) < 1e-3, row
    for row in rows_of(studies["shear_wave"], "one-cycle sine"):
        assert abs(row.from_theory) < 1e-3, row


def test_damping_ratios_follow_the_closed_form(studies):
    ratios = [r for r in rows_of(studies["cantilever"], "damping ratio at") if r.from_theory]
    assert len(ratios) == 6
    assert all(abs(row.from_theory) < 0.01 for row in ratios)


def test_the_column_has_the_theoretical_frequencies(studies):
    for row in rows_of(studies["avdat"], "dominant frequency"):
        assert abs(row.from_theory) < 2e-3, row


def test_only_known_settling_cases_differ_from_the_paper(studies):
    table = next(t for t in studies["avdat"].outcome.tables if t.title.startswith("Table IV"))
    verdicts = [(cells[0], cells[1]) for cells in table.rows if cells[-1] == "no"]
    assert verdicts == [
        ("0.001", "5e+09"), ("0.001", "6e+09"), ("0.001", "1e+10"), ("0.01", "1e+07")
    ]  # fmt: skip
    assert any("verdicts differ" in note for note in studies["avdat"].outcome.notes)


def test_the_report_contains_all_pictures(studies, tmp_path):
    results = list(studies.values())
    count = sum(len(study.outcome.pictures) for study in results)
    text = write_report(PAPER, results, tmp_path).read_text(encoding="utf-8")
    pictures = re.findall(r"src='data:image/svg\+xml;base64,([^']+)'", text)
    assert len(pictures) == count
    assert all(b"<svg" in base64.b64decode(data) for data in pictures)
    assert "src='http" not in text and "<link" not in text
    links = re.findall(r"\]\((\S+)\)", (tmp_path / "paper.md").read_text(encoding="utf-8"))
    assert len(links) == count
    assert all(0 < (tmp_path / link).stat().st_size <= 60_000 for link in links)


def test_an_unknown_study_is_reported():
    with pytest.raises(InputError, match="there is no case colum; the cases are .*cantilever"):
        next(PAPER.run(["colum"]))


def test_the_discrete_model_has_the_masses_and_rigid_motions_of_its_blocks():
    model = DiscreteModel.of(input_file("avdat.nml"))
    assert model.mass_fractions(0).sum() == pytest.approx(1.0)
    assert model.mass[6, 6] == pytest.approx(2250 * 0.6 * 0.39)
    motion = np.zeros(len(model.mass))
    motion[0::6] = 1.0
    free_model = DiscreteModel.of(input_file("avdat.nml"), {"fixed_point[*].direction": "y"})
    assert motion @ free_model.stiffness @ motion < 1e-9 * (motion @ model.stiffness @ motion)


def test_closed_form_of_kinetic_damping():
    roots = kinetic_damping_roots(1.0, 0.1, 1.0)
    engine = Scheme().vibration(1 / (2 * np.pi), 0.1).roots
    assert abs(roots[0]) == pytest.approx((1 + 0.1**2 / 2) ** -0.5)
    assert sorted(roots, key=np.imag) == pytest.approx(sorted(engine, key=np.imag), rel=1e-12)
    assert np.isreal(kinetic_damping_roots(100.0, 1e-5, 0.99)).all()


def test_deviations_and_numbers_are_formatted():
    assert deviation(2.35, (2.3, 2.4)) == 0
    assert deviation(2.2, (2.3, 2.4)) == pytest.approx(-0.1 / 2.3)
    assert deviation("settles", 3.0) is None
    assert per_cent(0.0123) == "1.2 %"
    assert per_cent(-0.0123, sign=True) == "-1.2 %"
    assert show((2.3, 2.4)) == "2.3 – 2.4"
    assert show(1e10) == "1·10^10"
