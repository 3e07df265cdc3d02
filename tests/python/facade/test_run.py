# SPDX-License-Identifier: GPL-3.0-or-later
"""Scripts that use the package: runs, histories, single steps, states, errors."""

import copy
import gc
import pickle
import sys
import time
import weakref

import numpy as np
import pytest
import xarray as xr
from environment import captured
from model_text import changed, flying_block, rectangle, tower, without
from numpy.testing import assert_allclose, assert_array_equal

import sitedda
from sitedda.study.records import Record, Records

GRAVITY = 9.81


# --- A whole run ---------------------------------------------------------------------------------


def test_a_run_completes_without_a_file(write_input, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = sitedda.run(write_input(tower(steps=30)), False)
    assert result.complete
    assert result.output is None
    assert "30 steps" in result.summary
    assert "A small tower" in repr(result) and "complete" in repr(result)
    assert [file.name for file in tmp_path.iterdir()] == ["model.nml"]


def test_history_has_dimensions_units_and_names(write_input):
    history = sitedda.run(write_input(tower(layers=3, steps=30))).history
    assert isinstance(history, xr.Dataset)
    assert dict(history.displacement.sizes) == {"time": 31, "point": 2, "axis": 2}
    assert history.block_coordinates.dims == ("frame", "block", "coordinate")
    assert history.block_coordinates.shape == (3, 4, 6)  # first, step 20, last
    assert history.vertices.shape == (3, 16, 2)
    assert_array_equal(history.vertex_block, np.repeat(np.arange(4), 4))
    assert list(history.point.values) == ["base", "surface"]
    assert_array_equal(history.time, np.arange(31) * 1e-3)
    assert_allclose(history.frame_time, [0.0, 0.02, 0.03], rtol=1e-15)
    assert_allclose(history.point_place.sel(point="surface"), [7.5, 3.0], rtol=1e-15)
    units = {
        "time": "s",
        "displacement": "m",
        "velocity": "m/s",
        "acceleration": "m/s^2",
        "block_stress": "Pa",
        "energy_kinetic": "J/m",
        "contact_normal_force": "N/m",
        "iterations": "1",
    }
    assert {name: history[name].attrs["units"] for name in units} == units


def test_every_variable_has_unit_and_meaning(write_input):
    history = sitedda.run(write_input(tower(steps=5))).history
    silent = [n for n, v in history.variables.items() if not {"units", "long_name"} <= set(v.attrs)]
    assert sorted(silent) == [
        *("block_coordinates", "block_rates"),
        *("largest", "largest_so_far", "residual"),
    ]
    assert history.maximum_unit.sel(maximum="tilt") == "rad"
    assert history.coordinate_unit.sel(coordinate="rotation") == "rad"
    assert history.rate_unit.sel(coordinate="rotation") == "rad/s"


def test_pint_reads_every_unit(write_input):
    pint = pytest.importorskip("pint")
    units = pint.UnitRegistry()
    bolt = {"name": "tie", "from": [7.5, 0.5], "to": [7.5, 1.5], "axial_stiffness": 1e6}
    file = write_input([*tower(steps=5), ("bolt", bolt)])
    history = sitedda.run(file).history
    assert "bolt_force" in history
    layer = sitedda.Layer(9.0, density=2e3, shear_velocity=2e2, damping=0.05)
    response = sitedda.Column([layer]).response(history.acceleration[:, 0, 0], 1e-3)
    levels = [Records([Record("a", np.ones(9), 0.01)], [1.0], measure=m, period=0.5)
              for m in ("scale", "pga", "pgv", "sa", "arias")]  # fmt: skip
    texts = [a["units"] for level in levels for *_, a in level.coordinates.values() if a]
    for data in (history, response.profile()):
        texts += [v.attrs["units"] for v in data.variables.values() if "units" in v.attrs]
    for text in (*texts, *history.coordinate_unit.values, *history.rate_unit.values):
        units(str(text))
    force = history.block_density * history.acceleration.max()
    assert force.size and (1 * units("kg/m^3") * units("m/s^2")).check("[force]/[volume]")


def test_any_reader_of_netcdf_selects_by_names(write_input, tmp_path):
    output = tmp_path / "t.nc"
    sitedda.run(write_input(changed(tower(steps=40), "output", block_interval=10)), output)
    with xr.open_dataset(output) as data:
        stress = data.block_stress.sel(block="layer_2", component="yy")
        assert_array_equal(stress, data.block_stress.values[:, 2, 1])
        assert stress.sel(frame=0.019, method="nearest").frame_time == 0.02
        assert list(data.axis.values) == ["x", "y"]
        assert data.block_coordinates.sel(coordinate="rotation").coordinate_unit == "rad"
        assert {"stage", "frame_stage", "block_removal"} <= set(data.coords)


def test_frames_and_blocks_have_their_stages(write_input):
    groups = without(tower(3, gravity=[0.0, -9.81], steps=None), "output")
    groups += [
        ("stage", {"name": "rest", "kind": "static"}),
        ("stage", {"name": "shake", "steps": 20}),
        ("stage", {"name": "dig", "kind": "static", "remove": "layer_3"}),
        ("stage", {"name": "again", "steps": 10}),
        ("output", {"block_interval": 10}),
    ]
    groups = [pair for pair in groups if pair[1].get("name") != "surface"]
    history = sitedda.run(write_input(groups)).history
    assert_array_equal(history.frame_stage, [2, 2, 2, 3, 4])
    assert_array_equal(history.block_removal, [0, 0, 0, 3])


def test_properties_of_the_material_are_in_the_history(write_input):
    history = sitedda.run(write_input(tower(steps=2))).history
    assert_allclose(history.block_density, 2643.0, rtol=1e-12)
    assert_allclose(history.block_shear_modulus, 4.788e9 / 2.5, rtol=1e-12)


def test_history_interval_reduces_the_samples(write_input):
    groups = changed(tower(steps=30), "output", history_interval=7)
    every_sample = sitedda.run(write_input(tower(steps=30))).history
    some_samples = sitedda.run(write_input(groups)).history
    samples = [0, 7, 14, 21, 28, 30]  # always with the last one
    assert_array_equal(some_samples.time, every_sample.time[samples])
    assert_array_equal(some_samples.displacement, every_sample.displacement[samples])


def test_a_dataset_has_the_verdict_and_pictures_of_its_run(write_input, tmp_path):
    file = tmp_path / "tower.nc"
    run = sitedda.run(write_input(tower(layers=3, steps=30)), output=file)
    assert str(run.history.sitedda.verdict) == str(run.verdict)
    with sitedda.open_output(file) as data:
        assert str(data.sitedda.verdict) == str(run.verdict)
        assert len(data.sitedda.draw().patches) == len(run.draw().patches)
        assert data.sitedda.report(tmp_path / "again.html").stat().st_size > 1000


def test_output_is_written_to_the_given_path(write_input, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = write_input(tower(steps=5))
    for output, expected in (
        ("text.nc", tmp_path / "text.nc"),
        (tmp_path / "path.nc", tmp_path / "path.nc"),
        (True, tmp_path / "tower.nc"),
    ):
        result = sitedda.run(file, output)
        assert result.output.resolve() == expected
        with xr.open_dataset(expected) as dataset:
            assert dataset.attrs["complete"] == "yes"
    assert not list(tmp_path.glob("*.partial"))


def test_progress_receives_the_run(write_input):
    calls = []
    file = write_input(tower(steps=500))
    sitedda.run(file, progress=lambda s: calls.append((s.time, s.duration)))
    times = [time for time, _ in calls]
    assert times == sorted(times) and len(times) >= 2
    assert times[-1] == pytest.approx(0.5, rel=1e-12)
    assert {duration for _, duration in calls} == {0.5}


def test_an_interrupted_run_keeps_its_results(write_input, tmp_path):
    def interrupt(simulation):
        raise KeyboardInterrupt

    final = tmp_path / "kept.nc"
    sitedda.run(write_input(tower(steps=3)), final)
    older = final.read_bytes()
    result = sitedda.run(write_input(tower(steps=5000)), final, progress=interrupt)
    assert not result.complete and "incomplete" in repr(result)
    assert result.output == tmp_path / "kept.nc.partial" and result.output.exists()
    assert 1 < result.history.time.size < 5001
    assert result.history.attrs["complete"] == "no"
    assert final.read_bytes() == older


def test_phases_add_up_to_the_time_of_the_steps(write_input):
    """After the first call, the phases contain all time of the steps, and no more."""
    with sitedda.Simulation(write_input(tower(steps=2000))) as run:
        run.advance(10)
        assert not any(run.phase_times().values())
        begun = time.perf_counter()
        run.advance(1500)
        elapsed = time.perf_counter() - begun
        phase_times = run.phase_times()
    # Not needed, because neighbours and states do not change.
    unused_phases = ("search", "factorise")
    assert all(seconds > 0 for name, seconds in phase_times.items() if name not in unused_phases)
    assert 0.3 * elapsed < sum(phase_times.values()) <= elapsed


# --- Changes -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "group", "values"),
    [
        ({"time_step": 5e-4}, "control", {"time_step": 5e-4}),
        ({"steps": 17}, "control", {"steps": 17}),
        ({"duration": 0.02}, "control", {"steps": None, "duration": 0.02}),
        ({"gravity": [0.0, -9.81]}, "control", {"gravity": [0.0, -9.81]}),
        ({"analysis": "plane_strain"}, "control", {"analysis": "plane_strain"}),
        ({"title": "It's another"}, "run", {"title": "It's another"}),
        ({"normal_stiffness": 1e11}, "contact", {"normal_stiffness": 1e11}),
        ({"contact": {"shear_ratio": 3.0}}, "contact", {"shear_ratio": 3.0}),
        ({"block_interval": 3}, "output", {"block_interval": 3}),
        ({"material": {"density": 2000.0}}, "material", {"density": 2000.0}),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_a_change_equals_a_changed_input(write_input, same_bits, change, group, values):
    groups = tower(steps=30)
    result = sitedda.run(write_input(groups), **change)
    other = sitedda.run(write_input(changed(groups, group, **values), "other.nml"))
    same_bits(result.history, other.history, attributes=("title",))


def test_a_change_adds_a_group_that_the_input_lacks(write_input, same_bits):
    groups = without(tower(steps=10), "contact")
    groups_with_contact = changed([("contact", {}), *groups], "contact", normal_stiffness=2e11)
    result = sitedda.run(write_input(groups), normal_stiffness=2e11)
    other = sitedda.run(write_input(groups_with_contact, "other.nml"))
    same_bits(result.history, other.history, attributes=("title",))


def test_changes_apply_to_windows_line_ends_and_byte_order_marks(write_input, same_bits):
    plain_file = write_input(tower(steps=10))
    text = b"\xef\xbb\xbf" + plain_file.read_bytes().replace(b"\n", b"\r\n")
    marked = write_input(text, "marked.nml")
    one, other = sitedda.run(plain_file, steps=12), sitedda.run(marked, steps=12)
    same_bits(one.history, other.history, attributes=("title",))


# --- Step by step --------------------------------------------------------------------------------


def test_advance_counts_steps_and_stops_at_the_end(write_input):
    with sitedda.Simulation(write_input(tower(steps=25))) as simulation:
        assert (simulation.steps, simulation.time, simulation.done) == (0, 0.0, False)
        assert simulation.advance(0) is False and simulation.steps == 0
        assert simulation.advance() is False and simulation.steps == 1
        assert simulation.advance(10) is False and simulation.steps == 11
        assert_allclose(simulation.time, 0.011, rtol=1e-14)
        assert simulation.time_step == 1e-3 and simulation.iterations >= 1
        assert simulation.advance(1000) is True and simulation.steps == 25
        assert simulation.advance() is True and simulation.steps == 25
        assert simulation.duration == pytest.approx(0.025)


def test_single_steps_equal_many_steps_at_once(write_input):
    file = write_input(tower(steps=40))
    history = sitedda.run(file).history
    with sitedda.Simulation(file) as simulation:
        motions = [simulation.point_motions]
        while not simulation.done:
            simulation.advance()
            motions.append(simulation.point_motions)
    motions = np.array(motions)  # [time, kind, point, axis]
    for kind, name in enumerate(("displacement", "velocity", "acceleration")):
        assert_array_equal(motions[:, kind], history[name])


def test_states_are_those_of_the_last_frame(write_input):
    file = write_input(tower(steps=20))
    history = sitedda.run(file).history
    with sitedda.Simulation(file) as simulation:
        simulation.advance(20)
        assert_array_equal(simulation.coordinates, history.block_coordinates[-1])
        assert_array_equal(simulation.rates, history.block_rates[-1])
        assert_array_equal(simulation.stresses, history.block_stress[-1])
        assert_array_equal(np.concatenate(simulation.polygons), history.vertices[-1])
        energies = simulation.energies
        assert {f"energy_{name}" for name in energies} <= set(history.variables)
        assert all(history[f"energy_{name}"][-1] == value for name, value in energies.items())
        contacts = simulation.contacts
        last = history.contact_frame.values == history.sizes["frame"] - 1
        of_laws = {"length", "slip_path", "weakened", "place", "damage"}  # this joint has none
        of_laws |= {"fracture_energy_lower", "fracture_energy_upper", "net_slip", "lifted"}
        of_laws |= {"reversal", "slip_direction", "age", "slip_rate", "slip_share", "crushed"}
        assert {name for name in contacts if f"contact_{name}" not in history} == of_laws
        for name in contacts.keys() - of_laws:
            frame_values = history[f"contact_{name}"].values[last]
            assert_array_equal(contacts[name], frame_values, err_msg=name)


def test_names_and_title(write_input):
    groups = changed(tower(layers=2), "run", title="Größe α")
    with sitedda.Simulation(write_input(groups)) as simulation:
        assert simulation.title == "Größe α"
        assert simulation.point_names == ["base", "surface"]
        assert simulation.block_names == ["base_1", "layer_1", "layer_2"]


def test_the_first_state_is_the_input(write_input):
    outline = [0.0, 0.0, 3.0, 0.0, 3.0, 2.0, 1.0, 2.0, 1.0, 1.0, 0.0, 1.0]  # an L-shaped block
    groups = changed(flying_block(), "block", vertices=outline)
    with sitedda.Simulation(write_input(groups)) as simulation:
        assert_allclose(simulation.polygons[0].ravel(), outline, atol=1e-15)
        # 3 x 1 below, 2 x 1 above it: area 5, centroid by parts
        assert_allclose(simulation.coordinates[0, :2], [(4.5 + 4.0) / 5, (1.5 + 3.0) / 5])
        assert_array_equal(simulation.coordinates[0, 2:], 0.0)
        assert_array_equal(simulation.rates, 0.0)


def test_a_thrown_block_flies_on_a_parabola(write_input):
    # The scheme assumes constant acceleration in a step, so a parabola is exact.
    groups = flying_block(steps=50, gravity=[0.0, -GRAVITY], max_displacement_ratio=0.5)
    speed = np.array([3.0, 5.0])
    with sitedda.Simulation(write_input(groups)) as simulation:
        simulation.rates = [[*speed, 0.0, 0.0, 0.0, 0.0]]
        simulation.advance(50)
        time = simulation.time
        flight = speed * time - [0.0, 0.5 * GRAVITY * time**2]
        assert_allclose(simulation.coordinates[0, :2], flight + [1.0, 0.5], rtol=1e-12)
        assert_allclose(simulation.rates[0, :2], speed - [0.0, GRAVITY * time], rtol=1e-12)
        displacement, velocity, acceleration = simulation.point_motions[:, 0]
        assert_allclose(displacement, flight, rtol=1e-11)
        assert_allclose(velocity, speed - [0.0, GRAVITY * time], rtol=1e-12)
        assert_allclose(acceleration, [0.0, -GRAVITY], atol=1e-9)


def test_rates_have_their_kinetic_energy(write_input):
    groups = flying_block(steps=1)
    mass, spin = 2.0 * 1.0 * 2643.0, 0.3
    moment = mass * (2.0**2 + 1.0**2) / 12
    with sitedda.Simulation(write_input(groups)) as simulation:
        simulation.rates = np.array([[1.5, 0.0, spin, 0.0, 0.0, 0.0]])
        assert_array_equal(simulation.rates, [[1.5, 0.0, spin, 0.0, 0.0, 0.0]])
        simulation.advance()
        expected = 0.5 * mass * 1.5**2 + 0.5 * moment * spin**2
        assert_allclose(simulation.energies["kinetic"], expected, rtol=1e-6)


def test_a_resting_block_weighs_half_on_each_contact(write_input):
    groups = [
        ("control", {"time_step": 1e-2, "steps": 20, "dynamic_factor": 0.0, "gravity": [0.0, -10]}),
        ("contact", {"normal_stiffness": 1e9}),
        ("material", {"density": 2000.0, "young_modulus": 1e9, "poisson_ratio": 0.0}),
        ("joint", {"friction_angle": 30.0}),
        ("block", {"name": "ground", "vertices": rectangle(0, 0, 4, 1)}),
        ("block", {"name": "brick", "vertices": rectangle(1, 1, 2, 1)}),
        *(("fixed_point", {"x": x, "y": 0.5}) for x in (1.0, 3.0)),
    ]
    with sitedda.Simulation(write_input(groups)) as simulation:
        simulation.advance(20)
        contacts = simulation.contacts
        is_pressed = contacts["normal_force"] > 0
        assert_allclose(contacts["normal_force"][is_pressed], [20e3, 20e3], rtol=1e-6)
        assert_allclose(contacts["gap"][is_pressed], -20e3 / 1e9, rtol=1e-6)
        assert set(contacts["state"][is_pressed]) == {2}
        assert_allclose(simulation.stresses[1, 1], -0.5 * 2000 * 10 * 1.0, rtol=1e-6)


# --- Opening and closing -------------------------------------------------------------------------


def test_a_forgotten_simulation_is_freed_and_its_file_closed(write_input, tmp_path):
    simulation = sitedda.Simulation(write_input(tower(steps=50)), tmp_path / "out.nc")
    simulation.advance(10)
    reference = weakref.ref(simulation)
    del simulation
    gc.collect()
    assert reference() is None
    with xr.open_dataset(tmp_path / "out.nc.partial", engine="netcdf4") as dataset:
        assert dataset.attrs["complete"] == "no"
        assert dataset.sizes["time"] == 11
    assert not (tmp_path / "out.nc").exists()


def test_two_simulations_at_once_are_independent(write_input, same_bits, tmp_path):
    files = write_input(tower(2, steps=60), "a.nml"), write_input(tower(5, steps=60), "b.nml")
    simulations = [sitedda.Simulation(file, tmp_path / f"{file.stem}.nc") for file in files]
    for _ in range(20):
        for simulation in simulations:
            simulation.advance(3)
    for simulation, file in zip(simulations, files, strict=True):
        simulation.finish()
        simulation.close()
        same_bits(sitedda.run(file).history, tmp_path / f"{file.stem}.nc")


def test_whole_runs_in_threads_do_not_crash(write_input):
    """The file libraries are not thread-safe; a separate process protects the tests."""
    file = write_input(tower(3, steps=2000))
    code = f"""
import sys
from concurrent.futures import ThreadPoolExecutor
import sitedda
def last(_):
    return float(sitedda.run({str(file)!r}, False).history.displacement[-1, 1, 0])
with ThreadPoolExecutor(8) as pool:
    displacements = set(pool.map(last, range(80)))
sys.exit(0 if len(displacements) == 1 else 7)
"""
    process = captured([sys.executable, "-c", code])
    assert process.returncode == 0, process.stderr


# --- Errors --------------------------------------------------------------------------------------


KINDS = [
    (sitedda.InputError, 1, ValueError),
    (sitedda.CheckError, 2, sitedda.SiteddaError),
    (sitedda.ConvergenceError, 3, ArithmeticError),
    (sitedda.SolverError, 4, ArithmeticError),
    (sitedda.OutputError, 5, OSError),
    (sitedda.InterruptedRun, 6, sitedda.SiteddaError),
    (sitedda.CheckpointError, 8, sitedda.OutputError),
]


@pytest.mark.parametrize(("kind", "number", "parent"), KINDS)
def test_errors_survive_a_pickle_and_a_copy(kind, number, parent):
    error = sitedda.SiteddaError.of(number, "step 3: größer")
    assert type(error) is kind and isinstance(error, parent)
    for clone in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
        assert type(clone) is kind
        assert (str(clone), clone.kind) == ("step 3: größer", kind.kind)


def test_an_error_of_the_caller_is_not_replaced(write_input, tmp_path):
    def fail(simulation):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        sitedda.run(write_input(tower(steps=5000)), tmp_path / "out.nc", progress=fail)
    with xr.open_dataset(tmp_path / "out.nc.partial", engine="netcdf4") as dataset:
        assert dataset.attrs["complete"] == "no"
    assert not (tmp_path / "out.nc").exists()


def test_an_input_error_leaves_no_open_file(write_input):
    invalid_input = write_input(changed(tower(), "control", steps=-1), "bad.nml")
    with sitedda.Simulation(write_input(tower(steps=5))) as simulation:
        for _ in range(100):
            with pytest.raises(sitedda.InputError):
                sitedda.Simulation(invalid_input)
        assert simulation.advance(5)
