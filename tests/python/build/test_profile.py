# SPDX-License-Identifier: GPL-3.0-or-later
"""A site in a CSV file: reading, conversion to a column and to blocks, command line."""

import math
import re

import numpy as np
import pytest

import sitedda
from sitedda import InputError
from sitedda.signals import spectral_acceleration
from sitedda.site import beside, read_profile

SITE = """# a comment
depth (m), Vs (m/s), Vp (m/s), density (kg/m3), damping (%), curve
0, 150, 1500, 1800, 2, darendeli 15
4, 200, 1500, 1850, 2, hyperbolic 5e-4
10, 280, 1600, 1900, 1.5,
20, 760, 1900, 2200, 0.5, linear
"""


@pytest.fixture
def site(tmp_path):
    """A file with a text; by default three layers on a half-space."""

    def write(text=SITE, name="vs.csv"):
        file = tmp_path / name
        file.write_text(text)
        return file

    return write


def test_a_profile_and_its_mean_velocity(site):
    profile = read_profile(site())
    assert [layer.thickness for layer in profile.layers] == [4, 6, 10]
    assert profile.half_space.shear_velocity == 760
    assert profile.layers[0].damping == pytest.approx(0.02)
    time = 4 / 150 + 6 / 200 + 10 / 280 + 10 / 760
    assert profile.mean_velocity() == pytest.approx(30 / time)
    assert profile.mean_velocity(8.0) == pytest.approx(8 / (4 / 150 + 4 / 200))
    assert f"V_s30 = {30 / time:.4g} m/s" in str(profile)
    assert profile.plot().axes


def test_other_heads_units_and_separators_are_equivalent(site):
    foot, weight = 0.3048, 9.80665e-3
    rows = ["thickness [ft]; v_s (km/s); nu; unit weight (kN/m³); damping (1)"]
    reference = read_profile(site())
    for layer in reference.layers:
        ratio = (layer.pressure_velocity / layer.shear_velocity) ** 2
        nu = (ratio - 2) / (2 * ratio - 2)
        numbers = (layer.thickness / foot, layer.shear_velocity / 1e3, nu, layer.density * weight)
        rows.append("; ".join(f"{n!r}" for n in (*numbers, layer.damping)))
    below = reference.half_space
    ratio = (below.pressure_velocity / below.shear_velocity) ** 2
    nu = (ratio - 2) / (2 * ratio - 2)
    rows.append(f"; 0.76; {nu!r}; {below.density * weight!r}; 0.005")
    other_profile = read_profile(site("\n".join(rows), "other.csv"))
    for layer_pair, theirs in zip(
        (*other_profile.layers, other_profile.half_space), (*reference.layers, below), strict=True
    ):
        for name in ("thickness", "shear_velocity", "pressure_velocity", "density", "damping"):
            assert getattr(layer_pair, name) == pytest.approx(getattr(theirs, name), rel=1e-9), name


def test_bottom_depths_and_a_file_without_half_space(site):
    profile = read_profile(site("depth (m),vs (m/s),density (kg/m3)\n4,150,1800\n10,200,1850\n"))
    assert [layer.thickness for layer in profile.layers] == [4, 6]
    assert profile.half_space is None
    assert profile.column().base == "rigid"
    with pytest.raises(InputError, match="has no half-space"):
        profile.column("half_space")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("depth (m), Vs (m/s), density (kg/m3)\n", "no layers"),
        ("depth, Vs (m/s), density (kg/m3)\n0,1,1\n", "row 1: depth: the unit is missing"),
        ("depth (m), Vs (mph), density (kg/m3)\n0,1,1\n", "unit 'mph' is not known"),
        ("depth (m), speed (m/s)\n0,1\n", "column 'speed' is unknown"),
        ("depth (m), Vs (m/s), density (kg/m3)\n0,fast,1800\n", "row 2: shear_velocity = 'fast'"),
        ("depth (m), Vs (m/s), density (kg/m3)\n4,150,\n", r"density \(kg/m3\) has a gap"),
        ("depth (m), Vs (m/s), density (kg/m3)\n4,-150,1800\n", r"Vs \(m/s\) is -150"),
        ("depth (m), Vs (m/s), density (kg/m3)\n4,150,1800\n3,150,1800\n", "-1 m thick"),
        ("Vs (m/s), density (kg/m3)\n150,1800\n", "give one column of depth"),
        ("depth (m), Vs (m/s), Vp (m/s), density (kg/m3)\n4,150,160,1800\n", "√\\(4/3\\)"),
        ("depth (m), Vs (m/s), density (kg/m3), curve\n4,150,1800,seed 3\n", "curve = 'seed 3'"),
        ("depth (m), Vs (m/s), density (kg/m3), Vs (m/s)\n4,150,1800,1\n", "two columns"),
        ("depth (m), Vs (m/s), density (kg/m3), damping (%)\n4,150,1800,80\n", "damping = 0.8"),
        ("depth (m), Vs (m/s), density (kg/m3)\n4,nan,1800\n", "not a usable number"),
        ("depth (m), Vs (m/s), density (kg/m3)\n2,5,180,1800\n", "row 2: the cell '1800' has no"),
        (
            "depth (m), Vs (m/s), density (kg/m3), curve\n4,150,1800,mkz 5e-4, 1, 0.9\n",
            "the cell '1' has no heading; if a cell contains ',', quote it, or .* decimal points",
        ),
    ],
)
def test_files_that_cannot_be_read(site, text, message):
    with pytest.raises(InputError, match=message):
        read_profile(site(text))


