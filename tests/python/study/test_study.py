# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: cases, keys, tables; failed, resumed and rejected cases."""

import json
import math
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import study_functions
from environment import DEADLINE
from model_text import changed, namelist, tower
from study_functions import same

import sitedda
from sitedda.errors import InputError, OutputError
from sitedda.study import (
    Points,
    Workers,
    collect,
    counts,
    latin_hypercube,
    lognormal,
    one_at_a_time,
    saltelli,
    seeds,
    sobol,
    uniform,
)
from sitedda.study.case import Work, carry_out, run_input
from sitedda.study.plan import make_plan
from sitedda.study.pushing import PushTo
from sitedda.study.solving import SolveFor
from sitedda.study.store import case_folder, locked, read_result

GRID = {"material.rock.density": [2500.0, 2643.0], "motion.scale": [1.0, 2.0, 3.0]}
KEPT = ["displacement[surface].x", "displacement[surface].x.largest", "energy_balance.last"]
COLUMN = Path(__file__).parents[3] / "inputs" / "column.nml"


@pytest.fixture
def file(write_input):
    return write_input(tower())


@pytest.fixture
def threads():
    with ThreadPoolExecutor(2) as pool:
        yield pool


# --- the table -----------------------------------------------------------------------------------


def test_a_table_contains_the_results_of_single_runs(file, threads):
    table = sitedda.study(file, GRID, KEPT, executor=threads)
    assert dict(table.sizes) == {"density": 2, "scale": 3, "time": 61}
    assert table.density.attrs["changes"] == "material.rock.density"
    assert counts(table) == {"complete": 6}
    for i, density in enumerate(GRID["material.rock.density"]):
        for j, scale in enumerate(GRID["motion.scale"]):
            changes = {"material.rock.density": density, "motion.scale": scale}
            run = sitedda.run(file, changes=changes).history
            displacement = run.displacement.sel(point="surface") - run.base_displacement
            history = table["displacement[surface].x"][i, j]
            assert np.array_equal(history, displacement.sel(axis="x"))
            largest = history[int(np.argmax(abs(history.values)))]
            assert table["displacement[surface].x.largest"][i, j] == largest


def test_all_kinds_of_quantities(file, threads):
    results = {"all": "verdict", "steps": study_functions.steps_of, "Sa": "spectrum[surface].x",
               "stress": "block_stress[layer_1].yy.min", "v": "velocity[surface].y"}  # fmt: skip
    table = sitedda.study(file, {"motion.scale": [1.0]}, results, executor=threads)
    run = sitedda.run(file)
    values = run.verdict.values
    for name in ("largest_displacement_m", "pga_m_s2[surface]", "energy_balance_j_m"):
        assert table[name].item() == values[name]
    assert table.blocks_fallen.item() == 0 and table.steps.item() == 61
    assert np.nanmax(table.Sa) == pytest.approx(values["sa_m_s2[surface]"], rel=1e-12)
    stress = run.history.block_stress.sel(block="layer_1", component="yy")
    assert table.stress.item() == stress.min()
    assert np.array_equal(table.v[0], run.history.velocity.sel(point="surface", axis="y"))


@pytest.mark.parametrize(
    ("quantity", "message"),
    [
        ("displacement[top].x", r"no point 'top'; there are base, surface"),
        ("displacement[surface]", "name the axis, one of x, y"),
        ("height", "no quantity .height."),
        ("largest_tilt_deg", "did you mean .largest_tilt_rad."),
        ("density", "no quantity"),
        ("block_density[layer_1]", "does not vary in time"),
        ("pga_m_s2[top]", r"no point 'top'; there are base, surface"),
        ("joint_slip[seam].last", "no quantity 'joint_slip'"),
        ("amplification_ratio", "requires a group &amplification"),
        ("spectrum[surface].z", "no axis 'z'"),
    ],
)
def test_an_unknown_quantity_is_named_before_the_first_run(
    file, tmp_path, threads, quantity, message
):
    cases = {"material.rock.density": [-1.0, 2643.0]}  # the first case cannot start
    with pytest.raises(InputError, match=message):
        sitedda.study(file, cases, [quantity], folder=tmp_path / "study", executor=threads)
    assert not [*tmp_path.glob("study/cases/*/*/result.json")]


@pytest.mark.parametrize(
    "task",
    [
        SolveFor("material.rock.densety", "largest_tilt_rad", 1.0, (1.0, 2.0)),
        SolveFor("motion.scale", "displacement[top].x.last", 1.0, (1.0, 2.0)),
        PushTo("top"),
    ],
)
def test_names_of_a_task_are_checked_before_its_first_run(file, tmp_path, threads, task):
    with pytest.raises(InputError, match="no variable 'densety'|no point 'top'"):
        sitedda.study(file, [], folder=tmp_path / "study", task=task, executor=threads)
    assert not [*tmp_path.glob("study/cases/*/*/result.json")]


