# SPDX-License-Identifier: GPL-3.0-or-later
"""Modes of an ambient record of a run of known stiffness."""

import numpy as np
import pandas as pd
import pytest

import sitedda
from sitedda.calibration import horizontal_over_vertical, identify, measured_modes, read_ambient
from sitedda.command import main
from sitedda.errors import InputError

STEP, STEPS = 2e-3, 60000
SHEAR, BED = "joint[bed].shear_stiffness_per_area", "boundary[ground].stiffness_per_area"


def stack(folder) -> sitedda.Model:
    """Four blocks on springs whose supports move as white noise along both axes."""
    random = np.random.default_rng(1)
    model = sitedda.Model("stack", time_step=STEP, steps=STEPS, gravity=[0, -9.81], settle=True)
    model.output(history_interval=4)
    model.contact(normal_stiffness=1e9)
    model.material("stone", density=2200.0, young_modulus=2e9, poisson_ratio=0.2)
    model.joint("bed", friction_angle=35.0, normal_stiffness_per_area=8e8,
                shear_stiffness_per_area=3e7)  # fmt: skip
    model.drums(name="b", width=2.0, height=0.5, count=4)
    for i in (1, 3):
        model.measured_point(f"p{i}", 0.0, 0.5 * i + 0.25, f"b_{i + 1}")
    for axis in "xy":
        np.savetxt(folder / f"{axis}.txt", 0.02 * random.standard_normal(STEPS))
        model.motion(axis, file=folder / f"{axis}.txt", format="text", time_step=STEP,
                     quantity="acceleration", unit="m/s2")  # fmt: skip
    model.boundary(name="ground", kind="springs", blocks="b_1", side="bottom",
                   stiffness_per_area=6e7, motion_x="x", motion_y="y")  # fmt: skip
    return model


@pytest.fixture(scope="module")
def ambient(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ambient")
    model = stack(folder)
    record = read_ambient(model.run(output=folder / "stack.nc").history)
    record.to_csv(folder / "record.csv", float_format="%.6g")
    return folder, model, record


def test_modes_of_a_record(ambient):
    """A sway and a vertical mode: 0.5 % in frequency, 20 % in damping, and their deviations."""
    pytest.importorskip("pyoma2")
    folder, model, _ = ambient
    modes = identify(folder / "record.csv", (4.0, 20.0))
    modes.to_csv(folder / "modes.csv", index=False)
    assert np.allclose(measured_modes(folder / "modes.csv")[list(modes)], modes, rtol=1e-12)
    own = sitedda.modes(model, 2)
    frequency = own.frequency / (1 + own.elongation)  # as the steps have it
    assert len(modes) == 2
    shapes = modes[["p1.x", "p1.y", "p3.x", "p3.y"]].to_numpy()
    true = own.shapes[:, [1, 3], :2].reshape(2, -1)
    assert np.all(np.sum(shapes * true, 1) ** 2 / np.sum(true**2, 1) > 0.999)  # MAC
    for mode, f, damping in zip(modes.itertuples(), frequency, own.damping, strict=True):
        assert mode.frequency == pytest.approx(f, rel=0.005)
        assert mode.damping == pytest.approx(damping, rel=0.2)
        assert abs(mode.frequency - f) < 3 * mode.deviation < 0.03 * f
        assert abs(mode.damping - damping) < 3 * mode.damping_deviation < 0.5 * damping


@pytest.fixture(scope="module")
def miniseed(ambient):
    """The record as traces of a file of another program; those of y begin later."""
    obspy = pytest.importorskip("obspy")
    folder, _, record = ambient
    stream = obspy.Stream()
    for name, values in record.items():
        station, axis = name.split(".")
        delay = 7 * (axis == "y")
        header = {"station": station, "channel": f"HH{'EZ'['xy'.index(axis)]}", "delta": 4 * STEP}
        stream += obspy.Trace(values.to_numpy()[delay:], header)
        stream[-1].stats.starttime += delay * 4 * STEP
    stream.write(folder / "record.mseed")
    return folder / "record.mseed"


@pytest.mark.parametrize("name", ["record.csv", "record.mseed"])
def test_calibrate_from_a_record(ambient, name, request, capsys, monkeypatch):
    pytest.importorskip("pyoma2")
    folder, model, _ = ambient
    if name.endswith("mseed"):
        request.getfixturevalue("miniseed")
    monkeypatch.chdir(folder)
    model.write("stack.nml")
    command = ["calibrate", "stack.nml", name, "--record", "4:20", "--discrepancy", "0.005",
               "--unknown", f"{SHEAR}=1e7:1e8", "--unknown", f"{BED}=2e7:2e8"]  # fmt: skip
    assert main(command) == 0
    assert "record_modes.csv" in capsys.readouterr().out
    samples = np.loadtxt("stack_calibration.csv", delimiter=",", skiprows=2)
    low, high = np.percentile(samples, (1, 99), axis=0)  # 90 % would miss 1 of 5 records
    assert np.all((low < [3e7, 6e7]) & ([3e7, 6e7] < high)) and np.all(high < 1.5 * low)


def test_traces_of_another_program_are_the_record(ambient, miniseed):
    record = ambient[2]
    assert np.allclose(read_ambient(miniseed)[list(record)], record[7:])
    named = read_ambient(miniseed, {"p3.HHE": "top.x", "HHZ": "any.y"})
    assert sorted(named) == ["any.y", "top.x"]
    with pytest.raises(InputError, match="no channels"):
        read_ambient(miniseed, {"p9.HHE": "top.x"})


def test_refuses_traces_without_common_time(tmp_path):
    obspy = pytest.importorskip("obspy")
    stream = obspy.Stream()
    for axis, start in (("E", 0.0), ("Z", 100.0)):
        header = {"station": "p", "channel": f"HH{axis}", "delta": 0.01}
        stream += obspy.Trace(np.arange(500.0), header)
        stream[-1].stats.starttime += start
    stream.write(file := tmp_path / "apart.mseed")
    with pytest.raises(InputError, match="apart.mseed: the traces have no time in common"):
        read_ambient(file)


def test_h_over_v_of_noise():
    """The spectral ratio of two noises, one of them through an oscillator, is its transfer."""
    from scipy.signal import lfilter

    noise = np.random.default_rng(3).standard_normal((60000, 2))
    record = pd.DataFrame(noise * [2.0, 1.0], 0.01 * np.arange(60000), ["a.x", "a.y"])
    at = np.geomspace(1.0, 30.0, 12)
    median, sigma = horizontal_over_vertical(record, at, "a")
    windows = 2 * 600 / 30 - 1
    assert np.all(abs(np.log(median / 2)) < 4 * 1.25 * sigma / np.sqrt(windows / 2))
    pole = 0.97 * np.exp(2j * np.pi * 0.01 * 5.0)
    ring = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], noise[:, 0])
    ringing = record.assign(**{"a.x": ring})
    median, _ = horizontal_over_vertical(ringing, fine := np.linspace(2.0, 10.0, 81), "a")
    assert fine[median.argmax()] == pytest.approx(5.0, abs=0.3)