def test_curves_use_the_mean_stress_at_their_depth(site):
    from sitedda.site import darendeli

    dry, wet = (read_profile(site()).curves(*w) for w in ((), (2.0,)))
    assert dry[2] is None
    stress = 2.0 * 1800 * 9.80665 * 2 / 3
    np.testing.assert_allclose(dry[0].reduction, darendeli(stress, 15.0).reduction)
    middle = (4 * 1800 + 3 * 1850) * 9.80665
    assert dry[1].reduction_at(5e-4) == pytest.approx(0.5, rel=1e-3)
    assert middle > stress
    np.testing.assert_allclose(wet[0].reduction, dry[0].reduction)  # at the water table
    table = "strain,reduction,damping\n1e-5,1,0.01\n1e-3,0.5,0.1\n"
    site(table, "clay.csv")
    profile = read_profile(site(SITE.replace("darendeli 15", "clay.csv"), "b.csv")).curves()
    np.testing.assert_allclose(profile[0].reduction, [1, 0.5])


@pytest.mark.parametrize(
    ("heads", "factor"),
    [("strain (%), G/Gmax, damping (%)", 100), ("strain %,G/Gmax (-),D [%]", 100),
     ("strain (1), G/Gmax, D", 1)],
)  # fmt: skip
def test_headings_of_a_curve_file_have_units(site, heads, factor):
    rows = [f"{factor * g},{r},{factor * d}" for g, r, d in ((1e-5, 1, 0.02), (1e-3, 0.5, 0.1))]
    site("\n".join([heads, *rows]), "clay.csv")
    curve = read_profile(site(SITE.replace("darendeli 15", "clay.csv"))).curves()[0]
    np.testing.assert_allclose(curve.strain, [1e-5, 1e-3])
    np.testing.assert_allclose([curve.reduction, curve.damping], [[1, 0.5], [0.02, 0.1]])
    site("strain (mm/m), G/Gmax, D\n1,1,1\n", "clay.csv")
    with pytest.raises(InputError, match=r"row 1: strain .*unit 'mm/m' is not known; use %, 1"):
        read_profile(site(SITE.replace("darendeli 15", "clay.csv"))).curves()


@pytest.mark.parametrize("curve", ["mkz 1e-3 1 0.9", "darendeli 15", "gqh 1e-3 0.3 0.5 1 1 0.9"])
def test_the_damping_ratio_of_a_row_is_that_of_small_strains(site, curve):
    """Weak motions: linear column, linear analysis of curves and nonlinear column agree."""
    from test_site import ricker

    from sitedda.site import analyses

    head = "thickness (m), Vs (m/s), density (kg/m3), damping (%), curve\n"
    profile, plain = (
        read_profile(site(f"{head}20,200,1800,{d},{curve}\n,800,2200,,\n")) for d in (5, 0)
    )
    ratio, formula = profile.curves()[0].damping, plain.curves()[0].damping
    np.testing.assert_allclose(ratio - formula, 0.05 - formula[0])
    weak = 1e-4 * ricker(2.5, 1000, 2.0, 0.01)
    expected = profile.column().response(weak, 0.01).spectrum([0.1, 0.2, 0.4, 1.0])
    result = analyses(profile.column(), profile.curves(), weak, 0.01, compare=False)
    for response, bound in ((result.linear, 2e-3), (result.nonlinear, 0.03)):
        np.testing.assert_allclose(response.spectrum([0.1, 0.2, 0.4, 1.0]), expected, rtol=bound)


def model_of(file, **values) -> sitedda.Model:
    """A model with the layered ground of a file."""
    model = sitedda.Model("site", time_step=1e-4, steps=1, integration="midpoint")
    model.control(analysis="plane_strain")
    model.profile(str(file), **values)
    return model


