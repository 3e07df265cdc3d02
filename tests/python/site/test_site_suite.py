# SPDX-License-Identifier: GPL-3.0-or-later
"""Suites of motions and random profiles, against pystrata and published models."""

import json

import numpy as np
import pytest
import xarray as xr
from test_nonlinear_site import noise

from sitedda import InputError
from sitedda.signals import spectral_acceleration
from sitedda.site import (
    TORO,
    SoilCurves,
    darendeli,
    equivalent_linear,
    nonlinear,
    randomized,
    read_profile,
    read_suite,
    suite,
)
from sitedda.site.equivalent_linear import small_strain_column
from sitedda.site.randomization import interfaces, truncated, varied_curves

STEP = 0.01
BORE = """top (ft), Vs (ft/s), unit weight (pcf), damping (%), curve
0, 500, 115, 2, darendeli 0
10, , 118, 2, darendeli 15
25, 800, 122, 2, darendeli 20
50, 1200, 125, 2, darendeli 0
90, 2800, 140, 0.5, linear
"""


@pytest.fixture
def bore(tmp_path):
    file = tmp_path / "bore.csv"
    file.write_text(BORE)
    return file


def shaking(seed, peak=0.5, samples=1500, step=STEP):
    """Return noise between 0.5 and 10 Hz with a smooth envelope, as a motion in m/s²."""
    series = peak * noise(step, samples, 10, seed)
    return xr.Dataset({"acceleration": ("time", series)}, {"time": step * np.arange(samples)})


def test_gaps_are_reported_with_their_heading_and_filled(bore):
    with pytest.raises(InputError, match=r"row 3: Vs \(ft/s\) has a gap; .* fill = 'above'"):
        read_profile(bore)
    assert read_profile(bore, "above").layers[1].shear_velocity == pytest.approx(500 * 0.3048)
    velocity = 500 + 300 * (17.5 - 5) / (37.5 - 5)  # at the depths of the layer centres
    layer = read_profile(bore, "interpolate").layers[1]
    assert layer.shear_velocity == pytest.approx(velocity * 0.3048)
    assert layer.density == pytest.approx(118 * 16.018463, rel=1e-6)
    bore.write_text(BORE.replace("0, 500,", "0, ,").replace("10, ,", "10, 600,"))
    with pytest.raises(InputError, match=r"row 2: the gap of Vs \(ft/s\) cannot .* no row above"):
        read_profile(bore, "above")


def test_a_suite_has_the_results_of_its_cases(bore):
    """Each number of the table equals that of a single analysis; so do the statistics."""
    sites = randomized(read_profile(bore, "above"), 2, curves=-0.5)
    motions = {"a": shaking(1), "b": shaking(2)}
    periods = [0.1, 0.5, 2.0]
    result = suite(sites, motions, periods=periods, levels=[1.0, 3.0], workers=1)
    table = result.table
    assert dict(table.status.sizes) == {"profile": 2, "motion": 2, "level": 2, "analysis": 3}
    assert (table.status == "complete").all()
    ground = 3.0 * motions["b"].acceleration.values
    column, curves = sites[1]
    responses = {
        "linear": small_strain_column(column, curves).response(ground, STEP),
        "equivalent-linear": equivalent_linear(column, curves, ground, STEP).response,
        "nonlinear": nonlinear(column, curves, ground, STEP),
    }
    rock = spectral_acceleration(ground, STEP, periods)
    for name, response in responses.items():
        # yielding amplifies rounding of the factor
        rtol = 1e-6 if name == "nonlinear" else 1e-9
        case = table.sel(analysis=name, motion="b").isel(profile=1, level=1)
        np.testing.assert_allclose(case.sa, response.spectrum(periods), rtol)
        np.testing.assert_allclose(case.amplification, response.spectrum(periods) / rock, rtol)
        assert case.strain == pytest.approx(response.largest[0], rel=rtol)
    factors = np.log(table.amplification.sel(analysis="linear").isel(level=0).values).reshape(4, 3)
    statistics = result.statistics.sel(analysis="linear").isel(level=0)
    np.testing.assert_allclose(statistics["median"], np.exp(factors.mean(0)))
    np.testing.assert_allclose(statistics.sigma_ln, factors.std(0, ddof=1))
    assert (statistics["count"] == 4).all()


