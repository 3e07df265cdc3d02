# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns under motions: closed forms, pystrata, and comparison with blocks."""

import re
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_nonlinear_site import noise

import sitedda
from sitedda import Column, HalfSpace, InputError, Layer
from sitedda.signals import spectral_acceleration
from sitedda.site import (
    SoilCurves,
    analyses,
    beside,
    darendeli,
    equivalent_linear,
    hyperbolic,
    intensity,
    nonlinear,
    read_profile,
)

STEP = 0.005


def sweep(samples=2000):
    """Return a motion with all frequencies up to 20 Hz, at rest at both ends."""
    time = STEP * np.arange(samples)
    window = np.sin(np.pi * time / time[-1]) ** 2
    return window * np.sin(2 * np.pi * (0.5 + time) * time)


def ricker(frequency=4.0, samples=4000, delay=1.0, step=STEP):
    argument = (np.pi * frequency * (step * np.arange(samples) - delay)) ** 2
    return (1 - 2 * argument) * np.exp(-argument)


ROCK = HalfSpace(density=2200.0, shear_velocity=800.0)
UNDAMPED = Layer(30.0, density=1800.0, shear_velocity=150.0, damping=0.0)


def test_soil_like_its_half_space_only_delays_the_outcrop():
    """The motion at the surface is that of the outcrop, delayed by the travel time."""
    column = Column([Layer(80.0, density=2200.0, shear_velocity=800.0)], ROCK)
    pulse = ricker()
    surface_acceleration = column.response(pulse, STEP).acceleration()
    shift = round(80.0 / 800.0 / STEP)
    assert surface_acceleration[shift:] == pytest.approx(pulse[:-shift], abs=1e-9)


def test_a_within_motion_is_the_sum_of_both_waves():
    """Upgoing v and downgoing v of a uniform half-space at depth h: v(t) + v(t − 2h/V)."""
    column = Column([Layer(80.0, density=2200.0, shear_velocity=800.0)], ROCK)
    pulse = ricker()
    base_acceleration = column.response(pulse, STEP).acceleration(80.0)
    shift = round(2 * 80.0 / 800.0 / STEP)
    expected = pulse / 2
    expected[shift:] += pulse[:-shift] / 2
    assert base_acceleration == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("base", "kind"), [("rigid", "outcrop"), (ROCK, "within"), (ROCK, "outcrop")]
)
@pytest.mark.parametrize("stiff", [(150.0, 0.01), (300.0, 0.0)])  # m/s, damping ratio
def test_long_free_vibration_does_not_wrap_around(base, kind, stiff):
    """One layer has little damping; additional zeros after the motion change nothing."""
    soil = Layer(15.0, density=1800.0, shear_velocity=150.0, damping=0.01)
    below = Layer(15.0, density=1800.0, shear_velocity=stiff[0], damping=stiff[1])
    column = Column([soil, below], base)
    pulse = ricker(2.0, 1000, 1.5)
    extended_pulse = np.append(pulse, np.zeros(20 * pulse.size))
    exact = column.response(extended_pulse, STEP, kind=kind).acceleration()[: pulse.size]
    acceleration = column.response(pulse, STEP, kind=kind).acceleration()
    assert acceleration == pytest.approx(exact, abs=2e-3 * abs(exact).max())


def test_endless_free_vibration_is_reported():
    """Without damping the motion on a rigid base never ends; a half-space absorbs the waves."""
    with pytest.warns(UserWarning, match="more than 1 % of the free vibration remains"):
        Column([replace(UNDAMPED, damping=1e-5)]).response(ricker(), STEP).acceleration()
    with pytest.raises(ValueError, match="unbounded: soils without damping on a rigid base"):
        Column([UNDAMPED]).response(ricker(), STEP).acceleration()
    with pytest.raises(ValueError, match="soils without damping above a base with a within motion"):
        Column([UNDAMPED], ROCK).response(ricker(), STEP, kind="within").acceleration()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Column([UNDAMPED], ROCK).response(ricker(), STEP)


@pytest.mark.parametrize("quantity", ["velocity", "displacement", "strain", "stress"])
def test_no_quantity_of_an_unbounded_motion_is_returned(quantity):
    response = Column([UNDAMPED]).response(ricker(), STEP)
    with pytest.raises(InputError, match="motion of the column is unbounded"):
        getattr(response, quantity)(15.0)


