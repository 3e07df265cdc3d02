# SPDX-License-Identifier: GPL-3.0-or-later
"""Execution of studies: command, Dask cluster, Slurm; records, and settings in a file."""

import os
import shlex
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import slurm_stand_in
import xarray as xr
from dask_cluster import cluster
from environment import DEADLINE, captured, executable
from model_text import changed, tower
from study_functions import same

import sitedda
from sitedda.errors import InputError
from sitedda.report import Picture
from sitedda.study import Record, Records, collect, eurocode8, gather, synthetic
from sitedda.study.page import report_page
from sitedda.study.plan import make_plan
from sitedda.study.records import intensity
from sitedda.study.settings import read_settings
from sitedda.study.slurm import Slurm, write_batch

RECORD = Path(__file__).parents[3] / "inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc"
STUDY = """
model = "model.nml"
results = {top = "displacement[surface].x.largest", energy = "energy_balance.last"}
[fixed]
"control.steps" = 40
[parameters]
"material.rock.density" = [2500.0, -1.0, 2700.0]
"scale" = {changes = "motion.scale", from = 1.0, to = 4.0, count = 3, spacing = "log"}
"""


FIGURE = """[[figures]]
kind = "map"
quantity = "topp"
x = "density"
y = "scale"
[fixed]"""


@pytest.fixture
def study(write_input, tmp_path):
    """Write a study of nine cases, three of which fail."""
    write_input(tower())
    file = tmp_path / "grid.toml"
    file.write_text(STUDY)
    return file


@pytest.fixture
def table(study):
    """Return the table of the study, run in this process."""
    plan = read_settings(study).plan
    with ThreadPoolExecutor(1) as pool:
        return sitedda.study(plan.model, plan.axes, {q.label: q.name for q in plan.quantities},
                             fixed=plan.fixed, executor=pool)  # fmt: skip


def test_the_command_runs_a_study(study, table, main, tmp_path):
    assert "not started" in main.ok("study", "status", study).stdout
    process = main("study", study, "--workers", "1", "--quiet", "--report")
    assert process.returncode == 1 and "--retry" in process.stdout
    assert "9 cases: 6 complete, 3 failed" in process.stdout
    assert "failed: density = -1.0, scale = 1.0 and 2 more: " in process.stdout
    with xr.open_dataset(tmp_path / "grid_study" / "table.nc") as data:
        for name in ("top", "energy", "status"):
            assert np.array_equal(data[name].values, table[name].values, equal_nan=name != "status")
    page = (tmp_path / "grid_study" / "report.html").read_text()
    assert "Failed cases" in page and "must be a positive number" in page
    status_process = main("study", "status", study)
    assert status_process.returncode == 1
    assert "9 cases: 6 complete, 3 failed" in status_process.stdout
    collect_process = main("study", "collect", tmp_path / "grid_study", "-o", tmp_path / "all.zarr")
    assert collect_process.returncode == 1 and (tmp_path / "all.zarr").is_dir()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("results", "result", "there is no name 'result'; did you mean 'results'"),
        ("[fixed]", "[fixes]", "there is no name 'fixes'; did you mean 'fixed'"),
        ("count = 3", "counts = 3", "there is no name 'counts'; did you mean 'count'"),
        ('"log"', '"lag"', "spacing must be 'linear' or 'log'"),
        ("model =", "#", "model is missing"),
        ("[parameters]", "[parameters", "grid.toml: "),
        ("rock.density", "rock.densety", "has no variable 'densety'; did you mean 'density'"),
        ("model.nml", "modal.nml", "there is no such file"),
        (
            "[fixed]",
            FIGURE,
            "figure 1: quantity = 'topp' is not a result of the study; did you mean",
        ),
    ],
)
def test_errors_of_a_study_file_are_named(study, main, old, new, message):
    study.write_text(STUDY.replace(old, new))
    process = main("study", study, "-q")
    assert process.returncode == 1 and message in process.stderr.replace("; there", "; there")
    assert "Traceback" not in process.stderr


