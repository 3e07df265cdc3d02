# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of studies: fragility, dynamic analysis, sensitivity, maps, bands, report."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import study_functions
import xarray as xr

import sitedda
from sitedda.errors import InputError
from sitedda.study import (
    Record,
    Records,
    bands,
    eurocode8,
    fragility,
    fragility_of,
    ida,
    one_at_a_time,
    parameter_map,
    saltelli,
    sobol_indices,
    synthetic,
    tornado,
    uniform,
    write_report,
)

LEVELS = [0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0]
COLLAPSES = [0, 0, 0, 4, 6, 13, 12, 16]


def test_fragility_of_published_data():
    curve = fragility(LEVELS, COLLAPSES, [40] * 8)
    assert curve.median == pytest.approx(1.07612, abs=1e-4)
    assert curve.dispersion == pytest.approx(0.429237, abs=1e-4)
    low, high = curve.median_interval
    assert low < curve.median < high
    assert curve.probability(curve.median) == pytest.approx(0.5)
    below, above = curve.band([0.5, 1.0])
    assert np.all(below < curve.probability([0.5, 1.0])) and np.all(above < 1)


def test_the_intervals_of_a_fragility_have_their_confidence():
    """Coverage with random data: about 95 % of the 95 % intervals contain the true value."""
    rng = np.random.default_rng(4)
    x, coverage = np.linspace(0.3, 2.4, 8), np.zeros(2)
    from scipy.special import ndtr

    for _ in range(60):
        failed = rng.binomial(40, ndtr(np.log(x / 1.0) / 0.5))
        curve = fragility(x, failed, [40] * 8)
        coverage += [a < truth < b for (a, b), truth in
                 ((curve.median_interval, 1.0), (curve.dispersion_interval, 0.5))]  # fmt: skip
    assert np.all((coverage >= 51) & (coverage <= 60))


@pytest.mark.parametrize(
    ("failures", "message"),
    [
        ([0] * 8, "no case failed"),
        ([40] * 8, "all cases failed"),
        ([0, 0, 0, 0, 40, 40, 40, 40], "not determined"),
        ([30, 20, 20, 10, 8, 5, 3, 1], "does not increase"),
        ([1, 2, 3], "one value for each level"),
        ([0, 0, 0, 1, 2, 3, 50, 60], "from 0 to the number"),
    ],
)
def test_data_without_a_fragility_are_refused(failures, message):
    with pytest.raises(InputError, match=message):
        fragility(LEVELS, failures, [40] * 8)


@pytest.mark.parametrize("empty", [0, 1])
def test_few_trials_hardly_affect_a_fragility(empty):
    """Two levels determine a probit line; a third with no trial or one changes little."""
    from scipy.special import ndtri

    curve = fragility([1.0, 2.0, 3.0], [10, 50, 0], [100, 100, empty])
    z = ndtri([0.1, 0.5])
    dispersion = np.log(2.0) / (z[1] - z[0])
    assert curve.median == pytest.approx(2.0, rel=0.03 if empty else 1e-5)
    assert curve.dispersion == pytest.approx(dispersion, rel=0.06 if empty else 1e-5)
    falling = [10, 9, 100], [100, 10, 1000]  # 10, 90 and 10 %
    with pytest.raises(InputError, match="does not increase"):
        fragility([1.0, 2.0, 3.0], *falling)


@pytest.fixture
def table() -> xr.Dataset:
    """Return responses of five records at four levels; one run failed."""
    level = np.array([1.0, 2.0, 3.0, 4.0])
    response = np.outer([0.4, 0.7, 1.0, 1.5, 2.5], level**2)
    response[4, 3] = np.nan
    status = np.where(np.isnan(response), "failed", "complete").astype(object)
    return xr.Dataset(
        {
            "tilt": (("record", "pga"), response),
            "status": (("record", "pga"), status),
            "message": (("record", "pga"), np.where(status == "failed", "it fell", "")),
        },
        {"record": list("abcde"), "pga": ("pga", level, {"units": "m/s^2"})},
    )