def test_the_command_continues_an_interrupted_suite(bore, python_program):
    folder = bore.parent
    text = "TIME SERIES\nx\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 1500, DT= .0100 SEC\n"
    for name in ("one", "two"):
        series = shaking(len(name) + ord(name[0])).acceleration.values / 9.80665
        (folder / f"{name}.at2").write_text(text + "\n".join(f"{v:.7E}" for v in series) + "\n")
    settings = "profile = 'bore.csv'\nfill = 'above'\nmotions = '*.at2'\nanalyses = ['linear']\n"
    (folder / "suite.toml").write_text(settings + "randomize = {count = 3}\n")
    process = python_program("site", folder / "suite.toml", "-q")
    assert process.returncode == 0, process.stderr
    assert "6 complete" in process.stdout
    results = list((folder / "suite_suite").rglob("result.json"))
    assert len(results) == 6
    first_result = json.loads(results[0].read_text())
    results[0].unlink()
    for file in results[1:]:  # existing results are not computed again
        file.write_text(file.read_text().replace('"seconds": ', '"seconds": 1'))
    python_program("site", folder / "suite.toml", "-q")
    assert json.loads(results[0].read_text())["numbers"] == first_result["numbers"]
    assert all('"seconds": 1' in file.read_text() for file in results[1:])
    rows = (folder / "suite_suite" / "suite.csv").read_text().splitlines()
    assert rows[0].startswith("analysis,level,period_s,median,sigma_ln,count,converged")
    assert len(rows) == 21
    assert "Site response of a suite" in (folder / "suite_suite" / "suite.html").read_text()
    (folder / "suite.toml").write_text(settings + "randomise = {count = 3}\n")
    process = python_program("site", folder / "suite.toml", "-q")
    assert process.returncode != 0 and "there is no 'randomise'" in process.stderr


@pytest.mark.parametrize("unit", ["g", "m/s2", "furlong"])
def test_the_file_of_a_suite_states_the_unit_of_text_records(bore, unit):
    series = shaking(1).acceleration.values
    np.savetxt(bore.with_name("one.txt"), series)
    file = bore.with_name("suite.toml")
    file.write_text(f"profile = 'bore.csv'\nfill = 'above'\nmotions = 'one.txt'\n"
                    f"unit = '{unit}'\ntime_step = {STEP}\n")  # fmt: skip
    if unit == "furlong":
        with pytest.raises(InputError, match=r"suite\.toml: .*one\.txt.*furlong"):
            read_suite(file)
        return
    (motion,) = read_suite(file)["motions"]
    factor = 9.80665 if unit == "g" else 1.0
    assert motion.acceleration.values / factor == pytest.approx(series, abs=0.02)
    assert float(motion.time[1]) == pytest.approx(STEP)


def test_failed_cases_are_excluded_and_reported(bore):
    column, curves = randomized(read_profile(bore, "above"), 1, velocity=None)[0]
    excessive = SoilCurves([1e-6, 1e-2], [1, 0.9], [0.6, 0.6])  # more than the convention permits
    result = suite([(column, curves), (column, [excessive] * len(curves))], [shaking(1)],
                  ["equivalent-linear"], periods=[0.2, 1.0], workers=1)  # fmt: skip
    assert (result.statistics["count"] == 1).all()
    assert "1 case failed" in str(result) and "damping ratio of 0.6" in str(result)