def test_factors_of_safety_over_friction_and_water(root):
    """The shipped study on a part of its grid agrees with the closed form of a block on a plane."""
    settings = read_settings(root / "inputs/studies/stability.toml")
    plan = settings.plan
    grid = {
        "friction_angle": ("joint[plane].friction_angle", [35.0, 45.0]),
        "water_pressure": ("water[crack].scale", [0.0, 1.0]),
    }
    assert list(plan.dims) == list(grid)
    with ThreadPoolExecutor(2) as pool:
        table = sitedda.study(plan.model, grid, task=plan.task, executor=pool)
    weight, uplift, thrust = 2.5e6, 0.4e6, 0.2e6  # N/m, for a crack full of water
    dip = np.radians(35.0)
    fraction, tangent = table.water_pressure, np.tan(np.radians(table.friction_angle))
    resistance = weight * np.cos(dip) - fraction * (uplift + thrust * np.sin(dip))
    expected = resistance * tangent / (weight * np.sin(dip) + fraction * thrust * np.cos(dip))
    assert (abs(table.factor_of_safety / expected - 1.0) < 1e-3).all()
    assert (table.stands_at < expected * 1.0005).all()
    assert (table.fails_at > expected * 0.9995).all()
    assert (table.warning == "").all()
    figure = report_page(table, settings.figures).sections[1]
    assert figure.title == "Factor of safety" and isinstance(figure.parts[0], Picture)


# --- Dask ----------------------------------------------------------------------------------------


def test_a_dask_cluster_gives_the_same_table(study, table, main, tmp_path):
    with cluster(tmp_path, workers=2) as dask:
        process = main("study", study, "--dask", dask.address, "-q")
    assert process.returncode == 1 and not process.stderr, process.stderr  # three cases fail
    same(collect(tmp_path / "grid_study"), table)


def test_a_missing_dask_scheduler_is_reported(study, main):
    pytest.importorskip("distributed")
    process = main("study", study, "--dask", "tcp://127.0.0.1:9", "--tls-cert", "a.pem")
    assert process.returncode == 1 and "--tls-ca, --tls-cert, --tls-key" in process.stderr


# --- Slurm ---------------------------------------------------------------------------------------


def test_a_job_array_gives_the_same_table(study, table, main, tmp_path, monkeypatch):
    path = f"{slurm_stand_in.install(tmp_path / 'bin')}{os.pathsep}{os.environ['PATH']}"
    monkeypatch.setenv("PATH", path)
    monkeypatch.setenv("STAND_IN_SEED", "5")
    study.write_text(f"{STUDY}\n[slurm]\neach = 2\noptions = ['--partition=a b']\n")
    process = main.ok("study", study, "--slurm", "--program", executable("sitedda-native"))
    assert "Submitted batch job 7" in process.stdout
    script = (tmp_path / "grid_study" / "submit.sh").read_text()
    assert "#SBATCH --partition=a\\ b" in script and "#SBATCH --array=0-4" in script
    assert main("study", "collect", study, "-q", "-w", "1").returncode == 1
    collected_table = collect(tmp_path / "grid_study")
    same(collected_table, table)