def test_a_record_of_one_mode():
    """An oscillator of 4 Hz and 2 % under white noise, in two channels of ratio 0.6."""
    pytest.importorskip("pyoma2")
    from scipy.signal import cont2discrete, lfilter

    step, omega, random = 0.02, 2 * np.pi * 4.0, np.random.default_rng(9)
    system = [omega**2], [1.0, 2 * 0.02 * omega, omega**2]
    numerator, denominator, _ = cont2discrete(system, step, "foh")
    motion = lfilter(numerator[0], denominator, random.standard_normal(30000))
    noise = 0.1 * random.standard_normal((2, 30000))
    channels = {"top.x": motion + noise[0], "mid.x": 0.6 * motion + noise[1]}
    modes = identify(pd.DataFrame(channels, step * np.arange(30000)), (2.0, 8.0))
    assert len(modes) == 1
    assert modes.frequency[0] == pytest.approx(4.0, rel=0.01)
    assert modes["mid.x"][0] / modes["top.x"][0] == pytest.approx(0.6, rel=0.03)


def test_refuses_dead_channels_and_windows():
    noise = np.random.default_rng(3).standard_normal((60000, 2))
    record = pd.DataFrame(noise, 0.01 * np.arange(60000), ["a.x", "a.y"])
    dead = record.assign(**{"a.y": 0.5})
    for call in (lambda: identify(dead, (4.0, 20.0)),
                 lambda: horizontal_over_vertical(dead, [2.0], "a")):  # fmt: skip
        with pytest.raises(InputError, match="channel a.y of the record is dead: all its .* 0.5"):
            call()
    for window in (-30.0, 0.0):
        with pytest.raises(InputError, match="window must be finite and positive, got"):
            horizontal_over_vertical(record, [2.0], "a", window)
    with pytest.raises(InputError, match="frequency: give one or more"):
        horizontal_over_vertical(record, [], "a")


@pytest.mark.parametrize(
    ("band", "message"),
    [((4.0, 60.0), "below 50 Hz"), ((0.1, 20.0), "less than 100 periods"), ((9, 4), "in order")],
)
def test_refuses_bands(ambient, band, message):
    with pytest.raises(InputError, match=message):
        identify(ambient[2], band)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("top.x,time\n1,2\n", "give a heading"),
        ("time,a.x\n0,1\n1,b\n", "line 3: .*'b'"),
        ("time,a.x\n0,1\n1,2\n2,2\n4,2\n", "record.csv: .* sample 4, time = 4 s"),
        ("time,a.x\n0,1\n0,2\n", "sample 1, time = 0 s"),
        ("time,a.x\n0,1\n1,nan\n", "record.csv: sample 2 of a.x"),
    ],
)
def test_refuses_records(tmp_path, text, message):
    (tmp_path / "record.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        read_ambient(tmp_path / "record.csv")


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (pd.DataFrame(), "the record has 0 samples of 0 channels"),
        (pd.DataFrame({"a.x": [1.0]}), "the record has 1 samples"),
        (pd.DataFrame(index=[0.0, 1.0]), "the record has 2 samples of 0 channels"),
        (pd.DataFrame({"a.x": [1.0, 2.0]}, pd.date_range("2026", periods=2)), "by time .s.: "),
        (pd.DataFrame({"a.x": ["1", "b"]}), "the record is not a table of numbers .*'b'"),
        (pd.DataFrame(np.eye(2), columns=["a.x", "a.x"]), "channel 'a.x' is repeated"),
    ],
)
def test_refuses_tables(table, message):
    with pytest.raises(InputError, match=message):
        read_ambient(table)