@pytest.mark.parametrize("quantity", ["displacement[top].x.mean", "a b", 3])
def test_an_invalid_quantity_is_refused(file, quantity):
    with pytest.raises(InputError):
        sitedda.study(file, {"motion.scale": [1.0]}, [quantity])


def test_histories_of_uneven_steps_are_interpolated_to_equal_steps(file, threads):
    steps = {"control.time_step": [1e-3, 5e-4]}
    fixed = {"duration": 0.06}
    names = ["displacement[surface].x", "absolute_displacement[surface].x"]
    table = sitedda.study(file, steps, names, fixed=fixed, executor=threads)
    assert np.allclose(table.time, np.arange(61) * 1e-3, atol=1e-12)
    assert "interpolated" in table.time.attrs["comment"]
    fine = sitedda.run(file, duration=0.06, time_step=5e-4).history
    displacement = fine.displacement.sel(point="surface", axis="x")
    base = fine.base_displacement.sel(axis="x")
    assert abs(base).max() > 5 * abs(displacement - base).max() > 0.0
    for name, series in zip(names, (displacement - base, displacement), strict=True):
        expected = np.interp(table.time, fine.time, series)
        assert np.allclose(table[name][1], expected, rtol=0, atol=1e-15)


def test_histories_that_end_early_are_padded_with_nan(file, threads):
    steps = {"control.steps": [20, 60, 40]}
    table = sitedda.study(file, steps, ["displacement[surface].x"], executor=threads)
    history = table["displacement[surface].x"].values
    assert history.shape == (3, 61) and "comment" not in table.time.attrs
    assert np.sum(np.isnan(history), axis=1).tolist() == [40, 0, 20]
    assert np.array_equal(history[0, :21], history[1, :21])


@pytest.mark.parametrize("name", ["table.nc", "table.zarr"])
def test_tables_on_disk_and_in_memory_are_equal(file, tmp_path, threads, name):
    study = tmp_path / "study"
    memory = sitedda.study(file, GRID, KEPT, folder=study, executor=threads)
    with collect(study, tmp_path / name) as disk:
        encoding = disk["displacement[surface].x"].encoding
        assert tuple(encoding.get("chunksizes") or encoding["chunks"]) == (1, 1, 61)
        for variable in memory.variables:
            assert np.array_equal(memory[variable].values, disk[variable].values), variable


def test_a_model_may_be_a_function(threads):
    table = sitedda.study(study_functions.plane, {"a": [1.0, 2.0], "b": [0.0, 3.0]},
                          executor=threads)  # fmt: skip
    assert table["sum"].values[1, 1] == 5.0 and np.isnan(table["sum"].values[1, 0])
    assert table.message.values[0, 0] == "ValueError: b is nothing"
    assert table.row.values[1, 1].tolist() == [2.0, 3.0, 6.0]


def test_a_task_may_be_a_function_of_the_input(file, tmp_path, threads):
    for folder in (None, tmp_path / "study"):
        table = sitedda.study(file, {"contact.normal_stiffness": [1e12, 4e12]}, folder=folder,
                              task=study_functions.first_frequency, executor=threads)  # fmt: skip
        assert table.frequency_1.dims == ("normal_stiffness",)
        assert table.frequency_1[1] > table.frequency_1[0]


# --- parameters ----------------------------------------------------------------------------------


def test_names_of_dimensions_are_unique():
    parameters = {"joint[a].cohesion": [1.0], "joint[b].cohesion": [2.0]}
    plan = make_plan("none.nml", parameters | {"phi": ("joint[*].friction_angle", [3.0])})
    assert list(plan.dims) == ["a_cohesion", "b_cohesion", "phi"]
    cohesions = {"joint[a].cohesion": 1.0, "joint[b].cohesion": 2.0}
    assert list(plan.changes()) == [cohesions | {"joint[*].friction_angle": 3.0}]


@pytest.mark.parametrize(
    "parameters",
    [
        {"motion.scale": []},
        {"motion.scale": 3.0},
        {"motion.scale": "abc"},
        {"status": ("motion.scale", [1.0])},
        [{"x": ("a.b", [1.0])}, {"x": ("a.c", [1.0])}],
    ],
)
def test_invalid_parameters_are_refused(parameters):
    with pytest.raises(InputError):
        make_plan("none.nml", parameters)