def test_a_job_array_killed_halfway_continues(write_input, tmp_path):
    file = write_input(tower(steps=3000))
    text = file.read_text().replace("&output", "&output\n checkpoint_interval = 200")
    file.write_text(text)
    scales = {"motion.scale": [1.0, 2.0, 3.0, 4.0]}
    quantities = ["displacement[surface].x"]
    plan = make_plan(file, scales, quantities, tmp_path / "a study's folder").write()
    script = write_batch(plan, Slurm(executable("sitedda-native")))
    job = ["bash", str(slurm_stand_in.install(tmp_path / "bin") / "sbatch"), str(script)]
    job_process = subprocess.Popen(job, start_new_session=True, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + DEADLINE
    while len(list(plan.folder.glob("cases/*/*/out.nc*"))) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    os.killpg(job_process.pid, signal.SIGKILL)
    job_process.wait()
    assert not list(plan.folder.glob("cases/*/*/failed.txt"))
    subprocess.run(job, check=True, stdout=subprocess.DEVNULL)
    with ThreadPoolExecutor(1) as pool:
        gather(plan, 1)
        reference = sitedda.study(file, scales, quantities, executor=pool)
    same(collect(plan.folder), reference)


def test_batch_scripts_are_quoted_and_refuse_another_build(study, tmp_path):
    hostile_folder = tmp_path / "a; touch 'evil' $(touch evil)"
    plan = make_plan(tmp_path / "model.nml", {"motion.scale": [1.0]}, KEPT, hostile_folder).write()
    script = write_batch(plan, Slurm(executable("sitedda-native")))
    assert f"study={shlex.quote(str(hostile_folder))}" in script.read_text()
    environment = os.environ | {"SLURM_ARRAY_TASK_ID": "0"}
    subprocess.run(["bash", script], env=environment, check=True, cwd=tmp_path)
    assert not list(tmp_path.rglob("evil")) and list(hostile_folder.glob("cases/*/*/words.txt"))
    script.write_text(script.read_text().replace("| cut -c 1-32", "| cut -c 1-31"))
    process = captured(["bash", script], env=environment)
    assert process.returncode == 1 and "plan it again" in process.stderr
    for invalid_options in (Slurm(options=["-p x"]), Slurm(time="1h"), Slurm("no-such-program")):
        with pytest.raises(InputError):
            write_batch(plan, invalid_options)


@pytest.mark.parametrize(
    "line",
    ["program = 'evil'", "options = ['--output=evil']", "options = ['--export=ALL,BASH_ENV=evil']",
     "options = ['--chdir=/']", "options = ['--wrap=touch']", "options = ['--array=0-9999']"],
)  # fmt: skip
def test_a_study_cannot_name_files_for_slurm(study, main, line):
    study.write_text(f"{STUDY}\n[slurm]\n{line}\n")
    process = main("study", "plan", study)
    assert process.returncode == InputError.kind
    message = "sitedda study plan --program" if line.startswith("program") else "line of sbatch"
    assert message in process.stderr
    assert not (study.parent / "grid_study").exists()


KEPT = ["displacement[surface].x.largest"]


# --- records -------------------------------------------------------------------------------------


def test_records_are_scaled_to_levels(write_input, tmp_path):
    record = synthetic(3, eurocode8(2.0), duration=4.0, time_step=0.02, periods=(0.1, 1.0))
    groups = changed(tower(steps=20), "motion", values=None, quantity=None, time_step=None,
                     file=str(RECORD))  # fmt: skip
    suite = Records([RECORD, *record], [0.5, 2.0], "pga")
    assert suite.dims == {"record": 2, "pga": 2}
    with ThreadPoolExecutor(1) as pool:
        table = sitedda.study(write_input(groups), suite, KEPT, executor=pool)
    assert table.status.values.tolist() == [["complete"] * 2] * 2, table.message.values
    peak = abs(sitedda.read_record(RECORD).acceleration).max().item()
    assert np.allclose(table.factor[0], [0.5 / peak, 2.0 / peak])
    assert np.allclose(table.factor[1] * abs(record[0].acceleration).max(), [0.5, 2.0])
    largest = table[KEPT[0]].values
    assert np.allclose(largest[:, 1] / largest[:, 0], 4.0, rtol=1e-6)


def test_measures_of_intensity_of_a_sine():
    step, period = 1e-3, 0.5
    t = np.arange(0, 20, step)
    a = 3.0 * np.sin(2 * np.pi * t / period)
    assert intensity("pga", a, None, step) == pytest.approx(3.0, rel=1e-4)
    assert intensity("arias", a, None, step) == pytest.approx(np.pi / 2 / 9.80665 * 90, rel=1e-3)
    resonant = 3.0 / (2 * 0.05)  # in steady vibration
    assert intensity("sa", a, None, step, period) == pytest.approx(resonant, rel=5e-3)
    record = Record("sine", a, step)
    assert Records([record], [4.0], "arias").factors ** 2 == pytest.approx(
        4.0 / intensity("arias", a, None, step)
    )


def test_synthetic_records_fit_their_spectrum():
    target = eurocode8(2.0, "B")
    first_record, other = synthetic([1, 2], target, duration=15.0)
    assert max(first_record.misfit, other.misfit) < 0.05
    assert np.corrcoef(first_record.acceleration, other.acceleration)[0, 1] < 0.5
    for period in (0.1, 0.4, 1.0):
        response = intensity("sa", first_record.acceleration, None, first_record.time_step, period)
        assert response == pytest.approx(float(target(period)), rel=0.1)
    assert np.array_equal(
        synthetic(1, target, duration=15.0)[0].acceleration, first_record.acceleration
    )
    # S a_g at T = 0, 2.5 S a_g on the plateau, TC/T and TC TD/T² beyond
    shape = [1.0, 2.5, 2.5 * 0.5 / 1.0, 2.5 * 0.5 * 2.0 / 16.0]
    assert np.allclose(target(np.array([0.0, 0.3, 1.0, 4.0])), 2.0 * 1.2 * np.array(shape))


@pytest.mark.parametrize(
    "arguments",
    [
        lambda: Records([RECORD], [1.0], "pgd"),
        lambda: Records([RECORD], [1.0], "sa"),
        lambda: Records([], [1.0]),
        lambda: Records([RECORD], [0.0]),
        lambda: eurocode8(1.0, "F"),
        lambda: synthetic(1, eurocode8(1.0), periods=(0.01, 1.0)),
        lambda: synthetic(1, lambda t: 0 * t),
    ],
)
def test_invalid_suites_are_refused(arguments):
    with pytest.raises(InputError):
        arguments()
