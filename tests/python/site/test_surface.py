# SPDX-License-Identifier: GPL-3.0-or-later
"""Amplification along the surface of a run relative to its free field or its outcrop."""

import numpy as np
import pytest
from lattices import DENSITY, MODULUS, ROCK, lattice
from test_boundaries import outcrop_ratio, stack

import sitedda
from sitedda import Column, HalfSpace, Layer
from sitedda.plot import purpose_of, run_picture
from sitedda.signals import smooth_konno_ohmachi
from sitedda.site import surface

HILL = (4, 5)


def ground(hill=(), sides="free_field") -> sitedda.Run:
    """Return a run with points along the surface; the last point is inside the ground."""
    model = lattice(sides, hill=hill, duration=0.3)
    for i, x in enumerate((0.0, 2.5, 5.0, 7.5, 10.0)):
        model.measured_point(f"p{i}", x, 4.0 if 4 <= x <= 6 and hill else 3.0)
    model.measured_point("below", 5.0, 1.0)
    return model.run()


def test_level_ground_equals_its_free_field():
    run = ground()
    result = surface(run.history, lowest=10.0, highest=50.0)
    assert result.names == ["p0", "p1", "p2", "p3", "p4"] and "free field left" in result.reference
    corner = 0  # as that of the column at which its surface is measured
    np.testing.assert_allclose(result.amplification, 1.0, atol=1e-4)
    np.testing.assert_allclose(result.amplification[corner], 1.0, atol=1e-6)
    np.testing.assert_allclose(result.peak_acceleration[corner], 1.0, atol=1e-6)
    for side in ("left", "right"):
        assert run.verdict.values[f"side_departure[free field {side}]"] < 5e-8


def test_a_hill_amplifies_most_at_its_top():
    run = ground(HILL)
    result = surface(run.history, lowest=10.0, highest=50.0)
    assert int(np.argmax(result.peak_acceleration)) == 2
    top = run.history.acceleration.sel(point="p2", axis="x").values
    field = run.history.incoming_acceleration.sel(boundary="free field left", axis="x").values
    assert result.peak_acceleration[2] == pytest.approx(abs(top).max() / abs(field).max())
    departure = run.verdict.values["side_departure[free field left]"]
    assert 0.01 < departure < 0.3
    assert result.plot().axes
    # Level points have the column of the free field; the point on the hill has one layer more.
    np.testing.assert_allclose(result.column_amplification[[0, 1, 3, 4]], 1.0, rtol=1e-5)
    np.testing.assert_allclose(result.aggravation[1], result.amplification[1], rtol=1e-5)
    rock = HalfSpace(density=ROCK["density"], shear_velocity=ROCK["shear_velocity"])
    soil = [Layer(1.0, density=DENSITY + 100 * j, shear_modulus=MODULUS * (2 - 0.5 * j) / 2.5)
            for j in (2, 2, 1, 0)]  # fmt: skip
    at = {"frequencies": result.frequency, "time_step": 1e-3, "kind": "outcrop"}
    level, high = (abs(Column(soil[i:], rock).scheme_transfer(**at)) for i in (1, 0))
    # The ratio of spectra smoothed by one window is the smooth ratio of the columns.
    np.testing.assert_allclose(result.column_amplification[2, :90], (high / level)[:90], rtol=0.06)
    assert result.aggravation_factor[2] != pytest.approx(1.0, abs=0.02)


def test_the_column_below_a_cut_has_no_noise():
    """The free field has lost the highest frequencies, which the lower column retains."""
    model = lattice("free_field", hill=(0, 1, 2, 3, 6, 7, 8, 9), duration=0.3)
    for x, y in ((0.0, 4.0), (5.0, 3.0), (10.0, 4.0)):
        model.measured_point(f"at {x:g}", x, y)
    result = surface(model.run().history, lowest=10.0, highest=50.0)
    np.testing.assert_allclose(result.column_amplification[[0, 2]], 1.0, rtol=1e-5)
    assert 0.1 < result.aggravation[1].min() and result.aggravation[1].max() < 3.0


