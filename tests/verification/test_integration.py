# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of the time integration, and supports that do not ring, on whole runs."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from model_text import changed, tower

import sitedda
from sitedda.response import amplifications
from sitedda.validation.integration import (
    CHANGES,
    audited,
    collision_text,
    soil_column_text,
    transfer_error,
)
from sitedda.validation.packing import pile_text
from sitedda.validation.rocking import SLENDER, tower_text
from sitedda.validation.settlement import wall_text

INPUTS = Path(__file__).parents[2] / "inputs"
SITE = INPUTS / "layered_site.nml"
LISTENED = 45.0  # s: ten after the end of the record, when all has died out
OTHERS = ("midpoint", "theta", "backward_euler")


# --- The peak that is printed ---------------------------------------------------------------------


def peaks_of(file, **changes) -> tuple:
    """The peak of a run, and that of the exact discrete transfer function: Hz and amplitude."""
    run = amplifications(sitedda.run(file, **changes).history)[0].peak
    near = np.linspace(run.frequency - 0.1, run.frequency + 0.1, 401)
    curve = abs(sitedda.transfer(file, near, **changes))
    best = int(np.argmax(curve))
    assert 0 < best < near.size - 1, "the maximum lies elsewhere"
    return run.frequency, run.amplitude, near[best], curve[best]


@pytest.mark.parametrize("time_step", [2.29e-3, 4e-3, 5e-3, 7e-3, 10e-3])  # 1 ms: layered_site
def test_the_peak_is_that_of_the_transfer_function_at_any_time_step(time_step):
    steps = round(LISTENED / time_step)
    frequency, amplitude, *exact = peaks_of(SITE, time_step=time_step, steps=steps)
    print(f"Δt {time_step:g} s: {amplitude:.4f} at {frequency:.4f} Hz, exact {exact}")
    assert abs(frequency - exact[0]) <= 2e-3
    assert amplitude == pytest.approx(exact[1], rel=1e-4)


@pytest.mark.parametrize("integration", ["theta", "backward_euler"])
def test_the_peak_of_another_member_is_that_of_its_transfer_function(integration):
    changes = {"integration": integration, "time_step": 2e-3, "steps": round(LISTENED / 2e-3)}
    frequency, amplitude, *exact = peaks_of(SITE, **changes)
    print(f"{integration}: {amplitude:.4f} at {frequency:.4f} Hz, exact {exact}")
    assert abs(frequency - exact[0]) <= 2e-3
    assert amplitude == pytest.approx(exact[1], rel=1e-4)


def test_a_damping_ratio_at_a_frequency_is_what_the_peak_shows():
    """5 % at 13.9 Hz with steps of 2 ms: the peak of 1/(cos) with that loss, as of the twin."""
    wanted = {"integration": "theta", "damping_ratio": 0.05, "damping_frequency": 13.9}
    changes = wanted | {"time_step": 2e-3, "steps": 20000}
    frequency, amplitude, *exact = peaks_of(SITE, **changes)
    assert amplitude == pytest.approx(exact[1], rel=1e-4)
    assert amplitude == pytest.approx(2 / (np.pi * 0.05), rel=0.02)  # first mode of a layer
    assert abs(frequency - exact[0]) <= 2e-3


# --- Supports -------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["dda", "theta", "backward_euler"])
def soil(request, tmp_path_factory):
    """A run of 30 m of soil at 10 ms; without damping, in midpoint steps, it would never rest."""
    file = tmp_path_factory.mktemp("soil") / "soil.nml"
    file.write_text(soil_column_text(10e-3, LISTENED, integration=request.param))
    return file, sitedda.run(file).history


def averaged_record(time: np.ndarray) -> np.ndarray:
    """Acceleration of the base (m/s²) averaged over the steps that end at these times."""
    record = sitedda.read_record(
        INPUTS / "records" / "LomaPrieta1989_USGS1002_APEEL2_133.smc", format="smc", unit="cm/s2"
    )
    velocity = np.interp(time, record.time.values, record.velocity.values, right=0.0)
    return np.diff(velocity) / np.diff(time)


def test_the_base_follows_the_record_and_rests_after_it(soil):
    _, history = soil
    time = history.time.values
    base = history.acceleration.sel(point="base").isel(axis=0).values[1:]
    record = averaged_record(time)
    after = time[1:] > 36.5  # s, the record has ended
    rest = np.sqrt(np.mean(base[after] ** 2)) / abs(base).max()
    print(f"base {abs(base).max():.4f}, record {abs(record).max():.4f} m/s², after it {rest:.1e}")
    assert abs(base).max() == pytest.approx(abs(record).max(), rel=0.03)
    assert rest < 1e-6


