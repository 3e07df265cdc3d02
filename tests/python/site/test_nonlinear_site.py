# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns of nonlinear soil: closed forms, energy, other analyses, errors."""

from dataclasses import replace

import numpy as np
import pytest

from sitedda import Column, HalfSpace, Layer
from sitedda.damping import ConstantRatio, Rayleigh
from sitedda.site import (
    Branches,
    SoilCurves,
    analyses,
    darendeli,
    gqh,
    hyperbolic,
    mkz,
    nonlinear,
)

STEP = 0.005
STRAINS = np.logspace(-5, -2, 61)  # 0.001 to 1 %


def masing_of_hyperbola(x):
    return 2 / np.pi * (2 * (1 + 1 / x) * (1 - np.log1p(x) / x) - 1)


def backbone(reference, masing=True):
    """Return curves of a hyperbola for strains of 1e-7 to 10 %."""
    strain = np.logspace(-7, -1, 301)
    x = strain / reference
    damping = np.where(x < 1e-3, 2 * x / (3 * np.pi), masing_of_hyperbola(x))
    return SoilCurves(strain, 1 / (1 + x), damping if masing else 0 * x)


def sine(frequency, amplitude, step=0.002, duration=6.0):
    time = step * np.arange(round(duration / step) + 1)
    return amplitude * np.minimum(time, 1.0) * np.sin(2 * np.pi * frequency * time)


SOFT = Column([Layer(10.0, density=1900.0, shear_velocity=150.0)])
PRENOLIN = Column([Layer(20.0, density=2000.0, shear_velocity=300.0)])  # its first column
MASING = {"damping_curve": "masing", "branches": 60, "highest_frequency": 50}


def shaken(column, curves, ground, step=0.002, **settings):
    """Return a run without its coarser comparison run."""
    return nonlinear(column, curves, ground, step, compare=False, **settings)


def noise(step, samples, highest, seed=3):
    """Return smooth noise between 0.5 Hz and a highest frequency, with a peak of 1."""
    frequency = np.fft.rfftfreq(samples, step)
    random = np.random.default_rng(seed)
    spectrum = np.exp(2j * np.pi * random.random(frequency.size))
    spectrum[(frequency < 0.5) | (frequency > highest)] = 0
    series = np.fft.irfft(spectrum, samples) * np.sin(np.pi * np.arange(samples) / samples) ** 2
    return series / np.abs(series).max()


@pytest.mark.parametrize(
    ("x", "reduction", "damping"),
    [
        (0.1, 1 / 1.1, 2.0219),
        (0.3, 1 / 1.3, 5.5548),
        (1, 0.5, 14.4775),
        (3, 0.25, 27.6551),
        (10, 1 / 11, 42.8103),
    ],
)
def test_masing_branches_of_a_hyperbola_agree_with_its_closed_form(x, reduction, damping):
    fitted = Branches.of(backbone(1e-3), 60, "masing")
    assert fitted.reduction_at(x * 1e-3) == pytest.approx(reduction, rel=3e-3)
    assert 100 * fitted.damping_at(x * 1e-3) == pytest.approx(damping, abs=0.12)


@pytest.mark.parametrize(
    ("strain", "reduction", "damping"),
    [(1e-4, 0.81841, 3.5994), (1e-3, 0.41667, 14.7627), (1e-2, 0.10169, 31.159)],
)
def test_mkz_has_the_modulus_and_the_damping_of_masing(strain, reduction, damping):
    curves = mkz(1e-3, beta=1.4, power=0.8)
    assert curves.reduction_at(strain) == pytest.approx(reduction, abs=2e-4)
    assert 100 * curves.damping_at(strain) == pytest.approx(damping, abs=0.02)


def test_gqh_is_a_hyperbola_at_theta_0_and_reaches_its_strength_earlier_at_theta_1():
    hyperbola = gqh(1e-3, [0, 0, 1, 1, 1])
    assert hyperbola.reduction == pytest.approx(1 / (1 + hyperbola.strain / 1e-3))
    assert hyperbola.damping_at(1e-3) == pytest.approx(masing_of_hyperbola(1.0), abs=1e-4)
    bilinear = gqh(1e-3, [1, 0, 1, 1, 1])
    assert bilinear.reduction_at(0.5e-3) == pytest.approx(1.0, abs=1e-6)
    assert bilinear.reduction_at(1e-2) == pytest.approx(0.1, rel=2e-2)
    with pytest.raises(ValueError, match="theta gives θ = 1.1 at a strain of"):
        gqh(1e-3, [1.1, 0, 1, 1, 1])