def test_incremental_dynamic_analysis(table):
    curve = ida(table, "tilt", "pga", threshold=8.5)
    # linear between levels: responses k·l² below and above 8.5
    expected = [np.inf, 3 + 2.2 / 4.9, 2 + 4.5 / 5.0, 2 + 2.5 / 7.5, 1 + 6.0 / 7.5]
    assert np.allclose(curve.capacity, expected)
    assert np.allclose(curve.fractiles[1], [1.0, 4.0, 9.0, 13.6])
    high = ida(table, "tilt", "pga", threshold=30.0).capacity
    assert np.isinf(high[:4]).all() and np.isnan(high[4])  # unknown because of a failed run
    with pytest.raises(InputError, match="select one value of each other dimension"):
        ida(table, "tilt", "pga", record="seed")


def test_a_fragility_of_a_study_excludes_failed_runs(table):
    curve = fragility_of(table, "tilt", 8.5, "pga")
    assert curve.trials.tolist() == [5, 5, 5, 4] and curve.failures.tolist() == [0, 1, 3, 3]


def test_a_fragility_states_cases_beyond_their_horizon(table):
    assert "is unknown" in fragility_of(table, "tilt", 8.5, "pga").doubt
    table_with_horizons = table.assign(tilt_decided_s=table.tilt * 0 + 10.0,
                                       end_s=table.tilt * 0 + 10.0)  # fmt: skip
    assert fragility_of(table_with_horizons, "tilt", 8.5, "pga").doubt == ""
    undecided_table = table_with_horizons.assign(
        tilt_decided_s=table_with_horizons.tilt_decided_s.where(table.tilt < 20, 6.0)
    )
    curve = fragility_of(undecided_table.where(table.tilt.notnull()), "tilt", 8.5, "pga")
    failures, cases = int((table.tilt >= 20).sum()), int(table.tilt.notnull().sum())
    assert curve.doubt.startswith(f"{failures} of {cases} cases end after the horizon of tilt")
    assert curve.doubt[:20] in curve.picture().axes[0].get_title(loc="left")


@pytest.mark.parametrize(
    ("threshold", "why", "low", "high"),
    [
        (100.0, "no case failed", 0.0, 1 - 0.025 ** (1 / 4)),  # none of 4 at level 4
        (0.1, "all cases failed", 0.025 ** (1 / 5), 1.0),  # all of 5 at level 1 and above
    ],
)
def test_a_fragility_without_a_curve_has_bounds(table, threshold, why, low, high, tmp_path):
    """Clopper and Pearson of 0 of n: 1 − (α/2)^(1/n); of n of n: (α/2)^(1/n)."""
    curve = fragility_of(table, "tilt", threshold, "pga")
    assert curve.why.startswith(why) and not hasattr(curve, "median")
    assert np.allclose(curve.band(4.0), (low, high))
    assert f"At pga 4 m/s² the probability of failure is between {low:.2g} and" in curve.words
    figure = {"kind": "fragility", "quantity": "tilt", "threshold": threshold, "intensity": "pga"}
    page = write_report(table, tmp_path / "page.html", [figure]).read_text()
    assert page.index(f"No curve: {why}") < page.index("20 cases") < page.index("<figure")


def test_a_fragility_has_a_verdict_at_its_design_level(table):
    curve = fragility_of(table, "tilt", 8.5, "pga", design=2.0)
    assert curve.words.startswith("Stands at pga 2 m/s²: half of the cases fail at pga ")
    assert f"{curve.median / 2:.3g} times the design level" in curve.words
    assert fragility_of(table, "tilt", 8.5, "pga", design=4.0).words.startswith("Fails at pga 4")


def test_records_matched_to_one_spectrum_cause_a_warning(table):
    step, time = 0.01, np.arange(0, 6, 0.01)
    rng = np.random.default_rng(2)
    noise = [Record(f"{i}", rng.normal(size=time.size) * np.exp(-time), step) for i in range(3)]
    matched = synthetic(range(1, 4), eurocode8(2.0, "B"), duration=6.0)
    for records, has_warning in ((matched, True), (noise, False)):
        attributes = Records(records, [1.0], "pga").coordinates["record"][2]
        own_table = table.assign_coords(record=("record", list("abcde"), attributes))
        doubt = fragility_of(own_table, "tilt", 8.5, "pga").doubt
        assert ("matched to one spectrum" in doubt) is has_warning


