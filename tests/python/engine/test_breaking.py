# SPDX-License-Identifier: GPL-3.0-or-later
"""Welded faces that break into cohesive joints: closed forms, momenta, colliding pieces."""

import numpy as np
import pytest
import shapely

import sitedda

DENSITY, YOUNG, STRENGTH, ENERGY = 2500.0, 20e9, 2e6, 60.0


def cells(columns, rows, size, steps, time_step, poisson=0.0, velocities=((0, 0, 0),) * 2, **joint):
    """A body of squares with breakable faces; both halves have initial velocities."""
    model = sitedda.Model()
    model.control(
        time_step=time_step, steps=steps, gravity=[0.0, 0.0], integration="midpoint",
        analysis="plane_stress",
    )  # fmt: skip
    model.contact(normal_stiffness=1e12)
    for name, velocity in zip(("left", "right"), velocities, strict=True):
        model.material(
            name=name, density=DENSITY, young_modulus=YOUNG, poisson_ratio=poisson,
            fracture="crack", initial_velocity=velocity,
        )  # fmt: skip
    values = {
        "law": "cohesive", "friction_angle": 30.0, "tensile_strength": STRENGTH,
        "cohesion": 2 * STRENGTH, "fracture_energy": ENERGY, "normal_stiffness_per_area": 1e13,
    }  # fmt: skip
    model.joint(name="crack", **values | joint)
    for j in range(rows):
        for i in range(columns):
            x, y = i * size, j * size
            model.block(
                vertices=[x, y, x + size, y, x + size, y + size, x, y + size], body="body",
                material="left" if i < (columns + 1) // 2 else "right", name=f"c{i}_{j}",
            )  # fmt: skip
    return model


def pulled_bar(count):
    """A bar of 2 m with one fixed end; the other end is pulled to 1.1 times the strength."""
    size = 2.0 / count
    model = cells(count, 1, size, 4000, 5e-5)
    displacements = 2.2e-4 * np.arange(4002) / 4000
    model.motion(name="pull", values=displacements.tolist(), quantity="displacement",
                 time_step=5e-5)  # fmt: skip
    for y in (0.0, size):
        model.fixed_point(x=0.0, y=y, block="c0_0")
        model.fixed_point(x=2.0, y=y, block=f"c{count - 1}_0", motion_x="pull")
    model.output(block_interval=40)
    return model


@pytest.mark.parametrize("count", [2, 5])
def test_a_bar_breaks_at_its_strength_and_keeps_the_remaining_energy(count):
    """200 J/m² (T²L/2E) are stored, G = 60 are dissipated, 140 become kinetic energy."""
    run = pulled_bar(count).run()
    history, depth = run.history, 2.0 / count
    stress = history.block_stress.sel(component="xx").values
    assert 0.97 * STRENGTH < stress.max() < 1.01 * STRENGTH
    damage = history.edge_damage.values
    assert damage[0].max() == 0 and damage.max() == 1
    if count == 2:
        assert history.energy_fracture[-1] == pytest.approx(ENERGY * depth, rel=1e-3)
        kinetic_energy = float(history.energy_kinetic[-1] + history.energy_strain[-1])
        assert kinetic_energy == pytest.approx(140.0 * depth, rel=0.025)
    assert np.abs(history.energy_balance).max() < 1e-9 * history.energy_input.max()
    assert np.all(np.diff(history.energy_fracture) >= 0)
    breaking_energy = float(np.abs(history.energy_breaking).max())
    assert breaking_energy < 5e-3 * history.energy_input.max()


def momenta(history, size):
    """Linear and angular momentum of squares at all frames, kg m/s and kg m²/s."""
    position, rate = history.block_coordinates.values, history.block_rates.values
    mass = DENSITY * size**2
    arm = position[..., 0] * rate[..., 1] - position[..., 1] * rate[..., 0]
    return mass * rate[..., :2].sum(1), mass * (arm + size**2 / 6 * rate[..., 2]).sum(1)


def test_breaking_keeps_momenta():
    """Two halves of a spinning body fly apart."""
    model = cells(4, 2, 0.5, 1500, 5e-6, 0.2, ([-0.6, -0.3, 1.0], [0.6, 0.3, 1.0]))
    model.output(block_interval=50)
    history = model.run().history
    linear, angular = momenta(history, 0.5)
    assert np.abs(linear - linear[0]).max() < 1e-12 * DENSITY * 4 * 0.6
    assert np.abs(angular - angular[0]).max() < 1e-10 * angular[0]  # of order 3 in Δt
    assert history.energy_fracture[-1] > ENERGY and history.edge_damage[-1].max() == 1
    assert np.abs(history.energy_balance).max() < 1e-9 * history.energy_kinetic[0]


def test_pieces_collide_as_blocks():
    """Separated halves are pushed together again and come to rest on each other."""
    model = cells(4, 2, 0.5, 8000, 4e-5, 0.2, ([-0.6, 0.0, 0.0], [0.6, 0.0, 0.0]))
    for i in range(4):
        for j in range(2):
            velocity_change = (1 if i < 2 else -1) * 2e4
            model.load(
                x=0.25 + 0.5 * i, y=0.25 + 0.5 * j, block=f"c{i}_{j}",
                time=[0.0, 0.01, 0.02, 10.0], force_x=[0.0, 0.0, velocity_change, velocity_change],
            )  # fmt: skip
    model.output(block_interval=100)
    history = model.run().history
    positions = history.vertices.values.reshape(-1, 8, 4, 2)
    gap = positions[:, 2, :, 0].min(1) - positions[:, 1, :, 0].max(1)
    assert gap.max() > 5e-3
    last = [shapely.Polygon(corners) for corners in positions[-1]]
    overlap = max(a.intersection(b).area for i, a in enumerate(last) for b in last[:i])
    assert overlap < 1e-5
    assert history.contact_normal_force.values.max() > 0