def test_the_soils_peak_is_that_of_the_transfer_function(soil):
    file, history = soil
    peak = amplifications(history)[0].peak
    near = np.linspace(peak.frequency - 0.1, peak.frequency + 0.1, 401)
    curve = abs(sitedda.transfer(file, near))
    assert abs(peak.frequency - near[np.argmax(curve)]) <= 2e-3
    assert peak.amplitude == pytest.approx(curve.max(), rel=1e-4)


def test_supports_of_any_stiffness_leave_the_base_its_motion(tmp_path):
    file = tmp_path / "soil.nml"
    file.write_text(soil_column_text(10e-3, 20.0))
    bases = [
        sitedda.run(file, contact={"fixed_point_ratio": ratio})
        .history.acceleration.sel(point="base")
        .isel(axis=0)
        .values
        for ratio in (10.0, 1e4)
    ]
    assert abs(bases[0] - bases[1]).max() < 1e-3 * abs(bases[1]).max()


# --- Transfer functions by time stepping ----------------------------------------------------------


@pytest.mark.parametrize("name", list(CHANGES))
def test_steps_have_the_transfer_function(name):
    worst = transfer_error(CHANGES[name])[0]
    print(f"{name}: {worst:.2e}")
    assert worst < 2e-3


# --- Energy ---------------------------------------------------------------------------------------


def texts(integration: str) -> dict:
    """Inputs whose total energy may only fall."""
    member = {"integration": integration}
    return {
        "wall, soft": wall_text(50, 1 / 25, 1e-2, 150, **member),
        "wall, stiff": wall_text(50, 300.0, 1e-3, 150, **member),
        "rocking block": tower_text(1e-3, 2.0, 0.6 * SLENDER, **member),
        "collision": collision_text(1e-3, **member),
        "polygons": pile_text(60, 8, 0.8, **member),
    }


@pytest.mark.parametrize("integration", OTHERS)
@pytest.mark.parametrize("name", list(texts("dda")))
def test_no_member_gains_energy(integration, name):
    found = audited(texts(integration)[name])
    print(f"{integration}, {name}: gain {found.gain:.1e}, residual {found.residual:.1e}")
    assert found.gain <= 1e-6 and found.growth <= 1e-6
    assert found.residual <= 1e-6
    assert found.lowest < -1e-3, "nothing happened"


# --- The same bits --------------------------------------------------------------------------------


def shaken(steps: int = 300, **control) -> list:
    """A loose tower on supports that move, in steps of θ = 3/4."""
    loose = {"name": "bedding", "friction_angle": 5.0}
    groups = tower(4, steps, loose, gravity=[0.0, -9.81], integration="theta", **control)
    return changed(groups, "output", block_interval=30)


def bits_of(history) -> list:
    return [history[name].values.tobytes() for name in ("block_coordinates", "displacement")]


def test_a_resumed_run_has_the_bits_of_one_left_alone(write_input, tmp_path):
    """The supports' velocity of the motion is a state where χ > 1/2."""
    file = write_input(shaken())
    whole = sitedda.run(file)
    for stop in (1, 35, 137):  # 35: within the pulse
        output = tmp_path / f"{stop}.nc"
        with sitedda.Simulation(file, output) as simulation:
            simulation.advance(stop)
        assert bits_of(sitedda.resume(file, output).history) == bits_of(whole.history)


def test_a_killed_run_goes_on_to_the_same_bits(write_input, tmp_path):
    long = 4000
    file = write_input(changed(shaken(long), "output", checkpoint_interval=200))
    whole = sitedda.run(file, output=tmp_path / "whole.nc")
    code = f"import sitedda; sitedda.run({str(file)!r}, output={str(tmp_path / 'killed.nc')!r})"
    running = subprocess.Popen([sys.executable, "-c", code])
    checkpoint = tmp_path / "killed.nc.checkpoint"
    deadline = time.monotonic() + 60
    while not checkpoint.exists() and running.poll() is None:
        assert time.monotonic() < deadline, "no checkpoint was written"
        time.sleep(0.005)
    running.send_signal(signal.SIGKILL)
    running.wait(60)
    resumed = sitedda.resume(file, tmp_path / "killed.nc")
    assert bits_of(resumed.history) == bits_of(whole.history)


def test_threads_change_no_bit(tmp_path):
    """The shaken wall of the inputs, on one thread and on two."""
    code = (
        "import hashlib, sitedda\n"
        f"history = sitedda.run({str(INPUTS / 'wall.nml')!r}, duration=1.1,"
        " integration='theta').history\n"
        "bits = b''.join(history[n].values.tobytes() for n in sorted(history.data_vars)"
        " if history[n].dtype.kind == 'f')\n"
        "print(hashlib.sha256(bits).hexdigest())"
    )
    marks = [
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"OMP_NUM_THREADS": threads, "OMP_WAIT_POLICY": "passive"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    ]
    assert len(marks[0]) > 60 and marks[0] == marks[1]
