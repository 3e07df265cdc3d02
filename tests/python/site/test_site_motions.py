# SPDX-License-Identifier: GPL-3.0-or-later
"""Processing of records for an analysis, and amplification tables for hazard analyses."""

import numpy as np
import pandas as pd
import pytest
import test_site
import xarray as xr
from scipy.stats import norm

from sitedda import Column, ConvergenceError, HalfSpace, InputError, Layer
from sitedda.signals import spectral_acceleration
from sitedda.site import (
    Suite,
    amplification_table,
    band_pass,
    conditional_mean,
    darendeli,
    matched,
    read_flatfile,
    resampled,
    rotated_spectra,
    scale_to,
    suite,
)
from sitedda.site.amplification import AmplificationTable
from sitedda.site.motions import of_acceleration, spectral_correlation
from sitedda.study import asce7, eurocode8, eurocode8_2024, synthetic

STEP = 0.01


def ricker(frequency, samples=2000, at=10.0):
    return of_acceleration(test_site.ricker(frequency, samples, at, STEP), STEP)


def final_motion(motion) -> float:
    """Return the larger ratio of final to peak value of velocity and displacement."""
    histories = (motion.velocity.values, motion.displacement.values)
    return max(abs(v[-1]) / abs(v).max() for v in histories)


def test_a_band_pass_has_no_phase_shift_and_ends_at_rest():
    """Two passes of a Butterworth filter: 1/(1 + (f/f_c)^2n) at f, a half at the corner."""
    motion = ricker(2.0)
    filtered = band_pass(motion, 0.2, 2.0)
    shift = (filtered.time.size - motion.time.size) // 2
    peak = int(abs(filtered.acceleration.values).argmax())
    assert peak - shift == int(abs(motion.acceleration.values).argmax())
    n = 1 << 15
    ratio = np.fft.rfft(filtered.acceleration, n) / np.fft.rfft(motion.acceleration, n)
    frequency = np.fft.rfftfreq(n, STEP)
    warped = np.tan(np.pi * frequency * STEP)  # the bilinear transform
    low, high = np.tan(np.pi * 0.2 * STEP), np.tan(np.pi * 2.0 * STEP)
    with np.errstate(divide="ignore"):
        s = (warped**2 - low * high) / (warped * (high - low))
    pass_band = (frequency > 0.3) & (frequency < 4)
    np.testing.assert_allclose(abs(ratio)[pass_band], (1 / (1 + s**8))[pass_band], atol=1e-3)
    assert final_motion(filtered) < 1e-3
    with pytest.raises(InputError, match="corners of 3 and 2 Hz"):
        band_pass(motion, 3, 2)
    with pytest.raises(InputError, match="below 50 Hz"):
        band_pass(motion, 0.1, 60)


def test_resampling_keeps_frequencies_below_both_limits():
    motion = ricker(2.0)
    fine = resampled(motion, STEP / 3)
    np.testing.assert_allclose(fine.acceleration[::3], motion.acceleration, atol=2e-3)
    x = (np.pi * 2.0 * (fine.time.values - 10.0)) ** 2
    np.testing.assert_allclose(fine.acceleration, (1 - 2 * x) * np.exp(-x), atol=2e-3)
    time = STEP * np.arange(2000)
    fast = of_acceleration(np.sin(2 * np.pi * 40 * time), STEP)
    assert abs(resampled(fast, 2 * STEP).acceleration.values[50:-50]).max() < 0.01
    with pytest.raises(InputError, match="whole numbers"):
        resampled(motion, STEP / np.pi / 400)


def test_targets_are_sorted_by_their_periods():
    """A motion whose spectrum is the target has the factor 1."""
    motion, grid = ricker(2.0), np.geomspace(0.1, 2.0, 20)
    values = spectral_acceleration(motion.acceleration.values, STEP, grid, 0.05)
    shuffled = np.random.default_rng(1).permutation(20)
    for order in (slice(None), slice(None, None, -1), shuffled):
        assert scale_to(motion, (grid[order], values[order]), grid) == pytest.approx(1, rel=1e-12)
    for periods, message in (([1.0, 0.1, 1.0], "the period 1 s is repeated"),
                             ([0.1, 0.0, 1.0], "a period of 0 s must be above 0"),
                             ([0.1, 1.0], "as many values as periods")):  # fmt: skip
        with pytest.raises(InputError, match=f"target: .*{message}"):
            scale_to(motion, (periods, [1.0, 2.0, 3.0]), grid)