def test_arguments_of_a_response_are_checked():
    response = Column([replace(UNDAMPED, damping=0.05)], ROCK).response(ricker(), STEP)
    for depth in ("deep", 31.0, [1.0, -1.0]):
        with pytest.raises(InputError, match="depth must"):
            response.acceleration(depth)
    with pytest.raises(InputError, match="frequencies must"):
        response.transfer([1.0, -1.0])
    assert response.transfer(1.0) == response.transfer([1.0])[0]
    assert response.strain([]).shape == (0, response.time.size)


@pytest.mark.filterwarnings("ignore:more than 1 % of the free vibration")
def test_damping_at_frequencies_other_than_1_hz_bounds_the_motion():
    """The natural frequencies, 2 Hz and above, are damped; 1 Hz is not."""

    def ratio(frequency):
        return np.where(np.asarray(frequency) > 1.5, 0.05, 0.0)

    soil = Layer(30.0, density=1800.0, shear_velocity=240.0, damping=ratio)
    damped = Column([replace(soil, damping=0.05)]).response(ricker(), STEP)
    response = Column([soil]).response(ricker(), STEP)
    assert response.unbounded == ""
    expected = damped.acceleration()
    assert response.acceleration() == pytest.approx(expected, abs=0.05 * np.abs(expected).max())


def test_analyses_omit_each_unbounded_column():
    """Linear soil without damping on a rigid base: only the nonlinear analysis has a result."""
    comparison = analyses(Column([UNDAMPED]), [None], ricker(), STEP)
    assert list(comparison.responses) == ["nonlinear"]
    text = str(comparison)
    for name in ("linear", "equivalent-linear"):
        assert f"the {name} column is omitted: soils without damping on a rigid base" in text
    assert "% strain" not in text
    comparison.plot()


@pytest.mark.parametrize("depth", [0.0, 3.7, 12.0, 20.0])
def test_strain_and_stress_follow_from_the_motion(depth):
    """The stress at depth z is the inertia above, τ = ∫ρ a dz, from motions at many depths."""
    layers = [
        Layer(8.0, density=1800.0, shear_velocity=200.0, damping=0.03),
        Layer(12.0, density=2000.0, shear_velocity=320.0, damping=0.02),
    ]
    response = Column(layers, ROCK).response(sweep(), STEP)
    stress = response.stress(depth)
    total = np.zeros_like(stress)
    edge = min(depth, 8.0)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    for top, bottom, density in ((0.0, edge, 1800.0), (edge, depth, 2000.0)):
        half = (bottom - top) / 2
        for node, weight in zip(nodes, weights, strict=True):
            if half > 0:
                total += half * weight * density * response.acceleration(top + half * (1 + node))
    assert stress == pytest.approx(total, abs=2e-5 * max(1.0, abs(total).max()))


def test_velocity_and_displacement_are_integrals_of_the_acceleration():
    column = Column([Layer(20.0, density=1800.0, shear_velocity=200.0, damping=0.05)])
    response = column.response(sweep(), STEP)
    relative = response.acceleration() - response.motion.acceleration
    second = np.gradient(np.gradient(response.displacement(), STEP), STEP)
    low = slice(20, 900)  # below 5 Hz, where finite differences are accurate
    assert second[low] == pytest.approx(relative[low], abs=0.02 * abs(relative).max())
    assert response.displacement(20.0) == pytest.approx(0.0, abs=1e-15)
    change = np.gradient(response.velocity(), STEP)[low]
    assert change == pytest.approx(response.acceleration()[low], abs=0.02 * abs(relative).max())


def test_the_profile_has_the_peaks_of_the_histories():
    layers = [Layer(h, density=1900.0, shear_velocity=v, damping=0.02)
              for h, v in ((5.0, 180.0), (9.0, 300.0))]  # fmt: skip
    response = Column(layers, ROCK).response(sweep(), STEP)
    profile = response.profile()
    assert list(profile.depth) == [0.0, 5.0, 14.0] and list(profile.middle) == [2.5, 9.5]
    for at, depth in enumerate((0.0, 5.0, 14.0)):
        assert profile.acceleration[at] == pytest.approx(abs(response.acceleration(depth)).max())
    assert profile.strain[1] == pytest.approx(abs(response.strain(9.5)).max())
    stress = 1900.0 * 180.0**2 * float(profile.strain[0])
    assert float(profile.stress[0]) == pytest.approx(stress, rel=2e-3)