def test_the_picture_of_a_run_shows_amplification_along_its_surface():
    history = ground(HILL).history
    assert purpose_of(history).kind == "surface"
    labels = [axes.get_ylabel() for axes in run_picture(history).axes[:2]]
    assert labels == ["frequency (Hz)", "ratio"]
    few = history.isel(point=slice(2, None))
    assert purpose_of(few).kind == "shake"


def test_without_a_free_field_the_outcrop_of_the_half_space_is_the_reference():
    """A layer on a half-space agrees with the closed form, with equal smoothing."""
    time = np.arange(0.0, 0.2, 2e-3)
    pulse = np.sin(np.pi * time / 0.2) ** 2 * np.sin(2 * np.pi * time / 0.1)
    model = stack(20, motion=pulse, integration="midpoint", time_step=2e-3, duration=4.0)
    model.measured_point("edge", 0.0, 20.0)
    history = model.run().history
    result = surface(history, lowest=1.0, highest=8.0)
    assert result.reference == "outcrop of the half-space below base"
    outcrop = 2 * history.incoming_acceleration.sel(boundary="base", axis="x").values
    bins, spectrum = sitedda.fourier_spectrum(outcrop, 2e-3, padding=5)
    below, above = (smooth_konno_ohmachi(bins, abs(spectrum) * ratio, 40.0, result.frequency)
                    for ratio in (1.0, outcrop_ratio(bins)))  # fmt: skip
    np.testing.assert_allclose(result.amplification[1], above / below, rtol=0.02)
    np.testing.assert_allclose(result.aggravation, 1.0, rtol=0.03)  # no two-dimensional effects
    assert result.aggravation_factor == pytest.approx(1.0, rel=0.01)


def test_the_column_has_the_time_step_of_the_run_at_any_sampling_interval():
    """The numerical damping of DDA is proportional to Δt, not to the sampling interval."""
    time = np.arange(0.0, 0.2, 2e-3)
    pulse = np.sin(np.pi * time / 0.2) ** 2 * np.sin(2 * np.pi * time / 0.1)
    model = stack(20, motion=pulse, time_step=2e-3, duration=4.0)
    model.measured_point("edge", 0.0, 20.0)
    history = model.run().history
    band = {"lowest": 1.0, "highest": 8.0}
    full, sampled = (surface(history.isel(time=slice(None, None, n)), **band) for n in (1, 5))
    np.testing.assert_allclose(sampled.aggravation, full.aggravation, rtol=0.03)
    np.testing.assert_allclose(sampled.aggravation, 1.0, rtol=0.05)


@pytest.mark.parametrize(
    ("sides", "values", "message"),
    [
        ("free_field", {"highest": 1e4}, "half of the sampling frequency"),
        ("free_field", {"lowest": 1.0}, "one period in the run"),
        ("none", {}, "no wave enters the model from outside"),
    ],
)
def test_unsuitable_runs_are_refused(sides, values, message):
    history = ground().history
    if sides == "none":
        history = history.drop_vars("boundary_kind")
    with pytest.raises(ValueError, match=message):
        surface(history, **values)


def test_the_command_prints_and_draws_amplification(main, tmp_path):
    model = lattice("free_field", hill=HILL)
    for x in (0.0, 5.0):
        model.measured_point(f"at {x:g}", x, 4.0 if x else 3.0)
    sitedda.run(model.write(tmp_path / "hill.nml"), output=tmp_path / "hill.nc")
    band = ("--lowest", "10", "--highest", "50")
    process = main.ok("surface", tmp_path / "hill.nc", *band, folder=tmp_path)
    for text in ("relative to the surface of free field left", "at 5", "2-D/1-D"):
        assert text in process.stdout
    assert (tmp_path / "hill_surface.png").stat().st_size > 10_000
    process = main("surface", tmp_path / "hill.nc", folder=tmp_path)
    assert process.returncode == 1 and "one period in the run" in process.stderr