def test_samples_have_their_distributions_and_seeds():
    distributions = {"a": uniform(1.0, 3.0), "b": lognormal(5.0, 0.3)}
    for method in (latin_hypercube, sobol):
        sample = method(64, distributions, seed=3)
        assert sample.values == method(64, distributions, seed=3).values
        assert sample.values != method(64, distributions, seed=4).values
        a = np.sort(sample.values["a"])
        assert np.all((a - 1.0) / 2.0 * 64 < np.arange(64) + 1.0 + 1e-9)
        assert np.median(sample.values["b"]) == pytest.approx(5.0, rel=0.02)
    with pytest.raises(InputError, match="power of two"):
        sobol(10, distributions)
    with pytest.raises(InputError, match="low < high"):
        uniform(1.0, 1.0)


def test_designs_of_sensitivity_analysis():
    design = one_at_a_time({"a": (1, 2, 3), "b": (10, 20, 30)})
    assert design.values == {"a": [2, 1, 3, 2, 2], "b": [20, 20, 20, 10, 30]}
    mixed = saltelli(8, {"a": uniform(0, 1), "b": uniform(0, 1)})
    a = np.reshape(mixed.values["a"], (4, 8))
    b = np.reshape(mixed.values["b"], (4, 8))
    assert np.array_equal(a[2], a[1]) and np.array_equal(b[2], b[0])
    assert np.array_equal(a[3], a[0]) and np.array_equal(b[3], b[1])
    assert seeds("voronoi.seed", 3) == {"voronoi.seed": [1, 2, 3]}


def test_seeds_give_different_joint_networks(tmp_path, threads):
    text = """&run title = 'x' / &control time_step = 1e-3, steps = 3, gravity = 0, -9.81 /
    &material name = 'rock', density = 2600.0, young_modulus = 5e9, poisson_ratio = 0.25 /
    &joint name = 'dry', friction_angle = 30.0 /
    &region name = 'rock', outline = 0, 0, 4, 0, 4, 4, 0, 4 / &voronoi size = 1.0 /
    &fixed_point x = 0.1, y = 0.1 /"""
    file = tmp_path / "voronoi.nml"
    file.write_text(text)
    table = sitedda.study(file, seeds("voronoi.seed", 3), "largest_displacement_m",
                          executor=threads)  # fmt: skip
    assert counts(table) == {"complete": 3}, table.message.values
    assert len(set(table.largest_displacement_m.values)) == 3


# --- failures ------------------------------------------------------------------------------------


def test_a_failed_case_does_not_affect_others(file, threads):
    table = sitedda.study(file, {"material.rock.density": [2500.0, -1.0, 2600.0]}, KEPT,
                          executor=threads)  # fmt: skip
    assert table.status.values.tolist() == ["complete", "failed", "complete"]
    assert "density = -1 must be a positive number" in table.message.values[1]
    assert np.isnan(table["energy_balance.last"].values).tolist() == [False, True, False]


def test_processes_that_die_are_reported(tmp_path):
    kinds = ["well", "killed", "exits", "memory", "well too"]
    with_endless = {"kind": [*kinds, "endless"]}
    limits = {"workers": 2, "memory": 2e9, "time_limit": 1.0}
    folder = tmp_path / "study"
    table = sitedda.study(study_functions.troubled, with_endless, folder=folder, **limits)
    status = table.status.values.tolist()
    assert status == ["complete", "failed", "failed", "failed", "complete", "failed"]
    messages = table.message.values.tolist()
    assert "signal 9" in messages[1] and "status 3" in messages[2]
    assert "memory" in messages[3].lower()
    assert "time limit of 1 s" in messages[5]


def test_runs_without_convergence_or_beyond_the_time_limit_fail(write_input, threads):
    weak_joint = {"friction_angle": 10.0, "cohesion": None, "tensile_strength": None}
    groups = changed(tower(steps=20, gravity=[0.0, -9.81]), "joint", **weak_joint)
    file = write_input(changed(groups, "contact", max_iterations=2))
    table = sitedda.study(file, {"motion.scale": [1.0, 50.0]}, KEPT, executor=threads)
    assert table.status.values.tolist() == ["complete", "failed"]
    assert "does not converge" in table.message.values[1]
    durations = sitedda.study(COLUMN, {"duration": [0.01, 1e6]}, "largest_tilt_rad",
                         executor=threads, time_limit=12.0)  # fmt: skip
    assert durations.status.values.tolist() == ["complete", "failed"]
    assert "time limit of 12 s" in durations.message.values[1]