@pytest.mark.parametrize("plasticity", [0, 15, 30, 100])
@pytest.mark.parametrize("stress", [25e3, 101325, 400e3])
def test_branches_fit_modulus_and_damping_of_darendeli(plasticity, stress):
    curves = darendeli(stress, plasticity)
    fitted = Branches.of(curves)
    modulus = fitted.reduction_at(STRAINS) / curves.reduction_at(STRAINS)
    # A material with a damping of 3 % or more at small strains (PI 100, 25 kPa) has a kink in G.
    kink = 2.0 if fitted.least_damping > 0.03 else 1.0
    assert modulus == pytest.approx(1, abs=0.008 * kink)
    damping = curves.damping_at(STRAINS)
    assert fitted.damping_at(STRAINS) == pytest.approx(damping, abs=0.003)
    assert np.abs(fitted.damping_at(STRAINS) - damping).max() - 1e-6 < fitted.misfit[1] < 0.003
    assert np.all((fitted.slipping >= 0) & (fitted.slipping <= 1))


def test_a_poor_fit_of_the_damping_curve_is_reported():
    """A damping of 5 % at small strains requires a quarter of the modulus, which slips at once."""
    for plasticity, is_reported in ((200.0, True), (100.0, False)):
        report = str(shaken(SOFT, [darendeli(25e3, plasticity)], sine(1.0, 0.1, duration=1.0)))
        assert ("the damping curve is not fitted" in report) == is_reported


def test_more_branches_fit_better():
    misfits = [Branches.of(backbone(1e-3), n).misfit for n in (10, 20, 40)]
    assert misfits[0] > misfits[1] > misfits[2]
    assert misfits[2][0] < 0.005


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
def test_a_simple_wave_in_a_hyperbola_is_exact(speed):
    """Half-space under v(t): x = e^{v/(c₀γ_r)} − 1, each strain travels at c₀/(1 + x)."""
    c0, reference, rise, step = 200.0, 1e-3, 0.04, 5e-4
    time = step * np.arange(701)
    pushed = np.where(time < rise, speed / rise * (1 - np.cos(2 * np.pi * time / rise)), 0.0)
    column = Column([Layer(80.0, density=2000.0, shear_velocity=c0)])
    settings = MASING | {"branches": 100, "highest_frequency": 100.0}
    run = shaken(column, [backbone(reference)], pushed, step, **settings)
    fine = np.linspace(0, rise, 2001)
    velocity = speed * (fine / rise - np.sin(2 * np.pi * fine / rise) / (2 * np.pi))
    x = np.expm1(velocity / (c0 * reference))
    cells = run.histories.strain.shape[0]
    height = 80.0 / cells * 0.5 + 20.0  # m, centre of a cell above the base
    arrival = fine + height * (1 + x) / c0
    strain = run.strain(80.0 - height) / reference
    assert strain.max() == pytest.approx(x[-1], rel=5e-3)
    exact = np.interp(time, arrival, x, left=0.0)
    # before reflections from the surface arrive
    unreflected = time < min(0.34, (60 + 60 - 20) / c0)
    assert np.abs(np.abs(strain) - exact)[unreflected].max() < 0.03 * x[-1]


def test_small_strains_agree_with_the_transfer_function():
    """Small motions in soil, and all motions in linear layers, agree with the linear column."""
    base = HalfSpace(density=2400.0, shear_velocity=900.0)
    ground = noise(0.002, 8000, 10.0)
    layers = [Layer(6.0, density=1900.0, shear_velocity=v) for v in (200.0, 300.0)]
    damped = Column([replace(layer, damping=ConstantRatio(0.02)) for layer in layers], base)
    response = damped.response(ground, 0.002)
    exact = response.acceleration()
    curves = SoilCurves(*np.array([[1e-6, 1, 0.02], [1e-3, 0.5, 0.1], [1e-1, 0.01, 0.3]]).T)
    soil_run = shaken(Column(layers, base), [curves] * 2, 1e-7 * ground)
    linear_run = shaken(damped, [None] * 2, ground)
    for acceleration in (1e7 * soil_run.acceleration(), linear_run.acceleration()):
        assert np.abs(acceleration - exact).max() < 5e-3 * np.abs(exact).max()
    strain = response.strain(3.0)
    assert linear_run.strain(3.0) == pytest.approx(strain, abs=0.01 * strain.max())
    assert linear_run.displacement() == pytest.approx(response.displacement(), abs=2e-4)


