# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies of cells compared with closed forms and with an independent assembly."""

import re

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from scipy.linalg import eigh
from scipy.optimize import brentq
from strain_points import Body
from test_meshing import CELLS, part

import sitedda
from sitedda.building import build_file
from sitedda.drawing.quantities import quantity
from sitedda.drawing.stress_crosses import TENSION, draw_crosses, largest_stress
from sitedda.meshing.body import mesh_body
from sitedda.output import load
from sitedda.pictures import _picture_text
from sitedda.scene import Scene
from sitedda.vtk import blocks_of

YOUNG, DENSITY = 1e10, 2500.0


def cells_of(box, size, cells="quadrilateral"):
    """Cells of a box (left, bottom, right, top)."""
    left, bottom, right, top = box
    outline = [left, bottom, right, bottom, right, top, left, top]
    return mesh_body([part(outline, size)], cells).polygons


def hold(model, cells, axis: str, **motions) -> None:
    """Fixed points at the corners of cells whose x, or y, is 0."""
    for number, cell in enumerate(cells, 1):
        for x, y in cell:
            if {"x": x, "y": y}[axis] < 1e-9:
                model.fixed_point(x=x, y=y, block=str(number), **motions)


def model_of(bodies, poisson=0.25, young=YOUNG, **control):
    """Bodies of cells, by their numbers from 1; (polygon, material) is also accepted as a cell."""
    model = sitedda.Model()
    control = {"time_step": 1e-3, "steps": 10, "gravity": [0.0, 0.0]} | control
    model.control(**({"analysis": "plane_stress"} | control))
    model.material(name="rock", density=DENSITY, young_modulus=young, poisson_ratio=poisson)
    model.joint(name="joint", friction_angle=30.0)
    for number, cells in enumerate(bodies, 1):
        for cell in cells:
            polygon, material = cell if isinstance(cell, tuple) else (cell, "rock")
            model.block(vertices=np.ravel(polygon).tolist(), body=f"b{number}", material=material)
    return model


@pytest.mark.parametrize("strain", ["plane_stress", "plane_strain"])
@pytest.mark.parametrize("poisson", [0.0, 0.25, 0.4999])
@pytest.mark.parametrize("cells", CELLS)
def test_modes_of_a_free_beam_are_those_of_an_independent_assembly(cells, poisson, strain):
    polygons = cells_of((0, 0, 6, 1), 0.5, cells)
    frequencies = sitedda.modes(model_of([polygons], poisson, analysis=strain), count=12).frequency
    body = Body(polygons, YOUNG, poisson, DENSITY, plane_strain=strain == "plane_strain")
    values = eigh(body.stiffness().toarray(), body.mass().toarray(), eigvals_only=True)
    np.testing.assert_allclose(frequencies, np.sqrt(values[3:15]) / (2 * np.pi), rtol=1e-7)


def test_partly_overlapping_faces_are_welded():
    """A row of long cells on a row of short ones has the modes of the independent assembly."""
    low = [cell for x in range(6) for cell in cells_of((x, 0, x + 1, 1), 1.0)]
    high = [cell for x in (0, 2.5) for cell in cells_of((x, 1, x + 2.5, 2), 2.5)]
    frequencies = sitedda.modes(model_of([low[:5] + high]), count=9).frequency
    body = Body(low[:5] + high, YOUNG, 0.25, DENSITY, plane_strain=False)
    values = eigh(body.stiffness().toarray(), body.mass().toarray(), eigvals_only=True)
    np.testing.assert_allclose(frequencies, np.sqrt(values[3:12]) / (2 * np.pi), rtol=1e-7)