@pytest.mark.parametrize("columns", [1, 3])
def test_blocks_amplify_as_the_column(site, columns):
    """Surface over outcrop motion, without damping of the materials."""
    lines = SITE.replace(", 2,", ", 0,").replace("1.5,", "0,").replace("0.5,", "0,")
    file = site(lines)
    frequencies = np.linspace(0.5, 8.0, 31)
    exact = abs(read_profile(file).column().transfer(frequencies, kind="outcrop"))
    errors = []
    for highest in (10.0, 20.0):
        model = model_of(file, columns=columns, highest_frequency=highest)
        amplification = abs(sitedda.transfer(model, frequencies, surface="surface", base=None))
        errors.append(np.max(abs(amplification - exact)) / exact.max())
    assert errors[0] < 0.05
    assert errors[1] < 0.4 * errors[0]


def file_of_layers(folder, text):
    """An input and a profile with one layer and no half-space."""
    folder.mkdir()
    head = "thickness (m), Vs (m/s), Vp (m/s), density (kg/m3)"
    (folder / "vs.csv").write_text(f"{head}\n5, 200, 400, 1800\n")
    (folder / "site.nml").write_text(text)
    return folder / "site.nml"


def test_both_programs_run_a_profile_and_compare_its_column(tmp_path, site, binary, same_bits):
    site()
    values = "values = 20*0.0, 1.0, 2.0, 0.0, -2.0, -1.0, 100*0.0"
    text = f"""&control time_step = 2e-3, duration = 4, analysis = 'plane_strain' /
    &motion name = 'quake', quantity = 'acceleration', time_step = 0.02, {values} /
    &profile file = 'vs.csv', motion_x = 'quake', highest_frequency = 25 /
    &amplification lowest = 0.5, highest = 8 /
    """
    file = tmp_path / "site.nml"
    file.write_text(text)
    run = sitedda.run(file, tmp_path / "a.nc")
    assert run.history.point.values.tolist() == ["surface", "depth_4", "depth_10", "base"]
    from sitedda.building import build_file

    built, build_result = build_file(file)
    assert any("curves of vs.csv have no effect" in message for message in build_result.messages)
    assert not any("half-space" in message for message in build_result.messages)
    rigid = build_file(file_of_layers(tmp_path / "rigid", text), tmp_path / "rigid.nml")[1]
    assert any("vs.csv ends without a half-space" in message for message in rigid.messages)
    assert not any("strengths" in message for message in rigid.messages)
    strong = file_of_layers(tmp_path / "strong", text)
    head = "thickness (m), Vs (m/s), Vp (m/s), density (kg/m3), su (kPa)"
    (strong.parent / "vs.csv").write_text(f"{head}\n5, 200, 400, 1800, 60\n")
    messages = build_file(strong, tmp_path / "strong.nml")[1].messages
    assert any("strengths of vs.csv" in message for message in messages)
    binary.ok("run", built, "-o", tmp_path / "b.nc", "-q")
    same_bits(tmp_path / "a.nc", tmp_path / "b.nc")
    comparison = beside(run.history)
    peak = abs(comparison.column_surface).max()
    assert abs(comparison.surface - comparison.column_surface).max() < 0.05 * peak
    second_run = sitedda.Model.read(file).build().run()
    np.testing.assert_array_equal(second_run.history.velocity, run.history.velocity)


@pytest.mark.parametrize("sides", ["tied", "free_field", "roller"])
def test_sides_of_level_ground_move_alike(site, sides):
    model = model_of(site(), columns=4, sides=sides, highest_frequency=8.0, motion_x="quake")
    model.control(duration=0.6, time_step=2e-3)
    model.motion("quake", [0.0, 1.0, -1.0, 0.0], 0.05, "acceleration", drift_order=0)
    acceleration = model.run().history.acceleration.sel(point="surface", axis="x").values
    tied = model_of(site(), sides="tied", highest_frequency=8.0, motion_x="quake")
    tied.control(duration=0.6, time_step=2e-3)
    tied.motion("quake", [0.0, 1.0, -1.0, 0.0], 0.05, "acceleration", drift_order=0)
    expected = tied.run().history.acceleration.sel(point="surface", axis="x").values
    bound = 0.03 if sides == "roller" else 1e-6  # rollers do not keep upright faces straight
    assert abs(acceleration - expected).max() < bound * abs(expected).max()