def test_three_kinds_of_failures_are_reported_and_the_rest_is_complete(write_input):
    """One input is refused, one does not converge, one needs more memory than a worker has."""
    kinds = {"material.density": [2643.0, -1.0, 2643.0, 2643.0, 2700.0],
             "contact.max_iterations": [50, 50, 2, 50, 50],
             "layers[layer].count": [3, 3, 3, 500_000, 3]}  # fmt: skip
    slippery = {"friction_angle": 10.0, "cohesion": None, "tensile_strength": None}
    shaken_input = changed(tower(steps=20, gravity=[0.0, -9.81]), "motion", scale=50.0)
    file = write_input(changed(shaken_input, "joint", **slippery))
    table = sitedda.study(file, Points("case_of", kinds), "largest_displacement_m", workers=2,
                          memory=1.5e9)  # fmt: skip
    assert table.status.values.tolist() == ["complete", *3 * ["failed"], "complete"]
    assert np.isfinite(table.largest_displacement_m).values.tolist() == [True, *3 * [False], True]
    refused_input, open_still, too_large = table.message.values[1:4]
    assert "density = -1 must be a positive number" in refused_input
    assert "step 1" in open_still and "does not converge" in open_still
    assert re.search(r"500\d* blocks needs [\d.]+ GB of memory, [\d.]+ GB are free", too_large)


# --- resumed, shared, refused --------------------------------------------------------------------


def test_a_study_continues_with_missing_cases(file, tmp_path, threads):
    study = tmp_path / "study"
    first = sitedda.study(file, {"motion.scale": [1.0, 2.0]}, KEPT, folder=study, executor=threads)
    keys = first.case.values
    stamps = [(case_folder(study, k) / "out.nc").stat().st_mtime_ns for k in keys]
    larger_study = sitedda.study(file, {"motion.scale": [1.0, 2.0, 3.0]}, [*KEPT, "verdict"],
                         folder=study, executor=threads)  # fmt: skip
    assert larger_study.case.values[:2].tolist() == keys.tolist()
    assert stamps == [(case_folder(study, k) / "out.nc").stat().st_mtime_ns for k in keys]
    assert np.all(np.isfinite(larger_study.largest_tilt_rad))


def test_a_failure_depends_on_results_and_limits(file, tmp_path, threads):
    """A failure is valid only for the same requested results and the same time limit."""

    def status(results=KEPT, **options):
        table = sitedda.study(file, {"motion.scale": [1.0]}, results, folder=tmp_path / "study",
                              executor=threads, **options)  # fmt: skip
        return table.status.item()

    assert status(time_limit=1e-9) == "failed"
    assert [status(study_functions.fails_once) for _ in range(2)] == 2 * ["failed"]
    assert status(study_functions.fails_once, retry=True) == "complete"
    (output,) = tmp_path.glob("study/cases/*/*/out.nc")
    time_of_run = output.stat().st_mtime_ns
    output.with_name("tried").unlink()
    assert status({"other": study_functions.fails_once}) == "failed"
    assert status() == "complete" and output.stat().st_mtime_ns == time_of_run


SHORT = {"duration": 1.0, "output.checkpoint_interval": 100}
ANGLES = {"joint[drums].friction_angle": [20.0, 30.0]}
KILLED = f"""
import sys, sitedda
sitedda.study(sys.argv[1], {ANGLES}, ["displacement[top].y"], folder=sys.argv[2], workers=1,
              fixed={SHORT})
"""


def test_a_study_of_a_killed_client_completes_bit_identically(tmp_path, threads):
    command = [sys.executable, "-c", KILLED, str(COLUMN), str(tmp_path / "killed")]
    with subprocess.Popen(command, start_new_session=True) as client:
        deadline = time.monotonic() + DEADLINE
        while not list(tmp_path.glob("killed/cases/*/*/out.nc*")) and time.monotonic() < deadline:
            time.sleep(0.02)
        client.kill()
    subprocess.run(command, check=True, timeout=DEADLINE)
    results = ["displacement[top].y"]
    reference = sitedda.study(COLUMN, ANGLES, results, executor=threads, fixed=SHORT)
    same(collect(tmp_path / "killed"), reference)


@pytest.fixture
def interrupted(file, tmp_path):
    """Return the folder of an interrupted case, with its checkpoint."""
    folder = tmp_path / "case"
    folder.mkdir()
    shutil.copy(file, folder / "model.nml")
    with sitedda.Simulation(folder / "model.nml", folder / "out.nc") as run:
        run.advance(30)
    return folder


def test_a_case_without_a_valid_checkpoint_starts_again(interrupted):
    (interrupted / "out.nc.checkpoint").write_bytes(b"")
    assert run_input(interrupted) == ""
    assert (interrupted / "out.nc").exists()