def test_two_layers_of_contrast_1000_have_the_frequency_of_the_closed_form():
    """tan(k₁h) tan(k₂h) = impedance ratio of upper to lower layer, to 0.3 % with 4 cells each."""
    soft, height = YOUNG / 1000, 4.0
    low, high = cells_of((0, 0, 1, 4), 1.0), cells_of((0, 4, 1, 8), 1.0)
    model = model_of([low + [(cell, "soil") for cell in high]], 0.0)
    model.material(name="soil", density=DENSITY, young_modulus=soft, poisson_ratio=0.0)
    model.contact(normal_stiffness=1e6 * YOUNG)
    for number, cell in enumerate(low + high, 1):
        for x, y in cell:
            direction_of_point = {} if y < 1e-9 else {"direction": "y"}
            model.fixed_point(x=x, y=y, block=str(number), **direction_of_point)
    speeds = np.sqrt([YOUNG / 2 / DENSITY, soft / 2 / DENSITY])

    def closed_form(omega):
        return np.prod(np.tan(omega * height / speeds)) - speeds[0] / speeds[1]

    exact = brentq(closed_form, 1e-3, (np.pi / 2 - 1e-9) * speeds[1] / height) / (2 * np.pi)
    assert sitedda.modes(model, count=1).frequency[0] == pytest.approx(exact, rel=3e-3)


def test_a_cantilever_has_the_deflection_and_the_stress_of_a_beam():
    """q l⁴/8EI + q l²/2κGA within 1.5 % with four cells over the depth; the mean stress of the
    upper half over one metre within 5 %."""
    cells = cells_of((0, 0, 10, 1), 0.25)
    model = model_of([cells], 0.0, gravity=[0.0, -10.0], steps=None)
    hold(model, cells, "x")
    model.measured_point(name="tip", x=10.0, y=0.5)
    model.contact(normal_stiffness=1e4 * YOUNG)
    model.stage(name="rest", kind="static")
    history = model.run().history
    load = DENSITY * 10.0
    exact = load * 10**4 / (8 * YOUNG / 12) + load * 10**2 / (2 * 5 / 6 * YOUNG / 2)
    assert -float(history.displacement[-1, 0, 1]) == pytest.approx(exact, rel=0.015)
    x, y = history.block_coordinates.values[-1, :, :2].T
    upper = history.block_stress.values[-1, (y > 0.5) & (abs(x - 5) < 0.5), 0]
    assert upper.mean() == pytest.approx(load * 5**2 / 2 * 12 * 0.25, rel=0.05)


def test_the_shipped_roof_beam_is_a_beam(root):
    """Deflection within 1.5 % of theory with shear, stress of the lowest cells within 4 %."""
    history = sitedda.run(root / "inputs" / "roof_beam.nml").history
    load, span, depth, young = 30e3 + 0.6 * 2600 * 9.81, 6.0, 0.6, 20e9
    inertia, shear = depth**3 / 12, young / 2.4
    sag = 5 * load * span**4 / (384 * young * inertia)
    sag += load * span**2 / (8 * 5 / 6 * shear * depth)
    assert -float(history.displacement[-1, 0, 1]) == pytest.approx(sag, rel=0.015)
    x, y = history.block_coordinates.values[-1, :, :2].T
    low = (y < 0.05) & (abs(x - span / 2) < 0.05)
    stress = load * span**2 / 8 / inertia * (depth / 2 - 0.0375)
    assert history.block_stress.values[-1, low, 0].mean() == pytest.approx(stress, rel=0.04)


def test_the_shipped_tunnel_is_that_of_kirsch(root):
    """Walls within 2.5 % of Kirsch's solution, hoop stress beside the walls within 3 %."""
    history = sitedda.run(root / "inputs" / "circular_tunnel.nml").history
    pressure, ratio, radius, young, poisson = 5e6, 0.5, 2.0, 10e9, 0.25
    displacement = history.displacement.values[-1]  # crown, invert, left, right
    crown = (displacement[1, 1] - displacement[0, 1]) / 2
    side = (displacement[2, 0] - displacement[3, 0]) / 2
    mean, half = (1 + ratio) * pressure / 2, (1 - ratio) * (3 - 4 * poisson) * pressure / 2
    factor = (1 + poisson) * radius / young
    assert crown == pytest.approx(factor * (mean + half), rel=0.025)
    assert side == pytest.approx(factor * (mean - half), rel=0.025)
    centre = history.block_coordinates.values[-1, :, :2]
    r, angle = np.hypot(*centre.T), np.arctan2(*abs(centre.T[::-1]))
    at_wall = (r < 2.12) & (angle < np.radians(10))
    inward = (radius / r[at_wall].mean()) ** 2
    hoop = mean * (1 + inward) + (1 - ratio) / 2 * pressure * (1 + 3 * inward**2)
    stress = -history.block_stress.values[-1, at_wall, 1].mean()
    assert stress == pytest.approx(hoop, rel=0.03)