def test_median_and_sigma_agree_with_pystrata(bore, strata_profile):
    """100 Toro profiles, linear and equivalent-linear: median within 1 %, σ within 0.01."""
    pystrata = pytest.importorskip("pystrata")
    sites = randomized(read_profile(bore, "above"), 100, sigma=0.2)
    step = 0.005  # small enough for equal results of both oscillators
    motion = shaking(4, 1.0, 3000, step)
    ground, periods = motion.acceleration.values, np.geomspace(0.1, 3.0, 20)
    names = ["linear", "equivalent-linear"]
    statistics = suite(sites, [motion], names, periods=periods, workers=2).statistics
    length = 1 << (2 * ground.size - 1).bit_length()
    padded = np.concatenate([ground / 9.80665, np.zeros(length - ground.size)])
    rock = pystrata.motion.TimeSeriesMotion("", "", step, padded)
    reference = {name: [] for name in names}
    for column, curves in sites:
        for name in names:
            profile = strata_profile(column.layers, column.base, curves)
            if name == "linear":
                calc = pystrata.propagation.LinearElasticCalculator()
            else:
                calc = pystrata.propagation.EquivalentLinearCalculator(0.65, 1e-5, 200)
            outcrop = profile.location("outcrop", index=-1)
            calc(rock, profile, outcrop)
            ratio = calc.calc_accel_tf(outcrop, profile.location("outcrop", index=0))
            freqs = 1 / periods
            surface_accels = rock.calc_osc_accels(freqs, 0.05, ratio)
            reference[name].append(np.log(surface_accels / rock.calc_osc_accels(freqs, 0.05)))
    for name in names:
        factors = np.array(reference[name])
        result = statistics.sel(analysis=name).isel(level=0)
        np.testing.assert_allclose(result["median"], np.exp(factors.mean(0)), rtol=0.01)
        np.testing.assert_allclose(result.sigma_ln, factors.std(0, ddof=1), atol=0.01)


# --- random profiles -----------------------------------------------------------------------------


def uniform(tmp_path, layers=12, thick=5.0):
    rows = [f"{thick * i}, 300, 1900, darendeli 15" for i in range(layers)]
    rows.append(f"{thick * layers}, 1200, 2200, linear")
    file = tmp_path / "uniform.csv"
    file.write_text("top (m), Vs (m/s), density (kg/m3), curve\n" + "\n".join(rows) + "\n")
    return read_profile(file)


@pytest.mark.parametrize("name", ["USGS B", "USGS D", "Geomatrix AB"])
def test_velocities_have_the_statistics_of_the_published_model(tmp_path, name):
    """1,000 profiles: median, σ, correlation of neighbours, and truncation."""
    sites, model = randomized(uniform(tmp_path), 1000, velocity=name), TORO[name]
    logs = np.log([[la.shear_velocity for la in column.layers] for column, _ in sites])
    count = len(logs)
    deviates = (logs - np.log(300)) / model.sigma
    assert np.abs(deviates.mean(0)).max() < 4 / np.sqrt(count)
    assert np.abs(deviates.std(0) - 1).max() < 4 * np.sqrt(0.5 / count)
    assert np.abs(deviates).max() < 2 / 0.8796  # truncated at 2 σ, scaled to the σ of the model
    middles = 2.5 + 5.0 * np.arange(12)
    correlations = model.correlation(middles)
    mean, distance = (middles[1:] + middles[:-1]) / 2, 5.0
    deep = model.rho_200 * ((mean + model.h_0) / (200 + model.h_0)) ** model.b
    formula = (1 - deep) * model.rho_0 * np.exp(-distance / model.delta) + deep
    np.testing.assert_allclose(correlations, formula, rtol=1e-12)
    sampled = [np.corrcoef(deviates[:, i], deviates[:, i + 1])[0, 1] for i in range(11)]
    error = (1 - correlations**2) / np.sqrt(count)
    assert np.all(np.abs(sampled - correlations) < 4 * error + 0.03)
    second_neighbours = np.corrcoef(deviates[:, 0], deviates[:, 2])[0, 1]  # a first-order chain
    assert abs(second_neighbours - correlations[0] * correlations[1]) < 4 / np.sqrt(count) + 0.03