def test_rotated_spectra_are_those_of_all_directions(record):
    pyrotd = pytest.importorskip("pyrotd")
    second = record.assign(acceleration=0.6 * record.acceleration.shift(time=40, fill_value=0.0))
    periods = np.array([0.2, 0.5, 1.0])
    spectra = rotated_spectra(record, second, periods, (0, 50, 100))
    step = float(record.time[1])
    x, y = record.acceleration.values, second.acceleration.values
    reference = pyrotd.calc_rotated_spec_accels(step, x, y, 1 / periods, 0.05)
    np.testing.assert_array_equal(spectra[1], reference.spec_accel[reference.percentile == 50])
    rotated = [spectral_acceleration(np.cos(t) * x + np.sin(t) * y, step, periods)
              for t in np.radians(np.arange(0, 180, 15))]  # fmt: skip
    assert np.all(np.max(rotated, axis=0) <= spectra[2] * 1.01)
    assert np.all(np.min(rotated, axis=0) >= spectra[0] * 0.99)
    coarse = second.isel(time=slice(None, None, 2))
    with pytest.raises(InputError, match="resample one"):
        rotated_spectra(record, coarse, periods)


def test_scaling_and_selection_to_a_conditional_mean(record, tmp_path):
    periods = np.array([0.1, 0.15, 0.25, 0.4, 0.65, 1.0, 1.4, 2.0])
    spectrum = spectral_acceleration(record.acceleration.values, float(record.time[1]), periods)
    assert scale_to(record, (periods, 2.5 * spectrum), periods) == pytest.approx(2.5)
    assert spectral_correlation(1.0, 1.0) == pytest.approx(1.0)
    # Baker and Jayaram (2008): 1 - cos(π/2 - .366 ln(T_max/max(T_min, .109))) beyond .109 s
    assert spectral_correlation(0.2, 1.0) == pytest.approx(1 - np.sin(0.366 * np.log(5)))
    period = np.array([0.109 - 1e-9, 0.109 + 1e-9, 0.2 - 1e-9, 0.2])
    correlations = spectral_correlation(0.05, period)
    assert np.all((correlations > 0) & (correlations < 1))
    assert abs(correlations[0] - correlations[1]) < 1e-3
    median, sigma = 1 / periods, np.full(8, 0.6)
    mean, spread = conditional_mean(periods, median, sigma, 1.0, 2.0)
    assert mean[5] == pytest.approx(np.exp(1.2)) and spread[5] == pytest.approx(0.0, abs=1e-7)
    assert np.all(mean / median <= np.exp(1.2)) and 0 < spread[0] < 0.6
    rows = {f"tilt{t}.at2": 0.5 * mean * periods**t / 9.80665 for t in (-0.4, 0.0, 0.3)}
    flat = pd.DataFrame([*rows.values(), [-999] * 8], columns=[f"T{p:.3f}S" for p in periods])
    flat.insert(0, "file", [*rows, "broken.at2"])
    file = tmp_path / "flat.csv"
    flat.to_csv(file, index=False)
    flatfile = read_flatfile(file)
    assert len(flatfile.names) == 3  # the record without a spectrum is omitted
    best = flatfile.select((periods, mean), 2, flatfile.periods[1:-1])
    assert [one[0] for one in best] == ["tilt0.0.at2", "tilt0.3.at2"]
    assert best[0][1] == pytest.approx(2.0, rel=1e-3) and best[0][2] < 1e-2
    with pytest.raises(InputError, match="has 3 records"):
        flatfile.select((periods, mean), 4, flatfile.periods[1:-1])


def test_spectra_of_asce_7_and_ec8_2024_have_their_corners():
    """EC8: T_A = 0.02 s, T_B = T_C / 4 from 0.05 to 0.1 s, T_C = S_β / S_α, T_D = 1 + S_β,RP."""
    spectrum = asce7(9.0, 5.4, 6.0)  # T_S = 0.6, T_0 = 0.12 s
    periods = [0.0, 0.06, 0.12, 0.6, 1.0, 6.0, 12.0]
    np.testing.assert_allclose(spectrum(periods), [3.6, 6.3, 9, 9, 5.4, 0.9, 0.225])
    with pytest.raises(InputError, match="S_DS = 9"):
        asce7(9.0, 100.0)
    spectrum = eurocode8_2024(5.0, 2.0, (1.5, 1.5))  # T_C 0.4, T_B 0.1, T_D 3 s; S_α 7.5, S_β 3
    periods = [0.0, 0.02, 0.06, 0.1, 0.4, 1.0, 3.0, 6.0]
    np.testing.assert_allclose(spectrum(periods), [3, 3, 5.25, 7.5, 7.5, 3, 1, 0.25])
    assert eurocode8_2024(8.0, 0.8)(np.array([0.05, 2.0, 4.0])) == pytest.approx([8, 0.4, 0.1])
    with pytest.raises(InputError, match="S_α = 1 and S_β = 3"):
        eurocode8_2024(1.0, 3.0)