def test_a_checkpoint_that_cannot_be_written_keeps_the_results(interrupted, monkeypatch):
    def fail_to_write(*_):
        raise OutputError("out.nc.checkpoint.coming cannot be written: No space left on device")

    monkeypatch.setattr("sitedda.engine.simulation.Simulation.advance", fail_to_write)
    with pytest.raises(OutputError, match="No space left"):
        run_input(interrupted)
    monkeypatch.undo()
    with sitedda.Simulation(interrupted / "model.nml", interrupted / "out.nc", resume=True) as run:
        assert run.steps == 30


def test_only_one_client_executes_a_case(file, tmp_path):
    plan = make_plan(file, {"motion.scale": [1.0]}, KEPT, tmp_path / "study").write()
    work = Work(plan.folder, quantities=plan.quantities)
    folder = case_folder(plan.folder, plan.keys[0])
    with locked(folder, wait=False) as lock:
        assert lock
        assert carry_out(work, plan.keys[0])["status"] == "busy"
        assert read_result(folder) is None
    assert carry_out(work, plan.keys[0])["status"] == "complete"
    assert not list(folder.glob(".new-*")) and not list(folder.glob("out.nc.*"))


def test_the_key_covers_input_records_and_build(tmp_path, write_input, monkeypatch):
    (tmp_path / "quake.txt").write_text("0.0\n1.0\n0.0\n")
    groups = changed(tower(), "motion", file="quake.txt", unit="m/s2", format="text", values=None)
    file = write_input(groups)

    def key():
        return make_plan(file, {"motion.scale": [1.0]}, folder=tmp_path / "study").write().keys[0]

    first = key()
    assert key() == first
    (tmp_path / "quake.txt").write_text("0.0\n1.0\n0.1\n")
    second = key()
    file.write_text(file.read_text().replace("2643", "2644"))
    changed_key = key()
    monkeypatch.setattr("sitedda.study.plan.build", lambda: "another")
    assert len({first, second, changed_key, key()}) == 4
    text = (case_folder(tmp_path / "study", first) / "model.nml").read_text()
    assert "'../../../files/" in text and "quake" not in text.replace("motion_x = 'quake'", "")


def test_collect_reads_only_in_its_own_folder(file, tmp_path, threads):
    study = tmp_path / "study"
    table = sitedda.study(file, {"motion.scale": [1.0]}, KEPT, folder=study, executor=threads)
    folder = case_folder(study, table.case.item())
    folder.rename(tmp_path / "elsewhere")
    folder.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OutputError, match="is a symbolic link"):
        collect(study)
    manifest = json.loads((study / "study.json").read_text())
    manifest["cases"] = ["../../../../etc"]
    (study / "study.json").write_text(json.dumps(manifest))
    with pytest.raises(OutputError, match="not the key of a case"):
        collect(study)
    with pytest.raises(InputError, match="not the folder of a study"):
        collect(tmp_path)


def test_points_change_together():
    with pytest.raises(InputError, match="same number of values"):
        Points("pair", {"a.b": [1, 2], "a.c": [1]})
    pair = Points("pair", {"joint.friction_angle": [1, 2], "joint.cohesion": [3, 4]})
    assert pair.changes((1,)) == {"joint.friction_angle": 2, "joint.cohesion": 4}


def test_workers_are_an_executor():
    with Workers(1) as pool:
        assert list(pool.map(abs, [-1, 2])) == [1, 2]
        with pytest.raises(ValueError, match="math domain"):
            pool.submit(math.sqrt, -1.0).result()


def test_a_study_of_a_model_object(tmp_path):
    """The motion of the Model object is too long for the input itself."""
    model = sitedda.Model.from_namelist(namelist(tower()))
    model["motion.pulse"].values = np.sin(np.arange(5000) * 0.01)
    plan = make_plan(model, {"motion.scale": [1.0]}, folder=tmp_path / "study").write()
    text = (case_folder(plan.folder, plan.keys[0]) / "model.nml").read_text()
    name = text.partition("../../../files/")[2].partition("'")[0]
    assert np.loadtxt(plan.folder / "files" / name).size == 5000


def test_a_result_with_a_name_that_netcdf_does_not_allow_is_damaged(tmp_path):
    from sitedda.study.store import write_result

    write_result(tmp_path, "complete", numbers={"x" * 250: 1.0})
    assert read_result(tmp_path) is not None
    write_result(tmp_path, "complete", numbers={"x" * 300: 1.0})
    assert read_result(tmp_path) is None