def test_largest_strain_and_stress_are_those_of_all_depths():
    """A slow motion shakes a layer as a rigid body: τ = ρ a z, largest at its bottom."""
    layers = [Layer(h, density=1900.0, shear_velocity=v, damping=0.02)
              for h, v in ((20.0, 180.0), (5.0, 300.0))]  # fmt: skip
    slow = ricker(0.1, 4000, 20.0, 0.01)
    strain, stress = Column(layers).response(slow, 0.01).largest
    assert stress == pytest.approx(1900.0 * 25.0, rel=0.02)
    assert strain == pytest.approx(1900.0 * 20.0 / (1900.0 * 180.0**2), rel=0.02)
    fast = Column(layers, ROCK).response(sweep(), STEP)
    fine = np.linspace(0.1, 24.9, 100)
    expected = abs(fast.strain(fine)).max(), abs(fast.stress(fine)).max()
    assert fast.largest == pytest.approx(expected, rel=0.03)


def test_a_layer_of_more_than_a_fifth_of_a_wavelength_is_reported(record):
    def fit(parts):
        layer = Layer(20.0 / parts, density=1800.0, shear_velocity=150.0)
        curves = [darendeli(1.2e5, 15.0)] * parts
        return equivalent_linear(
            Column([layer] * parts, ROCK), curves, 0.2 * record.acceleration.values, STEP
        )

    doubt = str(fit(1)).splitlines()[-1]
    assert doubt.startswith("layer 1 is 20 m thick, 0.") and doubt.endswith("are below 0.2")
    assert not fit(4).doubt


PROFILES = 6
BED = HalfSpace(density=2200.0, shear_velocity=900.0, damping=0.01)
STRENGTHS = (0.05, 0.4, 1.5, 5.0)  # m/s², peaks of motions; strains are 0.0004 % to 2.7 %


def outcrops(record):
    """Return four motions of peak 1 with their steps: part of a record, pulse, sweep, and noise."""
    parts = (record.acceleration.values[400:2400], ricker(2.0, 2000, 1.5), sweep(),
             noise(STEP, 2000, 12.0))  # fmt: skip
    step = float(record.time[1] - record.time[0])
    return [(p / abs(p).max(), step if i == 0 else STEP) for i, p in enumerate(parts)]


def soil_profile(seed):
    """Return a column of 4 to 9 layers, and their curves."""
    rng = np.random.default_rng(seed + 10)
    count = 4 + seed
    thickness = rng.uniform(1.5, 6.0, count)
    velocity = np.sort(rng.uniform(120.0, 450.0, count))
    density = rng.uniform(1700.0, 2100.0, count)
    if seed % 2:
        curves = [hyperbolic(1e-3 * (1 + i / 3), 0.92, 0.01) for i in range(count)]
    else:
        middles = np.cumsum(thickness) - thickness / 2
        curves = [darendeli(1e3 + 12e3 * z, 10.0 * (seed + 1)) for z in middles]
    rows = zip(thickness, velocity, density, strict=True)
    return Column([Layer(h, density=rho, shear_velocity=v) for h, v, rho in rows], BED), curves


def by_pystrata(ground, acceleration, step, samples):
    """Return G/G_max, damping ratios and surface acceleration (m/s²) by pystrata."""
    pystrata, gravity = pytest.importorskip("pystrata"), 9.80665
    motion = pystrata.motion.TimeSeriesMotion("", "", step, acceleration / gravity, 2 * samples)
    calculator = pystrata.propagation.EquivalentLinearCalculator(
        tolerance=1e-7, max_iterations=1000, strain_limit=None)  # fmt: skip
    outcrop, surface = ground.location("outcrop", index=-1), ground.location("within", depth=0.0)
    calculator(motion, ground, outcrop)
    assert max(ground.max_error) < 1e-7
    above = motion.calc_time_series(calculator.calc_accel_tf(outcrop, surface))
    reduction, damping = np.array([[np.ravel(layer.shear_mod_reduc)[0], np.ravel(layer.damping)[0]]
                                   for layer in list(ground)[:-1]], dtype=float).T  # fmt: skip
    return reduction, damping, gravity * above[:samples]


