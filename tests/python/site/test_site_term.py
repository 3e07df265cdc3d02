# SPDX-License-Identifier: GPL-3.0-or-later
"""Site terms of plane models from many columns and few plane runs."""

import numpy as np
import pytest

from sitedda import InputError
from sitedda.site import site_term
from sitedda.site.site_terms import draw_samples, term_of


def draw(sample):
    return np.random.default_rng([5, sample]).standard_normal(3)


def columns(sample):
    """Return ln AF of two points at two periods: 0.3 x, and a similar value."""
    x, y, _ = draw(sample)
    return np.exp(0.3 * np.array([[x, 0.8 * x + 0.6 * y], [x, 0.8 * x + 0.6 * y]]))


def plane(sample):
    """The first point equals the column plus 0.03; the second is independent of it."""
    noise = np.random.default_rng([6, sample]).standard_normal((2, 2))
    logs = np.log(columns(sample))
    logs[0] += 0.2 + 0.03 * noise[0]
    logs[1] = 0.5 * noise[1]
    return np.exp(logs)


def finer(sample):
    return 1.01 * plane(sample)


def failing(sample):
    raise ValueError(f"sample {sample} is no good")


@pytest.mark.parametrize(
    ("noise", "columns", "least", "most"),
    [(0.05, 2000, 20, 500), (3.0, 2000, 0.7, 1.2), (0.3, 60, 0.7, 3.0)],
)
def test_intervals_have_their_nominal_coverage(noise, columns, least, most):
    """y = 0.2 + 1.1 x + 0.3 x² + noise with x normal, σ 0.3; 300 repetitions of 40 runs."""
    generator, covered, saving = np.random.default_rng(1), [], []
    mean = 0.2 + 0.3 * 0.09
    sigma = np.sqrt((1.1 * 0.3) ** 2 + 2 * (0.3 * 0.09) ** 2 + (0.3 * noise) ** 2)
    for _ in range(300):
        control = 0.3 * generator.standard_normal((columns, 1, 2))
        control[:, 0, 0] = 0.8 * control[:, 0, 1] + 0.6 * control[:, 0, 0]
        samples = draw_samples(control, 40, generator)
        x = control[samples, :, 1:]
        deviations = 0.3 * noise * generator.standard_normal((columns, 1, 1))[samples]
        result = np.tile(0.2 + 1.1 * x + 0.3 * x**2 + deviations, 2)
        table = term_of(result, control, samples, ["top"], [0.5, 1.0]).table.drop_dims("error")
        estimate = table.isel(point=0, period=1)
        covered.append([
            abs(np.log(estimate["median"]) - mean) <= estimate["sampling"],
            abs(estimate["sigma_ln"] - sigma) <= estimate["sigma_error"],
            abs(np.log(estimate["aggravation"]) - mean) <= estimate["aggravation_sampling"],
        ])  # fmt: skip
        saving.append(estimate.saving)
    # Confidence intervals of σ are less accurate: they need a fourth moment, here of 40 runs.
    assert np.all(np.abs(np.mean(covered, axis=0) - 0.95) < [0.05, 0.08, 0.05])
    assert least <= np.median(saving) <= most


def test_a_term_reports_results_without_saving(tmp_path):
    term = site_term(plane, columns, ["near", "far"], [0.2, 1.0], runs=40, columns=2000,
                      finer={"mesh": finer}, finer_runs=2, workers=1)  # fmt: skip
    table = term.table
    assert (table.saving.sel(point="near") > 10).all()
    assert (table.saving.sel(point="far") < 1.2).all()
    assert (np.abs(np.log(table["median"].sel(point="near")) - 0.2) < 0.03).all()
    np.testing.assert_allclose(table.discretisation.sel(error="mesh"), np.log(1.01) * 4 / 3)
    np.testing.assert_allclose(table.total - table.sampling, np.log(1.01) * 4 / 3)
    independent = table.sel(point="far")
    mean, error = np.log(independent["median"]), independent.sampling
    assert (np.abs(mean) < 1.5 * error).all()  # the exact mean is 0
    assert error.values == pytest.approx(2.02 * 0.5 / np.sqrt(40), rel=0.4)  # plain sampling
    assert "do not reduce the number of plane runs for 2 of 4 results" in str(term)
    lines = term.to_csv(tmp_path / "term.csv").read_text().splitlines()
    assert lines[0].startswith("point,period,median,") and len(lines) == 5


def test_errors_of_terms_are_reported():
    with pytest.raises(InputError, match="runs = 10, columns = 100: give 20"):
        site_term(plane, columns, ["a", "b"], [0.2, 1.0], runs=10, columns=100)
    with pytest.raises(InputError, match="column 0 has an amplification that is not finite"):
        site_term(plane, lambda i: np.zeros((2, 2)), ["a", "b"], [0.2, 1.0], runs=20, columns=20)
    with pytest.raises(InputError, match=r"sample \d+ is no good"):
        site_term(failing, columns, ["a", "b"], [0.2, 1.0], runs=20, columns=20, workers=1)