@pytest.mark.parametrize(
    ("target", "band"),
    [
        pytest.param(eurocode8(2.0, "B"), (0.1, 2.0), id="EC8"),
        pytest.param(asce7(9.0, 5.4, 6.0), (0.1, 2.0), id="ASCE 7"),
        pytest.param(eurocode8(2.0, "D"), (0.02, 5.0), marks=pytest.mark.slow, id="EC8, 50 Hz"),
        pytest.param(asce7(3.0, 0.8), (0.02, 5.0), marks=pytest.mark.slow, id="ASCE 7, 50 Hz"),
    ],
)
def test_a_result_has_the_spectrum_and_ends_at_rest(record, target, band):
    motion = matched(record, target, band)
    step, periods = float(motion.time[1]), np.geomspace(*band, 8000)  # dense for narrow peaks
    spectrum = spectral_acceleration(motion.acceleration.values, step, periods)
    assert np.abs(spectrum / target(periods) - 1).max() < 0.05
    assert motion.attrs["misfit"] < 0.05
    assert final_motion(motion) < 1e-9
    size = abs(motion.acceleration.values)
    assert size[:200].max() < 0.3 * size.max()  # the beginning remains weak


@pytest.mark.parametrize("seed", [1, 3])
def test_a_short_motion_is_matched_at_long_periods(seed):
    """Oscillators of 4 s vibrate longer than the motion of 10 s."""
    target = eurocode8(2.0, "B")
    motion = synthetic(seed, target, 10.0, 0.02, (0.1, 2.0))[0]
    result = matched(of_acceleration(motion.acceleration, motion.time_step), target, (0.4, 4.0))
    assert result.attrs["misfit"] < 0.05 and final_motion(result) < 1e-9


def test_a_match_that_fails_is_an_error(record):
    target = eurocode8(2.0, "B")
    with pytest.raises(ConvergenceError, match="allowed: 0.001 %"):
        matched(record, target, (0.1, 2.0), tolerance=1e-5, most_rounds=2)
    with pytest.raises(InputError, match="cannot be matched at periods of 50 s"):
        matched(record, target, (0.1, 50.0))
    with pytest.raises(InputError, match="tolerance must be finite and positive, got -0.05"):
        matched(record, target, tolerance=-0.05)
    with pytest.raises(InputError, match="a motion of zeros cannot be matched"):
        matched(of_acceleration(np.zeros(2000), STEP), target)


# --- amplification tables ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def known_suite():
    """Return a suite whose amplification is a formula with known scatter."""
    random = np.random.default_rng(1)
    deviations = random.standard_normal((40, 1, 3))
    rock = np.geomspace(0.2, 8.0, 12)[None, :, None] * np.exp(0.3 * deviations)
    noise = 0.25 * random.standard_normal(rock.shape)
    factor = 2.0 * ((rock + 1.0) / 1.0) ** -0.6 * np.exp(noise)
    dims = ("motion", "level", "period")
    table = xr.Dataset(
        {"reference": (dims, rock), "amplification": (("profile", *dims, "analysis"),
                                                      factor[None, ..., None])},
        {"period": [0.01, 0.2, 1.0], "analysis": ["nonlinear"]},
    )  # fmt: skip
    return Suite(table)


def test_a_table_has_the_known_amplification_and_scatter(known_suite):
    levels = [0.5, 1.0, 2.0, 4.0]
    table = amplification_table(known_suite, levels, "nonlinear").table
    expected = 2.0 * (1 + np.array(levels)) ** -0.6
    np.testing.assert_allclose(table["median"].values.T, np.tile(expected, (3, 1)), rtol=0.05)
    np.testing.assert_allclose(table.sigma_ln, 0.25, atol=0.05)
    assert table.period.values[0] == 0  # PGA
    sparse = amplification_table(known_suite, [0.001, 1.0], "nonlinear").table
    assert np.isnan(sparse["median"].values[0]).all()  # no motion has this level
    with pytest.raises(InputError, match="the suite has nonlinear"):
        amplification_table(known_suite, levels, "linear")


def openquake_convolution(table, imt, rock_levels, poes, soil_levels):
    """Return exceedance probabilities at the surface by OpenQuake's method 'convolution'."""
    middle = (rock_levels[:-1] + rock_levels[1:]) / 2
    median, sigma = (np.interp(middle, table.level, table[name]) for name in (imt, f"sigma_{imt}"))
    return norm.sf(np.log(soil_levels[:, None] / middle), np.log(median), sigma) @ -np.diff(poes)