def test_equivalent_linear_results_agree_with_pystrata(record, strata_profile):
    """With default settings G agrees within 0.2 %, Sa within 0.5 %, for strains of 0.001 to 1 %."""
    periods = np.geomspace(0.05, 3.0, 12)
    strains = []
    for seed in range(PROFILES):
        column, curves = soil_profile(seed)
        for number, (shape, step) in enumerate(outcrops(record)):
            motion = STRENGTHS[(seed + seed // 2 + number) % len(STRENGTHS)] * shape
            fitted = equivalent_linear(column, curves, motion, step)
            ground = strata_profile(column.layers, BED, curves)
            reduction, damping, surface = by_pystrata(ground, motion, step, motion.size)
            assert fitted.reduction == pytest.approx(reduction, rel=2e-3)
            assert fitted.damping == pytest.approx(damping, rel=2e-3)
            expected = spectral_acceleration(surface, step, periods)
            assert fitted.response.spectrum(periods) == pytest.approx(expected, rel=5e-3)
            strains.append(fitted.strain.max())
    assert min(strains) < 2e-5 and max(strains) > 8e-3
    assert re.search(r"\d+ iterations.*\n.*'dormieux', \|G\*\| = G", str(fitted))


def test_curves_of_darendeli_are_those_of_pystrata():
    pystrata = pytest.importorskip("pystrata")
    for stress, plasticity in ((19e3, 15.0), (200e3, 0.0), (80e3, 60.0)):
        curves = darendeli(stress, plasticity)
        settings = (18.0, plasticity, 1.0, stress / 1e3)
        soil = pystrata.site.DarendeliSoilType(*settings, strains=curves.strain)
        assert curves.reduction == pytest.approx(soil.mod_reduc.values, rel=1e-6)
        assert curves.damping == pytest.approx(soil.damping.values, rel=1e-3)


def test_too_large_damping_for_a_convention_is_an_error():
    """Masing damping tends to 2/π; 'dormieux' has no modulus above ½, 'shake91' has one up to 1."""
    layers = [Layer(10.0, density=1800.0, shear_velocity=120.0)]
    curves, strong = [hyperbolic(2e-4)], 40.0 * ricker(2.0, 2000, 1.5)
    with pytest.raises(ValueError, match=r"layer 1 has a damping ratio of 0\.5\d+ .*'shake91'"):
        equivalent_linear(Column(layers, ROCK), curves, strong, STEP)
    shake91 = equivalent_linear(Column(layers, ROCK, "shake91"), curves, strong, STEP)
    assert shake91.damping[0] > 0.5
    weak = equivalent_linear(Column(layers, ROCK), curves, 0.01 * strong, STEP)
    assert weak.damping[0] < 0.5


def test_small_motion_is_linear(record):
    """For vanishing strain the result is that of the column with the smallest damping."""
    layers = [Layer(10.0, density=1800.0, shear_velocity=250.0)]
    curves = darendeli(100e3, 0.0)
    fitted = equivalent_linear(Column(layers, ROCK), [curves], 1e-7 * sweep(), STEP)
    assert fitted.reduction == pytest.approx([1.0], abs=1e-2)
    assert fitted.damping == pytest.approx([curves.damping[0]], rel=1e-2)


def test_hyperbola_has_masings_damping():
    """At γ = γ_r, G/Gmax is ½ and the damping (2/π)(2(1 − ln 2)·2 − 1)."""
    curves = hyperbolic(1e-3)
    assert curves.reduction_at(1e-3) == pytest.approx(0.5)
    assert curves.damping_at(1e-3) == pytest.approx((8 * (1 - np.log(2)) - 2) / np.pi, rel=1e-3)


def test_damping_of_the_time_integration(record):
    """With the damping of the time integration, the response is that of `scheme_transfer`."""
    from sitedda.scheme import Scheme

    column = Column([Layer(15.0, density=2643.0, shear_modulus=1.9152e9)])
    response = column.response(sweep(), STEP, kind="within", scheme=Scheme())
    frequencies = np.array([1.0, 5.0, 13.0, 20.0])
    expected = column.scheme_transfer(frequencies, STEP)
    assert response.transfer(frequencies) == pytest.approx(expected, rel=1e-12)


def test_intensity_of_a_sine():
    """Closed forms of a sine: Arias A²T/2, duration 0.9 T, mean period, CAV 2AT/π."""
    time = STEP * np.arange(4001)
    measures = intensity(3.0 * np.sin(2 * np.pi * 2.0 * time), STEP)
    assert measures.peak_acceleration == pytest.approx(3.0)
    assert measures.arias == pytest.approx(np.pi / (2 * 9.80665) * 9.0 * 20.0 / 2, rel=1e-4)
    assert measures.duration == pytest.approx(0.9 * 20.0, rel=1e-2)
    assert measures.mean_period == pytest.approx(0.5, rel=1e-2)
    assert measures.cumulative_velocity == pytest.approx(2 * 3.0 * 20.0 / np.pi, rel=1e-3)
    assert "D5–95" in str(measures)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c: c.response([1.0], STEP), "2 or more samples"),
        (lambda c: c.response([1.0, np.nan], STEP), "sample 1"),
        (lambda c: c.response([1.0, 2.0]), "time_step"),
        (lambda c: c.response([1.0, 2.0], -1.0), "time_step"),
        (lambda c: c.response([1.0, 2.0], STEP, kind="inside"), "outcrop, within"),
        (lambda c: c.response([1.0, 2.0], STEP, bottom=99.0), "depth"),
        (lambda c: equivalent_linear(c, [], sweep(), STEP), "curves"),
        (lambda c: equivalent_linear(c, [None], sweep(), STEP, strain_ratio=2.0), "strain_ratio"),
        (lambda c: SoilCurves([1e-4, 1e-5], [1, 1], [0, 0]), "increasing"),
        (lambda c: SoilCurves([1e-5, 1e-4], [1, 1.5], [0, 0]), "reduction"),
        (lambda c: SoilCurves([1e-5, 1e-4], [1, 1], [0, 5.0]), "damping"),
        (lambda c: darendeli(-1.0), "mean_stress"),
        (lambda c: intensity(np.zeros(5), STEP), "no acceleration"),
    ],
)
def test_invalid_arguments_are_reported(call, message):
    column = Column([Layer(15.0, density=2000.0, shear_velocity=200.0, damping=0.05)])
    with pytest.raises(ValueError, match=message):
        call(column)