def spinning(step, rate=3.0):
    """A beam of random polygons that rotates about its middle for a third of a second."""
    cells = cells_of((0, 0, 10, 1), 0.4, "voronoi")
    model = model_of([], time_step=step, steps=round(1 / (3 * step)), integration="midpoint")
    for number, (cell, centre) in enumerate(zip(cells, Body(cells).centres, strict=True)):
        x, y = (centre - [5.0, 0.5]).tolist()
        model.material(
            name=f"m{number}", density=DENSITY, young_modulus=YOUNG, poisson_ratio=0.25,
            initial_velocity=[-rate * y, rate * x, rate],
        )  # fmt: skip
        model.block(vertices=np.ravel(cell).tolist(), body="beam", material=f"m{number}")
    return model


def test_a_spinning_body_keeps_its_energy_and_balances():
    energy_gain = []
    for step in (2e-3, 1e-3):
        history = spinning(step).run().history
        kinetic = float(history.energy_kinetic[0])
        assert abs(history.energy_balance.values).max() < 1e-9 * kinetic
        energy_gain.append(abs(float(history.energy_geometric[-1])) / kinetic)
        assert float(history.energy_welded.max()) < 1e-3 * kinetic
        rotation = history.block_coordinates.values[-1, :, 2]
        np.testing.assert_allclose(rotation, 1.0, atol=3e-3)
    assert energy_gain[0] < 1e-5
    assert energy_gain[1] < 1e-6


RAYLEIGH = {"rayleigh_alpha": 3.0, "rayleigh_beta": 1e-4}
CONSTANT = {"damping_ratio": 0.03, "reference_frequency": 20.0}


@pytest.mark.parametrize("soft", [1.0, 4.0])
@pytest.mark.parametrize("damping", [RAYLEIGH, CONSTANT], ids=["rayleigh", "constant"])
def test_materials_of_a_body_damp_its_modes(damping, soft):
    """(α/ω + βω)/2 to rounding, ζ within 0.1 %; time stepping within 5 %, with balanced energy."""
    low, high = cells_of((0, 0, 8, 0.5), 0.5), cells_of((0, 0.5, 8, 1), 0.5)
    step, steps = 2e-4, 400
    model = model_of([low + [(cell, "other") for cell in high]], time_step=step, steps=steps,
                     integration="midpoint")  # fmt: skip
    model.material(name="other", density=DENSITY, young_modulus=YOUNG / soft, poisson_ratio=0.25)
    for material in model["material"]:
        material(**damping)
    modes = sitedda.modes(model, count=1)
    omega, ratio = 2 * np.pi * modes.frequency[0], modes.damping[0]
    if damping is RAYLEIGH:
        assert ratio == pytest.approx((3.0 / omega + 1e-4 * omega) / 2, rel=1e-9)
    else:
        assert ratio == pytest.approx(0.03, rel=1e-3)
    with sitedda.Simulation(model) as run:
        run.rates = modes.shapes[0]
        before = run.energies["kinetic"]
        run.advance(steps)
        energies = run.energies
    energy = sum(energies[name] for name in ("kinetic", "strain", "welded"))
    assert -np.log(energy / before) / (2 * omega * steps * step) == pytest.approx(ratio, rel=0.05)
    assert abs(energies["balance"]) < 1e-9 * before
    assert energies["material_damping"] == pytest.approx(before - energy, rel=2e-2)