@pytest.mark.filterwarnings("error::sitedda.PeakWarning")
def test_yielding_layers_agree_with_the_nonlinear_column(site, root):
    """For each kind of curve, at strains at which the linear column is wrong."""
    site("strain,reduction,damping\n1e-6,1,.01\n1e-4,.8,.03\n1e-3,.3,.12\n1e-2,.05,.2\n", "c.csv")
    text = SITE.replace("1.5,", "1.5, c.csv")
    model = model_of(site(text), law="hysteretic", water_table=2.0, highest_frequency=15.0,
                     motion_x="quake")  # fmt: skip
    model.control(duration=10.0, time_step=2e-3)
    record = root / "inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc"
    model.motion("quake", file=str(record), scale=0.3)
    model.amplification(lowest=0.5, highest=8.0)
    comparison = beside(model.run().history)  # without a warning about a linear peak
    periods = [0.1, 0.2, 0.5, 1.0]
    blocks, column, linear = (
        spectral_acceleration(motion, comparison.response.motion.time_step, periods)
        for motion in (
            comparison.surface,
            comparison.column_surface,
            comparison.columns["linear"].acceleration(),
        )
    )
    np.testing.assert_allclose(blocks, column, rtol=0.02)
    assert np.max(abs(linear / column - 1)) > 0.2


def test_curves_become_variables_of_materials(site):
    text = SITE.replace("hyperbolic 5e-4", "mkz 5e-4 1.2 0.9")
    model = model_of(site(text), law="hysteretic", water_table=2.0).build()
    first, second, third, base = model["material"]
    assert (first.curve, first.plasticity_index) == ("darendeli", 15.0)
    assert first.mean_stress == pytest.approx(2.0 * 1800 * 9.80665 * 2 / 3)
    assert (second.curve, second.curve_factor, second.curve_power) == ("mkz", 1.2, 0.9)
    assert third.law is base.law is None
    deep = model_of(site(SITE.replace("1.5,", "1.5, darendeli 0")),
                    law="hysteretic", water_table=2.0, pressure_at_rest=1.0).build()  # fmt: skip
    total = 4 * 1800 + 6 * 1850 + 5 * 1900
    assert deep["material"][2].mean_stress == pytest.approx((total - 13e3) * 9.80665)


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        ("linear", "no layer of .* has a curve"),
        ("hyperbolic", "row 2: curve = 'hyperbolic': give after hyperbolic: ref"),
        ("darendeli 1 2 3 4", "give after darendeli: plasticity_index, ocr, reference_frequency"),
        ("none.csv", "none.csv"),
    ],
)
def test_unsupported_curves_are_refused(site, curve, message):
    text = f"depth (m),vs (m/s),vp (m/s),density (kg/m3),curve\n4,150,400,1800,{curve}\n"
    with pytest.raises(InputError, match=message):
        model_of(site(text), law="hysteretic").build()


def test_a_file_without_half_space_has_a_rigid_base(site):
    text = "depth (m),vs (m/s),vp (m/s),density (kg/m3)\n4,150,400,1800\n"
    model = model_of(site(text), highest_frequency=10.0)
    built = model.build()
    assert [group.kind for group in built["boundary"]] == ["fixed", "tied"]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"base": "compliant"}, "needs a half-space"),
        ({"columns": 0}, "columns"),
        ({"base": "none", "motion_x": "quake"}, "omit motion_x"),
        ({"highest_frequency": 1e7}, "blocks exceed the limit of"),
    ],
)
def test_invalid_ground_is_refused(site, values, message):
    text = "depth (m),vs (m/s),vp (m/s),density (kg/m3)\n4,150,400,1800\n"
    with pytest.raises(InputError, match=message):
        model_of(site(text), **values).build()
    with pytest.raises(InputError, match="row 2: blocks need pressure_velocity"):
        model_of(site(text.replace(",vp (m/s)", "").replace(",400", ""))).build()


def test_the_command_prints_and_draws(tmp_path, site, main, root):
    file = site()
    process = main.ok("site", file)
    assert "V_s30 = " in process.stdout
    assert (tmp_path / "vs_profile.png").stat().st_size > 1e4
    linear = site("\n".join(line.rsplit(",", 1)[0] for line in SITE.splitlines()), "linear.csv")
    record = root / "inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc"
    process = main.ok("site", linear, "--record", record)
    assert "outcrop motion" in process.stdout
    assert (tmp_path / "linear_profile.png").exists()
    (tmp_path / "linear_profile.png").write_bytes(b"another's")
    main.ok("site", linear, "--record", record, "-o", tmp_path / "only.png")
    assert (tmp_path / "only.png").exists()
    assert (tmp_path / "linear_profile.png").read_bytes() == b"another's"
    assert (tmp_path / "linear_site.png").exists()
    assert main("site", tmp_path / "none.csv").returncode == 1
    assert math.isfinite(read_profile(linear).mean_velocity())