def test_curves_of_a_soil_type_of_pystrata():
    """Both properties are given at the strains of either curve, by interpolation in log strain."""
    reduction = SimpleNamespace(strains=[1e-6, 1e-4], values=[1.0, 0.5])
    damping = SimpleNamespace(strains=[1e-6, 1e-5, 1e-4], values=[0.01, 0.02, 0.06])
    soil = SimpleNamespace(name="sand", mod_reduc=reduction, damping=damping)
    curves = SoilCurves.from_pystrata(soil)
    assert curves.strain == pytest.approx([1e-6, 1e-5, 1e-4])
    assert curves.reduction == pytest.approx([1.0, 0.75, 0.5])
    assert curves.damping == pytest.approx([0.01, 0.02, 0.06])


def test_an_unconverged_iteration_is_an_error(record):
    layers = [Layer(20.0, density=1800.0, shear_velocity=120.0)]
    curves = [darendeli(50e3, 0.0)]
    with pytest.raises(sitedda.ConvergenceError, match="1 iterations"):
        equivalent_linear(Column(layers), curves, record, tolerance=1e-9, most_iterations=1)


def test_blocks_and_column_in_one_picture(root, tmp_path, python_program):
    """`sitedda site` compares both for the paper's layers, in table and picture."""
    text = (root / "inputs/layered_site.nml").read_text()
    text = text.replace("records/", f"{root}/inputs/records/")
    text = re.sub(r"steps = \d+", "steps = 12000", text)
    (tmp_path / "site.nml").write_text(text)
    process = python_program.ok("site", "site.nml", "-o", "both.png", folder=tmp_path)
    assert (tmp_path / "both.png").stat().st_size > 20_000
    rows = re.findall(r"^(surface .*?)\s{2,}([\d.e+-]+)\s+([\d.e+-]+)", process.stdout, re.M)
    assert len(rows) >= 5
    for name, blocks, column in rows:
        assert float(blocks) == pytest.approx(float(column), rel=0.05), name
    damped = python_program("site", "layered_site.nc", "--damping", "0.05", folder=tmp_path)
    assert damped.returncode == 0 and "damping ratio 5 %" in damped.stdout
    endless = python_program("site", "layered_site.nc", "--damping", "0", folder=tmp_path)
    assert endless.returncode == 1 and "motion of the column is unbounded" in endless.stderr
    assert "Traceback" not in endless.stderr
    with pytest.raises(ValueError, match="motion of the column is unbounded"):
        beside(sitedda.open_output(tmp_path / "layered_site.nc"), damping=0.0)
    wrong = python_program("site", "layered_site.nc", "--base", "nowhere", folder=tmp_path)
    assert wrong.returncode == 1 and "--base" in wrong.stderr and "surface" in wrong.stderr