@pytest.mark.parametrize("base", ["rigid", HalfSpace(density=2300.0, shear_velocity=700.0)])
@pytest.mark.parametrize("amplitude", [0.1, 3.0])
def test_the_work_at_the_base_balances_the_energies(base, amplitude):
    run = shaken(replace(PRENOLIN, base=base), [darendeli(1e5, 15.0)], sine(2.0, amplitude))
    energy = dict(run.histories.energy)
    work = energy.pop("work")
    assert sum(energy.values()) == pytest.approx(work, rel=1e-9)
    assert energy["slipped"] > 0 and energy["damped"] > 0
    assert np.median(run.histories.iterations) <= 8
    assert run.histories.iterations.max() <= 20


def test_strains_of_a_rigid_base_column_tend_to_published_ones():
    """PRENOLIN's P1 by sem2dpack (nested yield surfaces): 5.95 γ_ref in steady state."""
    run = shaken(PRENOLIN, [backbone(3.65e-4)], sine(2.0, 1.0), **MASING)
    steady_strain = run.histories.strain[-1, -1000:] / 3.65e-4  # last two seconds
    assert (steady_strain.max() - steady_strain.min()) / 2 == pytest.approx(5.95, abs=0.3)


def test_the_start_of_shaking_affects_largest_strains_but_not_loops():
    """PRENOLIN's P1 at 3 m/s²: the inertia is 1.8 times the strength; two ramps at the start."""
    time = 0.002 * np.arange(3001)
    wave = 3.0 * np.sin(4 * np.pi * time)
    ramp = np.minimum(time, 1.0)
    runs = [shaken(PRENOLIN, [hyperbolic(3.65e-4)], form * wave, **MASING)
            for form in (ramp, (1 - np.cos(np.pi * ramp)) / 2)]  # fmt: skip
    strains = [run.histories.strain[-1] / 3.65e-4 for run in runs]
    amplitudes = [np.ptp(strain[2000:]) / 2 for strain in strains]
    assert amplitudes == pytest.approx([9.19, 9.19], rel=0.01)
    largest_strains = [np.abs(strain).max() for strain in strains]
    assert largest_strains[1] > 1.2 * largest_strains[0] > 2.5 * amplitudes[0]


def test_unconverged_peak_accelerations_are_reported():
    curves = [backbone(3.65e-4)]
    strong = nonlinear(PRENOLIN, curves, sine(2.0, 2.0), 0.002, damping_curve="masing")
    assert "pga" in strong.unconverged
    assert "do not converge with cells and steps: surface PGA" in str(strong)
    quiet = nonlinear(PRENOLIN, curves, sine(2.0, 0.01), 0.002, damping_curve="masing")
    assert not quiet.unconverged and "do not converge" not in str(quiet)
    profile = quiet.profile()
    assert profile.acceleration_converged.all() and profile.strain_converged.all()
    without_comparison = shaken(PRENOLIN, curves, sine(2.0, 0.01))
    assert np.isnan(without_comparison.figures["pga"][1])


def test_accelerations_are_limited_to_the_resolved_band():
    """The band of a nonlinear run limits accelerations; unconverged depths are marked."""
    column = Column([Layer(10.0, density=1800.0, shear_velocity=150.0)],
                    HalfSpace(density=2200.0, shear_velocity=760.0))  # fmt: skip
    motion, step = 4 * noise(0.01, 1500, 10, seed=1), 0.01
    run = nonlinear(column, [darendeli(6e4)], motion, step, highest_frequency=12.5)
    frequency = np.fft.rfftfreq(motion.size, step)
    filtered, raw = (np.abs(np.fft.rfft(acceleration)) for acceleration in
                     (run.acceleration(0.0), run.histories.acceleration[0]))  # fmt: skip
    assert filtered[frequency > 25].max() < 0.2 * raw[frequency > 25].max()
    assert np.abs(filtered - raw)[frequency < 6].max() < 0.01 * raw.max()
    profile = run.profile()
    assert profile.acceleration_converged.dtype == bool
    assert profile.strain_converged.sizes == profile.strain.sizes


def test_the_largest_acceleration_over_depth_does_not_grow_with_the_resolution():
    """Undamped nonlinear soil: 4.4, 4.6, 5.6 m/s² as computed, 3.0, 3.0, 3.1 within the band."""
    curves, ground = [backbone(3.65e-4, masing=False)], sine(2.0, 3.0)
    runs = [nonlinear(PRENOLIN, curves, ground, 0.002, damping_curve="masing", highest_frequency=f)
            for f in (12.5, 25.0, 50.0)]  # fmt: skip
    raw = [np.abs(run.histories.acceleration).max() for run in runs]
    peaks = [float(run.profile().acceleration.max()) for run in runs]
    assert max(peaks) < 1.05 * min(peaks) and max(raw) > 1.2 * min(raw)
    assert "peak accelerations do not converge at" in str(runs[1])