def test_damping_is_reset_by_a_static_stage():
    """The energy of the relaxation springs is booked at a static stage after a damped one."""
    cells = cells_of((0, 0, 4, 1), 0.5)
    model = model_of([cells], gravity=[0.0, -10.0], steps=None)
    model["material"][0].damping_ratio = 0.05
    hold(model, cells, "x")
    model.stage(name="fall", steps=50)
    model.stage(name="rest", kind="static")
    model.stage(name="go", steps=20)
    history = model.run().history
    turnover = float(history.energy_algorithmic[-1]) + float(history.energy_welded[-1])
    assert abs(history.energy_balance.values).max() < 1e-6 * turnover
    assert abs(float(history.energy_geometric[-1])) < 1e-2 * turnover


def sliding(floor, block, steps=1200):
    """Cells that slide on cells with non-matching faces, on a slope of 30°."""
    model = model_of([floor, block], young=1e12, time_step=1e-3, steps=steps,
                     gravity=[5.0, -10 * np.cos(np.pi / 6)])  # fmt: skip
    hold(model, floor, "y")
    model.measured_point(name="block", x=2.0, y=1.5)
    return model


def test_soft_contacts_keep_a_block_above_the_gaps_of_cells():
    """The penetration is 2 cm at rest with cells of 25 cm; at most twice this under sudden load."""
    depth, block = 0.02, [np.array([[1, 1], [3, 1], [3, 3], [1, 3]])]
    model = sliding(cells_of((0, 0, 8, 1), 0.25), block, steps=1500)
    model["joint"][0].friction_angle = 20.0
    model.contact(normal_stiffness=4 * DENSITY * 10 * np.cos(np.pi / 6) / 2 / depth)
    model["control"].max_displacement_ratio = 0.05
    position = model.run().history.displacement[:, 0].values
    assert position[:, 1].min() > -2 * depth
    assert position[-1, 0] > 2.0  # it has slid over eight cells


def wedge(cells):
    """A wedge on a fixed plane of 30°."""
    model = sitedda.Model()
    model.control(time_step=1e-3, gravity=[0.0, -9.81], steps=1)
    model.material(name="rock", density=DENSITY, young_modulus=YOUNG, poisson_ratio=0.25)
    model.joint(name="joint", friction_angle=40.0)
    model.block(name="slope", vertices=[0, 0, 12, 0, 12, 12 * 3**-0.5])
    rotation = np.array([[3**0.5 / 2, 0.5], [-0.5, 3**0.5 / 2]])
    box = np.array([[5, 0], [7.5, 0], [7.5, 2], [5, 2]]) @ rotation
    model.block(name="wedge", vertices=box.ravel().tolist())
    if cells:
        model.mesh(blocks="wedge", size=float(np.sqrt(5 / cells)))
    for x, y in ((1, 0.2), (11, 0.2), (11.5, 6)):
        model.fixed_point(x=x, y=y, block="slope")
    return model


@pytest.mark.parametrize("cells", [0, 4, 16, 64])
def test_the_factor_of_safety_does_not_depend_on_cells(cells):
    """tan 40°/tan 30° within 0.1 %; the mechanism contains two blocks."""
    result = sitedda.safety(wedge(cells))
    exact = np.tan(np.radians(40)) / np.tan(np.radians(30))
    assert result.low == pytest.approx(exact, rel=1e-3)
    assert result.mechanism.names == ("slope", "wedge")
    assert result.mechanism.verdicts == ("stable", "slides")
    assert len(result.mechanism.polygons[1]) >= 4
    assert result.mechanism.areas[0] == pytest.approx(5.0)
    result.mechanism.draw()