def test_the_command_reads_a_record_of_bare_numbers(tmp_path, site, main):
    """A column of numbers and the same samples with their times are one record."""
    from test_site import ricker

    from sitedda.site import intensity

    series = ricker(2.0, 600, 2.0, 0.01)
    np.savetxt(tmp_path / "bare.txt", series)
    np.savetxt(tmp_path / "timed.txt", np.c_[0.01 * np.arange(600), series])
    file = site("\n".join(line.rsplit(",", 1)[0] for line in SITE.splitlines()))
    refused = main("site", file, "--record", tmp_path / "timed.txt")
    assert refused.returncode == 1 and "try --unit" in refused.stderr
    bare, timed = (
        main.ok("site", file, "--record", tmp_path / name, "--unit", "m/s2", *more)
        for name, more in (("bare.txt", ["--time-step", "0.01"]), ("timed.txt", []))
    )
    record = sitedda.read_record(tmp_path / "timed.txt", unit="m/s2")
    assert bare.stdout == timed.stdout and f"reference: {intensity(record)}" in bare.stdout


@pytest.mark.parametrize(
    ("file", "options", "message"),
    [
        (
            "vs.csv",
            ["--damping", "0.05"],
            "--damping does not apply to a CSV profile, whose .*fill",
        ),
        ("vs.csv", ["--retry"], "--retry does not apply to a CSV profile"),
        ("vs.csv", ["--within"], "--within needs --record"),
        ("a.toml", ["--water-table", "0"], "--water-table does not apply to a suite"),
        ("a.nml", ["--record", "r.at2"], "--record does not apply to a model or its output"),
    ],
)
def test_the_command_refuses_options_without_effect(site, main, file, options, message):
    process = main("site", site(name=file), *options)
    assert process.returncode == 1 and process.stderr.count("\n") == 1
    assert re.search(message, process.stderr)


def test_curves_end_at_the_strength_of_the_file(site):
    from sitedda.site import darendeli, gqh, strength_corrected

    head = "depth (m), Vs (m/s), density (kg/m3), su (kPa), phi (deg), curve\n"
    rows = "4, 150, 1800, 40, , darendeli 30\n10, 200, 1850, , 33, darendeli 0\n"
    profile = read_profile(site(head + rows, "strong.csv"))
    friction = (4 * 1800 + 3 * 1850) * 9.80665 * math.tan(math.radians(33))
    assert profile.strengths() == pytest.approx([40e3, friction])
    assert profile.strengths(2.0)[1] < friction  # below water
    text = (head + rows).replace("40, ,", ", ,").replace(", 33,", ", ,")
    plain = read_profile(site(text, "b.csv"))
    for layer, one, other, strength in zip(
        profile.layers, profile.curves(), plain.curves(), profile.strengths(), strict=True
    ):
        modulus = layer.density * layer.shear_velocity**2
        assert 0.85 * strength < one.implied_strength(modulus) <= strength
        small = np.logspace(-6, -3.5, 20)
        np.testing.assert_allclose(one.reduction_at(small), other.reduction_at(small), atol=0.03)
        stress = one.strain * one.reduction
        assert np.all(np.diff(stress) > 0)
        np.testing.assert_allclose(one.damping_at(small), other.damping_at(small))
    exact = gqh(1e-3, [0.3, 0.5, 1.0, 1.0, 0.9])
    corrected = strength_corrected(exact, 1e8, 1e5)
    np.testing.assert_allclose(corrected.reduction_at(exact.strain), exact.reduction, atol=0.01)
    with pytest.raises(ValueError, match="% of the shear modulus"):
        strength_corrected(darendeli(1e5), 1e8, 1e3)
    row = "4, 150, 1800, , , gqh 1e-3 0.3 0.5 1 1 0.9\n"
    np.testing.assert_allclose(
        read_profile(site(head + row, "c.csv")).curves()[0].reduction, exact.reduction
    )
    with pytest.raises(InputError, match="row 2: shear_strength must be above 0"):
        read_profile(site(head + "4, 150, 1800, -1, , linear\n", "d.csv"))


def test_an_unrealistic_implied_strength_is_reported(site):
    head = "depth (m), Vs (m/s), density (kg/m3), curve\n"
    message = read_profile(site(head + "2, 400, 1900, hyperbolic 1e-2\n")).strength_words()
    assert "row 2: the curves imply a shear strength of" in message
    assert not read_profile(site(head + "2, 400, 1900, linear\n")).strength_words()
