# SPDX-License-Identifier: GPL-3.0-or-later
"""Static stages reach equilibrium below the limit load and do not above it."""

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from model_text import group
from random_content import random_model

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import speed_models

import sitedda
from sitedda.masonry import Arch
from sitedda.scene import Scene

GRAVITY = 9.81
UNEXPLAINED = 5e-5  # penetration, m: above 10⁻³ of the distance within which contacts are listed


def arch(friction: float, ratio: float, voussoirs: int, half: float, push: float) -> sitedda.Model:
    """An arch of radius 10 m and half angle `half` (degrees) under weight and horizontal push."""
    model = sitedda.Model("Arch pushed", time_step=1e-3, gravity=(GRAVITY * push, -GRAVITY))
    model.material("stone", density=2500.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("dry", friction_angle=math.degrees(math.atan(friction)))
    angle = math.radians(half)
    span, rise = 20.0 * math.sin(angle), 10.0 * (1.0 - math.cos(angle))
    shapes = Arch(span=span, rise=rise, thickness=10 * ratio, voussoirs=voussoirs, abutment=2.0)
    for stone in shapes.blocks():
        model.block(np.array(stone.polygon), name=stone.name)
        if stone.name.endswith(("left", "right")):
            for corner in stone.polygon:
                inwards = 0.01 * (np.mean(stone.polygon, axis=0) - corner)
                model.fixed_point(*(corner + inwards), stone.name)
    model.stage(name="rest", kind="static")
    return model


def rests(model: sitedda.Model) -> bool:
    try:
        sitedda.Simulation(model).close()
    except sitedda.ConvergenceError as error:
        assert "does not settle" in str(error)
        return False
    return True


@pytest.mark.parametrize(
    "shape",
    [(0.61, 0.165, 15, 76.4), (0.46, 0.175, 19, 60.0), (0.87, 0.14, 18, 86.1), (0.51, 0.18, 9, 52)],
    ids=str,
)
def test_an_arch_rests_only_below_its_limit(shape):
    """Contacts with the far sides of separated blocks once supported arches beyond the limit."""
    limit = sitedda.limit_analysis(arch(*shape, push=0.0))
    assert limit.lower.factor == pytest.approx(limit.upper.factor, rel=0.01)
    fractions = np.array([0.90, 0.94, 0.98, 1.02, 1.04, 1.06, 1.08, 1.10])
    at_rest = [rests(arch(*shape, push=fraction * limit.upper.factor)) for fraction in fractions]
    assert at_rest == list(fractions < 1.0)


# --- Falls ---


def overhanging(bricks: int, floor: float) -> sitedda.Model:
    """Three courses of bricks of 1 m that extend beyond the end of the floor."""
    model = sitedda.Model("Overhang", time_step=1e-3, gravity=(0.0, -GRAVITY))
    model.material("stone", density=2643.0, young_modulus=4.788e9, poisson_ratio=0.25)
    model.joint("dry", friction_angle=35.0)
    model.wall(brick_length=1.0, brick_height=0.5, bricks=bricks, courses=3)
    model.block([[-1.0, -1.0], [floor, -1.0], [floor, 0.0], [-1.0, 0.0]], name="floor")
    for x in (0.0, floor - 1.0):
        model.fixed_point(x, -0.5, "floor")
    model.stage(name="rest", kind="static")
    return model


def test_unsupported_bricks_are_found_without_a_static_step():
    """With 1,000 bricks, static steps once took minutes."""
    with pytest.raises(
        sitedda.ConvergenceError,
        match=r"not at rest after 0 static steps: block 5 .brick_5. and 2986 others fall: no",
    ):
        sitedda.Simulation(overhanging(1000, 4.0))


def test_bricks_over_a_floor_rest():
    assert rests(overhanging(6, 7.0))


# --- Soft contacts --------------------------------------------------------------------------------


def polygon(random: np.random.Generator) -> np.ndarray:
    """A convex stone of 4 to 7 corners on a circle of 0.45 m; corners keep a distance."""
    while True:
        angles = np.sort(random.uniform(0.0, 2 * math.pi, random.integers(4, 8)))
        between = np.diff(np.append(angles, angles[0] + 2 * math.pi))
        if between.max() < 2.2 and between.min() > 0.4:
            return 0.45 * np.column_stack([np.cos(angles), np.sin(angles)])


def heap(seed: int) -> tuple[sitedda.Model, float]:
    """Stones that fall into a box, on contacts that one stone compresses by 1 to 8 cm; k_n, N/m."""
    random = np.random.default_rng(seed)
    model = sitedda.Model("Heap", time_step=5e-4, integration="backward_euler",
                          max_displacement_ratio=0.005, gravity=(0.0, -GRAVITY))  # fmt: skip
    stiffness = 2500 * GRAVITY * 0.5 / random.uniform(0.01, 0.08)
    model.contact(normal_stiffness=stiffness)
    model.material("stone", density=2500.0, young_modulus=1e9, poisson_ratio=0.2)
    model.joint("dry", friction_angle=random.uniform(20, 40))
    for name, (x0, x1, y0, y1) in {
        "floor": (-2.7, 2.7, -1.0, 0.0), "left": (-2.7, -2.2, 0.0, 6.0), "right": (2.2, 2.7, 0, 6),
    }.items():  # fmt: skip
        corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        model.block(corners, name=name)
        for corner in corners + 0.01 * (corners.mean(axis=0) - corners):
            model.fixed_point(*corner, name)
    for i in range(random.integers(8, 20)):
        corner = [-1.65 + 1.1 * (i % 4) + random.uniform(-0.08, 0.08), 0.5 + i // 4]
        model.block(polygon(random) + corner, name=f"stone_{i}")
    model.stage(name="fall", kind="dynamic", duration=3.0)
    model.stage(name="rest", kind="static")
    return model, stiffness


@pytest.mark.filterwarnings("ignore::sitedda.AuditWarning")
@pytest.mark.parametrize("seed", range(20))
def test_a_heap_on_soft_contacts_rests_with_penetrations_that_match_forces(seed, tmp_path):
    """Stones that changed edges once kept penetrations without forces."""
    model, stiffness = heap(seed)
    run = model.run(tmp_path / "heap.nc")
    with sitedda.open_output(run.output) as data:
        scene = Scene.of(data)
        last = scene.frames - 1
        contacts = scene.contacts(last)
    positions, normals = scene.contact_points(last, contacts)
    is_pressed = contacts["normal_force"] > 0
    assert is_pressed.sum() > 10
    depth = -contacts["gap"][is_pressed]
    implied_penetration = contacts["normal_force"][is_pressed] / stiffness
    assert (depth - implied_penetration).max() <= UNEXPLAINED


def test_sliding_blocks_are_reported_with_their_joint(write_input):
    """A block on a slope of 30.3° slides at φ = 20°; supports and gaps cause no failure."""
    groups = [
        group("control", time_step=1e-3, steps=2, gravity=(0.0, -9.81), settle=True),
        group("material", name="rock", density=2500.0, young_modulus=1e9, poisson_ratio=0.2),
        group("joint", name="bed", friction_angle=20.0),
        group("block", name="base", vertices=(0, 0, 10, 0, 10, 5.8454)),
        group("block", name="slider",
              vertices=(4, 2.33816, 5, 2.9227, 4.4154, 3.9227, 3.4154, 3.33816)),
        group("fixed_point", x=0.5, y=0.1),
        group("fixed_point", x=9.9, y=0.1),
        group("fixed_point", x=9.9, y=5.0),
    ]  # fmt: skip
    message = "2 contacts slide: block 2 'slider' slides on 1 'base' along joint 'bed'"
    with pytest.raises(sitedda.ConvergenceError, match=re.escape(message)):
        sitedda.run(write_input(groups), output=False)


def test_a_block_that_does_not_rest_without_slip_is_reported_with_its_joint(write_input):
    """A wall with rough joints has an unbalanced force of 0.01 N, without slip."""
    groups = [
        group("control", time_step=5e-4, steps=1, gravity=(0.0, -9.81), settle=True),
        group("material", name="rock", density=1745.6, young_modulus=1.482e8, poisson_ratio=0.397,
              rayleigh_alpha=0.795, rayleigh_beta=0.000886),
        group("joint", name="rough", law="plesha", friction_angle=18.2, asperity_angle=6.9,
              asperity_wear=0.000262, normal_stiffness_per_area=2.299e8,
              shear_stiffness_per_area=7.773e7),
        group("layers", name="base", left=-1, bottom=-0.5, width=16.59, thickness=0.5),
        group("wall", name="brick", left=0, bottom=0, brick_length=1.0, brick_height=0.34,
              bricks=6, courses=8),
        group("boundary", kind="fixed", side="bottom", blocks="base*"),
    ]  # fmt: skip
    message = "no contact slides; largest contact force on the block .* N/m on joint 'rough'"
    with pytest.raises(sitedda.ConvergenceError, match=message):
        sitedda.run(write_input(groups), output=False)


# --- Many changes of contacts ---


def wall(model: sitedda.Model) -> list:
    """Add 68 bricks on a floor; return its supports."""
    model.layers(name="floor", left=-1.0, bottom=-0.5, width=6.8, thickness=0.5)
    model.wall(brick_length=0.6, brick_height=0.25, bricks=8, courses=8)
    return [(-0.9, -0.25), (5.7, -0.25)]


def voussoirs(model: sitedda.Model) -> list:
    """Add 25 voussoirs between two abutments; return their supports."""
    supports = []
    for stone in Arch(span=6.0, rise=3.0, thickness=0.7, voussoirs=25, abutment=2.0).blocks():
        shape = np.array(stone.polygon)
        model.block(shape, name=stone.name)
        if stone.name.endswith(("left", "right")):
            supports += [*(shape + 0.01 * (shape.mean(axis=0) - shape))]
    return supports


ROUGH = {"law": "barton_bandis", "friction_angle": 30.0, "jrc": 10.0, "jcs": 5e7}
PER_AREA = {"friction_angle": 60.0, "shear_stiffness_per_area": 8e9}


@pytest.mark.parametrize(
    ("build", "joint"),
    [(wall, ROUGH | {"max_closure": 5e-4}), (wall, PER_AREA), (voussoirs, PER_AREA)],
    ids=["rough wall", "wall", "arch"],
)
def test_a_shaken_structure_runs_to_its_end_at_a_fixed_time_step(build, joint):
    """Weight and 1 g act suddenly: steps of the walls have up to 132 open–close iterations."""
    with sitedda.Simulation(shaken(build, joint, 1e-3)) as run:
        run.advance(120)
        assert run.steps == 120
        assert abs(run.energies["balance"]) < 1e-9 * run.energies["kinetic"]


@pytest.mark.parametrize(("cohesion", "time_step", "steps"), [(0.0, 20e-3, 10), (2e3, 8e-3, 20)])
def test_dilation_ends_within_steps_of_a_shaken_wall(cohesion, time_step, steps):
    """In some contacts of a step, slip lifts only up to 2 mm; open contacts have no cohesion."""
    joint = {"law": "mohr_coulomb", "friction_angle": 30.0, "dilation_angle": 15.0,
             "dilation_slip": 2e-3, "cohesion": cohesion,
             "shear_stiffness_per_area": 8e9}  # fmt: skip
    with sitedda.Simulation(shaken(wall, joint, time_step)) as run:
        for _ in range(steps):
            run.advance(1)
            contacts = {name: np.asarray(values) for name, values in run.contacts.items()}
            dilation = np.tan(np.radians(15.0)) * np.minimum(contacts["slip_path"], 2e-3)
            normal = 2e10 * contacts["length"] * np.maximum(dilation - contacts["gap"], 0.0)
            bound = np.tan(np.radians(30.0)) * normal + cohesion * contacts["length"]
            tolerance_of_case = 1e-6 * normal.max()
            assert np.abs(contacts["normal_force"] - normal).max() < tolerance_of_case
            assert (np.abs(contacts["shear_force"]) <= bound + tolerance_of_case).all()
            assert (contacts["shear_force"][contacts["normal_force"] == 0.0] == 0.0).all()
        assert (contacts["slip_path"] > 2e-3).any()


def shaken(build, joint: dict, time_step: float) -> sitedda.Model:
    """Return a structure under sudden gravity and a base motion of 1 g."""
    model = sitedda.Model("Shaken", time_step=time_step, gravity=(0.0, -GRAVITY), steps=120,
                          max_displacement_ratio=0.1)  # fmt: skip
    model.contact(normal_stiffness=5e9)
    model.material("stone", density=2500.0, young_modulus=2e10, poisson_ratio=0.2)
    model.joint("dry", normal_stiffness_per_area=2e10, **joint)
    accelerations = GRAVITY * np.sin(0.04 * math.pi * np.arange(32))
    model.motion("shake", values=accelerations.tolist(), time_step=0.005, quantity="acceleration",
                 drift_order=0)  # fmt: skip
    for x, y in build(model):
        model.fixed_point(x, y, motion_x="shake")
    return model


def test_sor_ends_in_bounded_sweeps():
    """70 stones under sudden weight need as many iterations as with a direct solver."""
    results = {}
    for solver in ("sor", "direct"):
        model = sitedda.Model(time_step=5e-4, steps=6, gravity=(0.0, -GRAVITY), solver=solver)
        model.material("rock", density=2475.0, young_modulus=1.362e10, poisson_ratio=0.267)
        model.joint("dry", friction_angle=56.7)
        model.layers(name="base", left=-1.0, bottom=-0.5, width=7.94, thickness=0.5)
        model.masonry_wall(width=5.94, height=1.4, courses=4, stone=0.7, bond="header", seed=35)
        model.boundary("ground", "fixed", side="bottom", blocks="base*")
        with sitedda.Simulation(model) as run:
            run.advance(6)
            results[solver] = run.counts | run.energies
    sor, direct = results["sor"], results["direct"]
    assert sor["iterations"] == direct["iterations"] and sor["handed_over"] == 0
    assert sor["contact"] == pytest.approx(direct["contact"], rel=1e-7)
    assert sor["solver_iterations"] < 1500 * sor["solves"]


@pytest.mark.parametrize("friction", [12.0, 35.0])
def test_a_packing_comes_to_rest_where_relaxed_steps_stall(friction, tmp_path):
    assert_at_rest(speed_models.packing(1500), friction, "", tmp_path)


@pytest.mark.parametrize("law", ["", ", contact_points = 3", ", contact_points = 5"])
def test_a_slippery_wall_comes_to_rest_by_relaxed_steps(law, tmp_path):
    assert_at_rest(speed_models.touching_wall(1500), 12.0, law, tmp_path)


def test_joints_of_other_laws_come_to_rest_by_frozen_friction_bounds(tmp_path):
    """A wall with an arched window and Barton–Bandis joints: free friction bounds would cycle."""
    text = re.sub(r"steps = \d+", "settle = .true.\n   steps = 2", random_model(1009), count=1)
    (tmp_path / "wall.nml").write_text(text)
    with sitedda.Simulation(tmp_path / "wall.nml") as simulation:
        assert "law = 'barton_bandis'" in text and "at rest after" in simulation.summary


def assert_at_rest(model, friction: float, law: str, folder) -> None:
    """Blocks come to rest under sudden weight, and no contact exceeds its friction."""
    model.stress[:] = 0.0
    text = model.text(1e12, 1e-3, 1000, 10, "auto")
    text = text.replace("&control ", "&control settle = .true., ")
    file = folder / "blocks.nml"
    file.write_text(text.replace("friction_angle = 35.0", f"friction_angle = {friction}{law}"))
    with sitedda.Simulation(file) as simulation:
        assert int(re.search(r"at rest after (\d+) static steps", simulation.summary)[1]) > 5
        contacts = simulation.contacts
        normal, shear = contacts["normal_force"], contacts["shear_force"]
    assert normal.max() > 1e5
    assert np.all(abs(shear) <= math.tan(math.radians(friction)) * normal + 1.0)