def test_indices_of_ishigami_agree_with_theory_and_another_program():
    from SALib.analyze import sobol as other

    u = uniform(-np.pi, np.pi)
    design = saltelli(2**11, {"x1": u, "x2": u, "x3": u}, seed=1)
    with ThreadPoolExecutor(1) as pool:
        table = sitedda.study(study_functions.ishigami, design, executor=pool)
    indices = sobol_indices(table, "value")
    assert np.allclose(indices.first, [0.3139, 0.4424, 0.0], atol=0.03)
    assert np.allclose(indices.total, [0.5576, 0.4424, 0.2437], atol=0.03)
    assert np.all(indices.first_interval[:, 0] < indices.first)
    rows = table["value"].values.reshape(5, -1)  # A, B, and A with a column of B
    order = np.concatenate([rows[:1], rows[2:], rows[1:2]]).T.ravel()
    problem = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[-np.pi, np.pi]] * 3}
    reference_result = other.analyze(problem, order, calc_second_order=False, num_resamples=2)
    assert np.allclose(indices.first, reference_result["S1"], atol=5e-3)
    assert np.allclose(indices.total, reference_result["ST"], atol=5e-3)
    with pytest.raises(InputError, match="not a design"):
        sobol_indices(table.isel(sample=slice(7)), "value")


def test_a_tornado_begins_with_the_widest_range():
    design = one_at_a_time({"a": (0.0, 1.0, 3.0), "b": (1.0, 2.0, 9.0)})
    with ThreadPoolExecutor(1) as pool:
        table = sitedda.study(study_functions.plane, design, executor=pool)
    result = tornado(table, "sum")
    assert result.names == ["b", "a"] and result.base == 3.0
    assert result.swing.tolist() == [8.0, 3.0]
    assert result.low.tolist() == [2.0, 2.0] and result.high.tolist() == [10.0, 5.0]
    assert result.low_values.tolist() == [1.0, 0.0]


def test_maps_and_bands_of_a_study():
    with ThreadPoolExecutor(1) as pool:
        table = sitedda.study(study_functions.plane, {"a": [2.0, 1.0], "b": [3.0, 0.0, 5.0]},
                              executor=pool)  # fmt: skip
    result = parameter_map(table, "sum", "a", "b", level=5.0)
    assert result.x.tolist() == [1.0, 2.0] and result.y.tolist() == [0.0, 3.0, 5.0]
    assert np.array_equal(result.values, [[np.nan] * 2, [4.0, 5.0], [6.0, 7.0]], equal_nan=True)
    rows = bands(table.isel(b=2), "row", "a")
    assert np.allclose(rows.fractiles[1], [1.5, 5.0, 7.5])
    with pytest.raises(InputError, match="select one value of each other dimension"):
        parameter_map(table, "row", "a", "b")


def test_a_report_contains_the_requested_figures(table, tmp_path):
    figures = [
        {"kind": "ida", "quantity": "tilt", "intensity": "pga", "threshold": 8.5},
        {"kind": "fragility", "quantity": "tilt", "threshold": 8.5, "intensity": "pga"},
        {"kind": "map", "quantity": "tilt", "x": "pga", "y": "record", "title": "Where"},
    ]
    page = write_report(table, tmp_path / "page.html", figures).read_text()
    for phrase in ("20 cases", "1 failed", "it fell", "capacity, fractiles 16, 50, 84 %",
                  "dispersion β",
                  "Not drawn: a map requires two parameters with numbers as values"):  # fmt: skip
        assert phrase in page, phrase
    assert page.count("<figure") == 2
    with pytest.raises(InputError, match="did you mean 'map'"):
        write_report(table, tmp_path / "page.html", [{"kind": "mop"}])
    with pytest.raises(InputError, match="no key 'level'; its keys are quantity"):
        write_report(table, tmp_path / "page.html", [{"kind": "ida", "level": 3}])