@pytest.mark.parametrize("pressure", [0.0, 1e6])
def test_a_face_shears_at_cohesion_and_friction(pressure):
    """The peak is c + σ tan φ; the residual stress is σ tan φ."""
    steps, slip = 2000, 2e-3
    model = cells(0, 0, 0, steps, 1e-3, cohesion=1e6, shear_fracture_energy=200.0)
    model.control(integration="backward_euler")
    for low, high, name in ((0.0, 0.1, "low"), (0.1, 0.2, "high")):
        model.block([0, low, 1, low, 1, high, 0, high], body="pair", name=name, material="left")
    values = slip * np.arange(steps + 2) / steps
    model.motion(name="push", values=values.tolist(), quantity="displacement", time_step=1e-3)
    for x in (0.0, 1.0):
        model.fixed_point(x=x, y=0.0, block="low")
        for y in (0.1, 0.2):
            model.fixed_point(x=x, y=y, block="high", direction="x", motion_x="push")
        model.fixed_point(x=x, y=0.1, block="low", direction="x")
        if pressure == 0:
            model.fixed_point(x=x, y=0.2, block="high", direction="y")
    if pressure:
        model.traction(side="top", normal=pressure)
    history = model.run().history
    force = np.diff(history.energy_input.values) / (slip / steps)
    friction = pressure * np.tan(np.radians(30.0))
    assert force[20:].max() == pytest.approx(1e6 + friction, rel=0.02)
    assert force[-1] == pytest.approx(friction, abs=0.02e6)
    assert history.energy_fracture[-1] == pytest.approx(200.0, rel=0.02)


def test_a_run_that_breaks_has_the_same_bits_everywhere(
    tmp_path, same_everywhere, same_bits, in_parts
):
    model = cells(4, 2, 0.5, 300, 2e-5, 0.2, ([-0.6, -0.3, 1.0], [0.6, 0.3, 1.0]))
    model.output(block_interval=20)
    file = model.write(tmp_path / "body.nml")
    reference = same_everywhere(file, 200)
    first_crack = np.flatnonzero(reference.energy_fracture.values > 0)[0]
    same_bits(reference, in_parts(file, int(first_crack) + 1))


def between(first, *others):
    """A body of two materials that breaks only between the given materials."""
    model = cells(4, 2, 0.5, 300, 2e-5, 0.2, ([-0.6, 0.0, 0.0], [0.6, 0.0, 0.0]))
    for material in model.of_kind("material"):
        material(fracture=None)
    model.of_kind("joint")[0](between=[first, *others])
    return model


@pytest.mark.parametrize("names", [("left", "right"), ("right", "left")])
def test_faces_between_two_materials_have_a_separate_joint(names):
    """Only faces between the two materials break, in either order of the names."""
    history = between(*names).run().history
    damage = history.edge_damage.values[-1].reshape(2, 4, 4)
    assert np.all(damage[:, 1, 1] == 1) and np.all(damage[:, 2, 3] == 1)
    assert damage.sum() == pytest.approx(4)
    assert history.energy_fracture[-1] == pytest.approx(ENERGY * 1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("left",), "`between` needs two materials"),
        (("left", "sand"), "'sand' is not the name of a"),
    ],
)
def test_faces_between_invalid_materials_are_refused(names, message):
    with pytest.raises(sitedda.InputError, match=message):
        between(*names).run()


def test_pictures_and_files_show_cracks(tmp_path):
    model = cells(4, 2, 0.5, 300, 2e-5, 0.2, ([-0.6, 0.0, 0.0], [0.6, 0.0, 0.0]))
    run = model.run()
    run.draw(color="damage").figure.savefig(tmp_path / "cracks.png")
    assert "damage" in str(run.view(tmp_path / "cracks.html").read_bytes())
    with sitedda.Simulation(model) as simulation:
        while not simulation.advance():
            pass
        np.testing.assert_array_equal(simulation.edge_damages, run.history.edge_damage.values[-1])


@pytest.mark.parametrize(
    "joint, fracture, message",
    [
        ({"law": "coulomb"}, "crack", "must be a joint of law 'cohesive'"),
        ({"normal_stiffness_per_area": None}, "crack", "normal_stiffness_per_area is missing"),
        ({}, "none", "'none' is not the name of a &joint"),
    ],
)
def test_an_unsuitable_joint_of_broken_faces_is_refused(joint, fracture, message):
    model = cells(2, 1, 1.0, 4, 1e-4)
    own = model.of_kind("joint")[0]
    if "law" in joint:
        own(fracture_energy=None, normal_stiffness_per_area=None)
    own(**joint)
    for material in model.of_kind("material"):
        material(fracture=fracture)
    with pytest.raises(sitedda.InputError, match=message):
        model.run()