DAMPED = {
    "none": {},
    "constant ratio": {"damping_ratio": 0.05, "reference_frequency": 14.0},
    "Rayleigh": {"damping_ratio": 0.05, "rayleigh_frequencies": (5.0, 14.0)},
    "alpha and beta": {"rayleigh_alpha": 3.0, "rayleigh_beta": 1e-3},
}


@pytest.mark.filterwarnings("ignore::sitedda.PeakWarning")
@pytest.mark.parametrize("damping", DAMPED)
def test_blocks_and_column_in_python(root, damping):
    """Joints make the blocks slightly softer; damping of materials acts in the column too."""
    material = {f"material.{name}": value for name, value in DAMPED[damping].items()}
    run = sitedda.run(root / "inputs/layered_site.nml", steps=6000, changes=material)
    comparison = beside(run.history)
    assert ("and the materials" in str(comparison)) == bool(material)
    assert comparison.response.column.depth == pytest.approx(15.0)
    peak = abs(comparison.surface).max()
    assert abs(comparison.column_surface).max() == pytest.approx(peak, rel=0.05)
    spectra = [spectral_acceleration(series, 1e-3, [0.2, 0.5, 1.0, 2.0])
               for series in (comparison.surface, comparison.column_surface)]  # fmt: skip
    assert spectra[0] == pytest.approx(spectra[1], rel=0.012)
    sampled = beside(run.history.isel(time=slice(None, None, 4)))  # every fourth step
    peaks = [abs(analysis.column_surface).max() for analysis in (sampled, comparison)]
    assert peaks[0] == pytest.approx(peaks[1], rel=0.005)  # 3 % with Δt = 4 ms in the column


def test_p_waves_with_twice_the_velocity_have_twice_the_frequencies(tmp_path):
    """Poisson's ratio 1/3 yields V_p = 2 V_s."""
    file = tmp_path / "site.csv"
    head = "thickness (m), Vs (m/s), density (kg/m3), damping (%)"
    rows = ["8, 200, 1800, 3", ", 600, 2200, 1"]
    file.write_text("\n".join([f"{head}, nu", *(f"{row}, {1 / 3!r}" for row in rows)]))
    profile, frequency = read_profile(file), np.linspace(0.5, 20.0, 60)
    slow, fast = profile.column(), profile.column(waves="P")
    at_half = slow.transfer(frequency / 2, kind="outcrop")
    np.testing.assert_allclose(fast.transfer(frequency, kind="outcrop"), at_half, rtol=1e-9)
    assert fast.peak(kind="outcrop").frequency == pytest.approx(400 / 32, rel=0.02)
    curves, motion = [darendeli(1e5)], ricker()
    for analysis in (equivalent_linear, nonlinear):
        with pytest.raises(InputError, match="shear do not apply to a column of P waves"):
            analysis(fast, curves, motion, STEP)
    assert np.all(equivalent_linear(fast, [None], motion, STEP).reduction == 1)
    file.write_text("\n".join([head, *rows]))
    with pytest.raises(InputError, match="row 3: a column of P waves needs Vp or nu"):
        read_profile(file).column(waves="P")


def test_two_equivalent_linear_solutions_are_reported():
    """Stiff soil follows a slow pulse, soft soil resonates; between them, both are solutions."""
    pulse = ricker(0.3, 2048, 6.0, 0.02)
    column = Column([Layer(3.0, density=1800.0, shear_velocity=150.0)] * 5,
                    HalfSpace(density=2200.0, shear_velocity=760.0))  # fmt: skip
    curves = [darendeli(mean_stress=1e5, plasticity_index=15.0)] * 5
    assert not equivalent_linear(column, curves, 0.1 * pulse, 0.02).doubt
    ambiguous = equivalent_linear(column, curves, 1.2 * pulse, 0.02, tolerance=1e-6)
    assert ambiguous.largest_strain.max() == pytest.approx(0.0063, rel=0.02)
    assert ambiguous.other_strain == pytest.approx(0.0492, rel=0.02)
    largest_strain = f"{100 * ambiguous.largest_strain.max():.3g} % strain"
    assert f"{largest_strain}: above 0.5 % the equivalent-linear" in str(ambiguous)
    assert "A second solution, of 4.92 % strain, also satisfies the curves" in str(ambiguous)
    unique = equivalent_linear(column, curves, 1.6 * pulse, 0.02, tolerance=1e-6)
    assert unique.doubt and np.isnan(unique.other_strain) and "second solution" not in unique.doubt