@pytest.mark.parametrize("damping", [{}, CONSTANT], ids=["elastic", "damped"])
def test_threads_and_resumed_runs_are_bit_identical(damping, tmp_path, same_everywhere):
    cells = cells_of((0, 0, 8, 1), 1.0)
    model = sliding(cells, cells_of((1, 1.01, 3, 2.01), 0.3, "voronoi"), steps=300)
    model["material"][0](**damping)
    model.output(block_interval=100)
    file = model.write(tmp_path / "model.nml")
    reference = same_everywhere(file, 210)
    assert reference.block_body.values.tolist() == [1] * 8 + [2] * (reference.sizes["block"] - 8)
    assert reference.body.values.tolist() == ["b1", "b2"]


def test_a_meshed_input_built_into_a_block_file_runs_without_python(root, tmp_path, binary):
    """The displacements equal those of cells in memory."""
    reference = sitedda.run(root / "inputs" / "roof_beam.nml").history
    file, _ = build_file(root / "inputs" / "roof_beam.nml", tmp_path / "beam.nml", True)
    binary.ok("run", file, "-q", "-o", tmp_path / "beam.nc")
    built_output = load(tmp_path / "beam.nc")
    assert built_output.body.values.tolist() == ["beam"]
    for name in ("displacement", "block_coordinates", "block_stress"):
        np.testing.assert_array_equal(built_output[name], reference[name])


def test_check_bounds_the_ringing_of_a_body_by_beta():
    """Steps to 1/e of the stiffest mode: |1 − βω²Δt/2|/(1 + βω²Δt/2), a bound within factor 3."""
    step, beta, cells = 1e-3, 1e-4, cells_of((0, 0, 4, 1), 0.5)
    model = model_of([cells], time_step=step, integration="midpoint")
    model["material"][0].rayleigh_alpha, model["material"][0].rayleigh_beta = 0.0, beta
    body = Body(cells, YOUNG, 0.25, DENSITY, plane_strain=False)
    stiffest = eigh(body.stiffness().toarray(), body.mass().toarray(), eigvals_only=True)[-1]
    half = beta * stiffest * step / 2
    steps = -1 / np.log((half - 1) / (half + 1))
    line = next(one for one in sitedda.check(model).lines if one.topic == "Rayleigh damping")
    step_count = float(re.search(r"decays to 1/e in ([0-9.e+]+) steps", line.words)[1])
    assert 0.999 * steps < step_count < 3 * steps


def propped(**stage):
    """A beam with a fixed left end under a body: a static stage, then another stage."""
    beam, load = cells_of((0, 0, 4, 1), 0.5), cells_of((3, 1, 4, 2), 0.5)
    model = model_of([beam, load], gravity=[0.0, -10.0], steps=None)
    model.material(name="soft", density=DENSITY, young_modulus=YOUNG / 10, poisson_ratio=0.25)
    hold(model, beam, "x")
    model.measured_point(name="load", x=3.5, y=1.9, block="b2")
    model.stage(name="rest", kind="static")
    model.stage(name="next", **stage)
    return model


def test_stress_does_not_change_with_the_modulus():
    model = propped(kind="static", change_materials="rock -> soft")
    model.stage(name="end", steps=1)
    history = model.run().history
    position = history.displacement[:, 0, 1].values
    at = [np.flatnonzero(history.stage.values == stage)[-1] for stage in (1, 2)]
    assert abs(position[at[1]] - position[at[0]]) < 1e-6 * abs(position[at[0]])
    assert abs(position[at[0]]) > 1e-6  # the stress is not zero


def test_a_body_is_removed_whole_and_the_supported_body_falls_freely():
    model = propped(steps=100, remove="b1")
    history = model.run().history
    position = history.displacement[:, 0, 1].values
    speed = history.velocity[:, 0, 1].values
    # Released strains move the point relative to the centroid by much less than 1 %.
    assert position[-1] - position[0] == pytest.approx(-10 * 0.1**2 / 2, rel=0.01)
    assert speed[-1] == pytest.approx(-1.0, rel=0.01)


def test_a_part_of_a_body_is_not_removed():
    """Otherwise, its neighbours would lose stiffness, and others could fall through the gap."""
    model = propped(steps=10, remove="half")
    for group in model["block"][:8]:
        group.name = "half"
    with pytest.raises(sitedda.InputError, match="stage 'next' removes part of body 'b1'"):
        model.run()