def test_three_analyses_agree_for_small_strains_only(record, tmp_path):
    column = Column(
        [Layer(5.0, density=1850.0, shear_velocity=v) for v in (180.0, 230.0, 280.0, 330.0)],
        HalfSpace(density=2200.0, shear_velocity=800.0),
    )
    curves = [darendeli(s, 15.0) for s in (25e3, 75e3, 125e3, 175e3)]
    weak = analyses(column, curves, 0.01 * record.acceleration.values, STEP, compare=False)
    periods = [0.2, 0.5, 1.0]
    linear, fitted, yielding = (r.spectrum(periods) for r in weak.responses.values())
    assert fitted == pytest.approx(linear, rel=0.05)
    assert yielding == pytest.approx(fitted, rel=0.05)
    strong = analyses(column, curves, 2 * record.acceleration.values, STEP)
    assert strong.nonlinear.histories.strain.max() > 1e-3
    assert str(strong).startswith("outcrop motion") and "largest shear strain" in str(strong)
    (row,) = (line for line in str(strong).splitlines() if line.startswith("largest shear strain"))
    strains = [100 * response.largest[0] for response in strong.responses.values()]
    assert [float(cell) for cell in row.split()[3:6]] == pytest.approx(strains, rel=1e-3)
    picture = strong.plot()
    picture.savefig(tmp_path / "three.png")
    spectra = picture.axes[0]  # spectra are not cut off
    assert spectra.get_ylim()[1] > max(line.get_ydata().max() for line in spectra.lines)
    strong.nonlinear.plot().savefig(tmp_path / "nonlinear.png")


def test_strains_beyond_the_curves_are_reported():
    strong = shaken(SOFT, [darendeli(2e4)], sine(1.0, 6.0))
    assert list(strong.beyond_curves) == [1]
    assert "strains exceed the curves, so the soil flows: layer 1" in str(strong)
    weak = shaken(SOFT, [darendeli(2e4)], sine(1.0, 0.1))
    assert not weak.beyond_curves and "exceed the curves" not in str(weak)


def test_ignored_damping_of_the_half_space_is_reported():
    for damping, is_reported in ((0.02, True), (0.0, False)):
        base = HalfSpace(density=2200.0, shear_velocity=800.0, damping=damping)
        run = shaken(replace(SOFT, base=base), [darendeli(2e4)], sine(1.0, 0.1))
        assert ("the damping of the half-space is ignored" in str(run)) == is_reported


def test_largest_strains_include_all_steps():
    """A sample of the motion has 25 steps here; the largest strain lies between two samples."""
    coarse = sine(1.0, 1.0, step=0.025, duration=3.0)
    interpolated = np.interp(np.arange(3001) / 25, np.arange(coarse.size), coarse)
    histories = shaken(SOFT, [darendeli(5e4)], coarse, 0.025).histories
    fine = shaken(SOFT, [darendeli(5e4)], interpolated, 0.001).histories
    assert histories.largest_strain == pytest.approx(np.abs(fine.strain).max(axis=1), rel=1e-9)
    assert histories.largest_stress == pytest.approx(np.abs(fine.stress).max(axis=1), rel=1e-9)
    assert np.all(histories.largest_strain >= np.abs(histories.strain).max(axis=1))
    assert histories.largest_strain[-1] > np.abs(histories.strain[-1]).max()


def test_misfits_are_limited_to_the_range_of_the_curves():
    """A table that ends at 0.1 % does not define larger strains."""
    full = backbone(1e-3)
    selection = full.strain <= 1e-3
    limited = SoilCurves(full.strain[selection], full.reduction[selection], full.damping[selection])
    assert Branches.of(limited).misfit[0] < 0.01


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"curves": []}, "curves: give 1, one per layer, not 0"),
        ({"kind": "up"}, "kind must be one of outcrop, within, got 'up'"),
        ({"branches": 1}, "branches must be in 2 … 200, got 1"),
        ({"damping_curve": "own"}, "damping_curve must be one of target, masing, got 'own'"),
        ({"highest_frequency": 0.0}, "highest_frequency must be finite and positive"),
        ({"highest_frequency": 1e6}, "values: lower highest_frequency, or shorten the motion"),
        (
            {"column": Column([replace(SOFT.layers[0], damping=Rayleigh.at(0.02, (1.0, 10.0)))])},
            "the damping of layer 1 depends on frequency",
        ),
    ],
)
def test_invalid_arguments_are_reported(changes, message):
    arguments = {"column": SOFT, "curves": [hyperbolic(1e-3)]} | changes
    with pytest.raises(ValueError, match=message):
        nonlinear(motion=sine(1.0, 1.0), time_step=0.002, **arguments)