def test_openquake_reads_the_table_and_convolves_equally(known_suite, tmp_path):
    amplification = amplification_table(known_suite, np.geomspace(0.3, 6.0, 25), "nonlinear")
    file = amplification.to_openquake(tmp_path / "af.csv", "S1", 760)
    lines = file.read_text().splitlines()
    assert lines[0] == '#,,"vs30_ref=760"'
    assert lines[1] == "ampcode,level,PGA,SA(0.2),SA(1),sigma_PGA,sigma_SA(0.2),sigma_SA(1)"
    table = pd.read_csv(file, skiprows=1)
    assert (table.ampcode == "S1").all() and len(table) == 25
    rock = np.geomspace(0.005, 20.0, 560)  # g
    poes = 1e-2 * (rock / 0.01 + 1) ** -2.0
    soil_levels = np.geomspace(0.08, 0.4, 9)
    by_rule = openquake_convolution(table, "SA(1)", rock, poes, soil_levels)
    probabilities = amplification.hazard(1.0, 9.80665 * rock, poes, 9.80665 * soil_levels)
    np.testing.assert_allclose(probabilities, by_rule, rtol=0.02)
    with pytest.raises(InputError, match="code = 'A B'"):
        amplification.to_openquake(tmp_path / "x.csv", "A B")
    pytest.importorskip("openquake.hazardlib", reason="OpenQuake is not installed")
    from openquake.baselib.general import DictArray
    from openquake.hazardlib.site_amplification import AmplFunction, Amplifier

    levels = {imt: list(rock) for imt in ("PGA", "SA(0.2)", "SA(1)")}
    frame = AmplFunction.read_df(str(file))
    assert frame.vs30_ref == 760
    amplifier = Amplifier(DictArray(levels), frame, soil_levels)
    amplified = amplifier.amplify_one(b"S1", "SA(1)", list(poes))[:, 0]
    np.testing.assert_allclose(probabilities, amplified, rtol=0.05)


@pytest.mark.filterwarnings("error")
def test_the_last_level_of_a_hazard_curve_counts():
    """Closed forms for rates k₀ x^-k, and a median m and σ at all levels."""
    m, sigma, k0, k = 1.5, 0.3, 1e-3, 2.5
    values = {name: (("level", "period"), np.full((3, 1), v))
              for name, v in (("median", m), ("sigma_ln", sigma))}  # fmt: skip
    table = AmplificationTable(xr.Dataset(values, {"level": [0.5, 1.0, 3.0], "period": [0.2]}))
    wanted = np.array([0.5, 2.0, 6.0, 7.5])
    exact = k0 * (wanted / m) ** -k * np.exp((k * sigma) ** 2 / 2)
    levels = np.geomspace(0.05, 50.0, 60)
    rates = table.hazard(0.2, levels, k0 * levels**-k, wanted)
    np.testing.assert_allclose(rates, exact, rtol=1e-3)
    levels = np.geomspace(0.05, 5.0, 60)
    cut = norm.cdf(np.log(levels[-1] * m / wanted) / sigma + k * sigma)
    with pytest.warns(UserWarning, match="% of the rate of 7.5 m/s² come from rock"):
        rates = table.hazard(0.2, levels, k0 * levels**-k, wanted)
    np.testing.assert_allclose(rates, exact * cut, rtol=2e-3)
    for bad, message in (((levels[::-1], levels), "levels must increase: see 4.6"),
                         ((levels, levels), "rates must not increase: see 0.05"),
                         ((levels, levels[1:]), "one rate for each level")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            table.hazard(0.2, *bad, wanted)


def test_amplification_decreases_with_intensity():
    column = Column([Layer(20.0, density=1800.0, shear_velocity=200.0)],
                    HalfSpace(density=2200.0, shear_velocity=760.0))  # fmt: skip
    motions = [ricker(f, 800, 4.0) for f in np.geomspace(1.0, 4.0, 30)]
    levels = [0.1, 0.3, 1.0, 3.0]
    result = suite([(column, [darendeli(1e5, 15.0)])], motions, ["equivalent-linear"],
                  periods=[0.05, 0.4], levels=levels, measure="pga", workers=1)  # fmt: skip
    reference = result.table.reference
    table = amplification_table(result, [0.3, 1.0]).table
    assert (table["median"].sel(level=1.0) < table["median"].sel(level=0.3)).all()
    assert reference.sel(period=0.05).values[:, 1] == pytest.approx(0.3, rel=0.07)