def test_layering_has_the_published_rate():
    generator, count, depth = np.random.default_rng(3), 1000, 100.0
    by_sitedda = [interfaces(generator, depth) for _ in range(count)]
    assert all(depths[-1] == depth and np.all(np.diff(depths) > 0) for depths in by_sitedda)
    np.random.seed(3)
    thick = pytest.importorskip("pystrata.variation").ToroThicknessVariation()
    reference = [np.cumsum([t for t, _ in thick.iter_thickness(depth)]) for _ in range(count)]
    for low, high in ((0, 10), (10, 30), (30, 90)):
        rate = 1.98 / 0.11 * ((high + 10.86) ** 0.11 - (low + 10.86) ** 0.11)
        for sample in (by_sitedda, reference):
            number = np.mean([np.sum((depths > low) & (depths < high)) for depths in sample])
            assert abs(number - rate) < 4 * np.sqrt(rate / count)  # Poisson


def test_depth_to_rock_and_curves_vary_as_published(tmp_path):
    profile = uniform(tmp_path)
    sites = randomized(profile, 1000, velocity=None, depth_to_rock=0.3, curves=-0.5, clip=3.0)
    depth = np.log([column.depth / profile.depth for column, _ in sites])
    assert abs(depth.std() - 0.3) < 4 * 0.3 * np.sqrt(0.5 / 1000)
    assert abs(depth.mean()) < 4 * 0.3 / np.sqrt(1000)
    deepest = max(sites, key=lambda realisation: realisation[0].depth)[0]
    assert deepest.layers[-1].thickness > 5 and len(deepest.layers) == 12
    mean = profile.curves()[0]
    strain = 1e-4  # strain far from both limits
    moduli = np.array([curves[0].reduction_at(strain) for _, curves in sites])
    ratios = np.array([curves[0].damping_at(strain) for _, curves in sites])
    g, d = float(mean.reduction_at(strain)), float(mean.damping_at(strain))
    spread = np.exp(-4.23) + np.sqrt(0.25 / np.exp(3.62) - (g - 0.5) ** 2 / np.exp(3.62))
    assert moduli.std() == pytest.approx(spread, rel=0.1)
    spread = (np.exp(-5) + np.exp(-0.25) * np.sqrt(100 * d)) / 100
    assert ratios.std() == pytest.approx(spread, rel=0.1)
    assert np.corrcoef(moduli, ratios)[0, 1] == pytest.approx(-0.5, abs=0.1)


@pytest.mark.parametrize("deviates", [(2.27, 2.27), (-2.27, -2.27), (-2.27, 2.27), (9.0, -9.0)])
def test_varied_curves_remain_valid(deviates):
    curves = varied_curves(darendeli(1e5, 15.0), *deviates)
    assert np.all((curves.damping >= 0.001) & (curves.damping <= 0.15))
    assert np.all(np.diff(curves.reduction) <= 1e-15)
    assert np.all(np.diff(curves.strain * curves.reduction) >= -1e-18)


def test_realisations_do_not_depend_on_their_number_and_seeds_differ(tmp_path):
    profile = uniform(tmp_path)
    few, many = randomized(profile, 2, layering=True), randomized(profile, 5, layering=True)
    assert few[1][0] == many[1][0]
    assert randomized(profile, 1, 2, layering=True)[0][0] != few[0][0]
    assert truncated(np.array([0.0]), 2.0)[0] == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"velocity": "USGS E"}, "velocity = 'USGS E'"),
        ({"count": 0}, "count = 0"),
        ({"sigma": -1.0}, "sigma = -1"),
        ({"curves": 2.0}, "curves = 2"),
        ({"depth_to_rock": -0.1}, "depth_to_rock = -0.1"),
    ],
)
def test_invalid_randomisation_is_refused(tmp_path, values, message):
    with pytest.raises(InputError, match=message):
        randomized(uniform(tmp_path), **{"count": 1, **values})