def words_of(model, topic):
    return [line.words for line in sitedda.check(model).lines if line.topic == topic]


@pytest.mark.parametrize("deep", [3, 5])
def test_check_counts_the_cells_across_a_beam(deep):
    """Also rotated by 30° beside a square block; sides with a boundary are excluded."""
    rotation = np.array([[3**0.5, 1], [-1, 3**0.5]]) / 2
    beam = [cell @ rotation + [0, 3] for cell in cells_of((0, 0, 6, 1), 1 / deep)]
    block = cells_of((0, -8, 6, -2), 0.5)
    messages = words_of(model_of([block, beam]), "cells")
    assert messages[0].startswith(f"body 'b2' has {deep} cells across its thinnest part of 1 m")
    model = model_of([cells_of((0, -3, 6, -2), 0.5)])
    model.boundary(side="bottom", kind="roller")
    assert words_of(model, "cells")[0].split(" has ")[1].startswith("12 cells across")


@pytest.mark.parametrize("deep", [1, 3, 4])
def test_check_warns_of_bodies_that_yield_and_are_thin(deep):
    beam, thin = cells_of((0, 0, 6, 1), 1 / deep), cells_of((0, 3, 6, 4), 1.0)
    model = model_of([[(cell, "weak") for cell in beam], thin], analysis="plane_strain")
    model.material(name="weak", density=DENSITY, young_modulus=YOUNG, poisson_ratio=0.25,
                   law="mohr_coulomb", cohesion=1e6, friction_angle=30.0)  # fmt: skip
    messages = [message for message in words_of(model, "cells") if "yielding body" in message]
    assert len(messages) == (deep < 4)
    assert all(f"'b1' has only {deep} cells across 1 m" in message for message in messages)


def test_check_warns_of_slender_cells_in_offset_rows():
    rows = [[0, 5, 10, 15], [0, 2.5, 7.5, 12.5, 15]]
    cells = [
        np.array([[a, y], [b, y], [b, y + 1], [a, y + 1]])
        for y in range(4)
        for a, b in zip(rows[y % 2][:-1], rows[y % 2][1:], strict=True)
    ]
    messages = words_of(model_of([cells]), "cells")
    assert any("in offset rows are longer" in message for message in messages)


def test_the_error_of_stresses_is_reported_and_decreases_with_the_cell_size(root):
    """With n cells over the depth, bending has an error of 1/n in the energy norm, shear more."""
    errors = []
    for size in (0.15, 0.075):
        model = sitedda.Model.read(root / "inputs" / "roof_beam.nml")
        model["mesh"][0].size = size
        errors.append(model.run().verdict.values["stress_error"])
    assert 1 / 4 < errors[0] < 2 / 4
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.1)


def test_each_cell_has_an_error_of_stress(root, tmp_path):
    """Half of η² of each face: the sum is that of the verdict, in files and pictures."""
    model = sitedda.Model.read(root / "inputs" / "roof_beam.nml")
    run = model.run(output=tmp_path / "out.nc")
    scene = Scene.of(run)
    error, last = run.history.block_stress_error.values[-1], scene.frames - 1
    material = model["material"][0]
    modulus = material.young_modulus / (1 - material.poisson_ratio**2)  # plane stress
    strain = sum(float(run.history[f"energy_{name}"][-1]) for name in ("strain", "welded"))
    error_energy = 0.5 * (scene.areas() * error**2).sum() / modulus
    fraction = run.verdict.values["stress_error"]
    assert error_energy == pytest.approx(fraction**2 * strain, rel=1e-4)
    np.testing.assert_array_equal(quantity(scene, "stress_error", last), error)
    np.testing.assert_array_equal(blocks_of(scene, last).cells["error of stress (Pa)"], error)
    with sitedda.Simulation(model) as begun:
        assert begun.stress_errors.shape == error.shape
        np.testing.assert_allclose(begun.stress_errors, error, atol=1e-6 * error.max())
    sitedda.draw(scene, color="stress_error").figure.savefig(tmp_path / "errors.png")


def test_a_body_falls_as_one_block(tmp_path):
    """Four cells have fallen at 1.1 times the root of their common area, but not at 0.6 times."""
    model = model_of([[np.array([[0, -1], [2, -1], [2, 0], [0, 0]])], cells_of((0, 3, 1, 4), 0.5)],
                     gravity=[0.0, -10.0], steps=None)  # fmt: skip
    model.fixed_point(x=1.0, y=-0.5, block="1")
    model.fixed_point(x=1.5, y=-0.5, block="1")
    model.stage(name="fall", steps=600)
    model["block"][0].name = "floor"
    model.stop(fallen=1, reference="floor")
    run = model.run(output=tmp_path / "out.nc")
    time = float(run.history.time[-1])
    assert time == pytest.approx(np.sqrt(2 / 10), abs=5e-3)
    text = " ".join(str(run.verdict).split())
    assert "1 of 2 blocks are displaced by more than their size at the end" in text
    assert run.verdict.values["blocks_fallen"] == 1


def test_pictures_show_bodies(tmp_path):
    model = model_of([cells_of((0, 0, 2, 1), 0.5), cells_of((0, 1, 1, 2), 1.0)])
    scene = Scene.of(model)
    assert (scene.blocks, scene.bodies) == (9, 2)
    # Ten pairs of cells share a side in a grid of four by two cells.
    assert scene.welded.sum() == 20
    assert "2 blocks of 9 cells" in _picture_text(scene, 0, 1.0)
    model.draw().figure.savefig(tmp_path / "bodies.png")


def test_crosses_show_the_principal_stresses_of_cells(tmp_path):
    """Under tension along x, the arms are only along x, red, and 85 % of a cell long."""
    model = model_of([cells_of((0, 0, 4, 1), 0.5)], steps=None)
    for side, stress in (("left", -1e5), ("right", -1e5)):
        model.traction(side=side, normal=stress)
    model.fixed_point(x=0.0, y=0.0)
    model.fixed_point(x=4.0, y=0.0, direction="y")
    model.stage(name="rest", kind="static")
    scene = Scene.of(model.run(output=tmp_path / "out.nc"))
    assert largest_stress(scene, [scene.frames - 1]) == pytest.approx(1e5, rel=1e-4)
    axes = sitedda.draw(scene, color="compression")
    arms = draw_crosses(axes, scene, scene.frames - 1, 1.0, 1e5)[0]
    directions = np.array([line[1] - line[0] for line in arms.get_segments()])
    np.testing.assert_allclose(abs(directions), np.tile([0.425, 0.0], (16, 1)), atol=1e-4)
    colours = {tuple(np.round(c, 3)) for c in arms.get_colors()}
    assert colours == {tuple(np.round(to_rgba(TENSION), 3))}
    axes.figure.savefig(tmp_path / "crosses.png")


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ([[0, 0, 1, 0, 1, 1, 0, 1], [2, 0, 3, 0, 3, 1, 2, 1]], "body 'b1' is not connected"),
        ([[0, 0, 1, 0, 1, 1, 0.5, 0.2]], "divide it into convex cells"),
        ([[0, 0, 1, 0, 1, 1, 0, 1], [0.5, 0, 1.5, 0, 1.5, 1, 0.5, 1]], "overlaps block 1"),
        (
            # Three squares in an L are connected; the fourth misses one of its two neighbours.
            [[0, 0, 1, 0, 1, 1, 0, 1], [1, 0, 2, 0, 2, 1, 1, 1], [0, 1, 0.999, 1, 0.999, 2, 0, 2],
             [1, 1, 2, 1, 2, 2, 1, 2]],
            "are closer than a tenth of a cell but do not coincide",
        ),
    ],
)  # fmt: skip
def test_invalid_bodies_are_one_error(cells, message):
    model = model_of([cells])
    with pytest.raises(sitedda.InputError, match=message):
        model.run()
