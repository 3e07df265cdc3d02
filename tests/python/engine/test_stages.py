# SPDX-License-Identifier: GPL-3.0-or-later
"""Models come to rest before shaking; later stages follow."""

import math
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from model_text import DRY, ROCK, changed, flying_block, group, rectangle, tower

import sitedda

GRAVITY = 9.81
STONE = {"name": "stone", "density": 2500.0, "young_modulus": 10.0e9, "poisson_ratio": 0.25}


def model(blocks, friction=35.0, supports=(), points=(), **control) -> list:
    """Blocks by name with one material and one joint, settled under gravity."""
    control = {"time_step": 1e-3, "steps": 20, "gravity": [0.0, -GRAVITY], "settle": True} | control
    return [
        ("control", control),
        ("material", dict(STONE)),
        group("joint", name="dry", friction_angle=friction),
        *(group("block", name=name, vertices=vertices) for name, vertices in blocks.items()),
        *(group("fixed_point", x=x, y=y, block=block) for block, x, y in supports),
        *(
            group("measured_point", name=name, x=x, y=y, block=block)
            for name, block, x, y in points
        ),
        group("output", file="stages.nc"),
    ]


def column(drums: int = 10, **control) -> list:
    blocks = {"foot": rectangle(-1.0, -0.5, 2.0, 0.5)}
    blocks |= {f"drum_{i}": rectangle(-0.3, 0.5 * i, 0.6, 0.5) for i in range(drums)}
    supports = [("foot", -0.9, -0.4), ("foot", 0.9, -0.4), ("foot", 0.0, -0.1)]
    top = [("crest", f"drum_{drums - 1}", 0.0, 0.5 * drums)]
    return model(blocks, supports=supports, points=top, **control)


def wall(bricks: int, courses: int, **control) -> list:
    pattern = {"brick_length": 1.0, "brick_height": 0.5, "bricks": bricks, "courses": courses}
    groups = model({}, points=[("crest", "brick_1", 0.4, 0.25)], **control)
    groups[3:3] = [
        group("layers", name="base", left=-0.5, bottom=-0.5, width=bricks + 1.0, thickness=0.5),
        ("wall", pattern | {"name": "brick"}),
        *(group("fixed_point", x=x, y=-0.25, block="base_1") for x in (0.0, float(bricks))),
        group("fixed_point", x=bricks / 2, y=-0.4, block="base_1"),
    ]
    return groups


def arch() -> list:
    """A half circle on two fixed abutments."""
    groups = model({}, points=[("crest", "v_14", 0.0, 10.0)])
    groups[3:3] = [
        group("arch", name="v", radius=10.0, thickness=1.3, voussoirs=27, abutment=2.0),
        *(group("fixed_point", x=x, y=-0.5) for x in (-12.0, -10.0, 10.0, 12.0)),
    ]
    return groups


def slope(dip: float = 35.0, friction: float = 38.0, rows: int = 2, **control) -> list:
    """Slabs of 4 m x 2 m in `rows` layers on an inclined plane, in running bond."""
    t = math.radians(dip)
    tangent, normal = np.array([math.cos(t), math.sin(t)]), np.array([-math.sin(t), math.cos(t)])

    def slab(a, b, h0, h1):
        return [float(c) for p, h in ((a, h0), (b, h0), (b, h1), (a, h1))
                for c in p * tangent + h * normal]  # fmt: skip

    blocks = {"ground": slab(-10.0, 40.0, -5.0, 0.0)}
    for row in range(rows):
        for i in range(5):
            a = 4.0 * i + 2.0 * (row % 2)
            blocks[f"b{row}_{i}"] = slab(a, a + 4.0, 2.0 * row, 2.0 * row + 2.0)
    supports = [("ground", *(a * tangent + h * normal))
                for a, h in ((-9.0, -4.0), (39.0, -4.0), (0, -1))]  # fmt: skip
    supports = [(block, float(x), float(y)) for block, x, y in supports]
    x, y = blocks[f"b{rows - 1}_4"][4:6]
    return model(blocks, friction, supports, [("crest", f"b{rows - 1}_4", x, y)], **control)


def unbalanced(run) -> float:
    """Unbalanced force as fraction of the weight, in the summary of a run."""
    text = run.summary.split("largest unbalanced force ")[1]
    return float(text.split(" N/m, ")[1].split(" ")[0])


@pytest.mark.parametrize(
    "groups",
    [column(), wall(5, 10), wall(25, 40, steps=2), arch(), slope()],
    ids=["column", "wall of 50", "wall of 1000", "arch", "slope"],
)
def test_a_model_at_rest_stays_there(groups, write_input):
    with sitedda.Simulation(write_input(groups)) as run:
        assert unbalanced(run) <= 1e-6
        assert run.energies["kinetic"] == 0.0
        assert not run.rates.any()
        assert run.time == 0.0 and run.counts["steps"] == 0
        assert run.energies["initial"] > 0.0  # elastic energy at rest
        before = run.coordinates.copy()
        while not run.advance(10):
            pass
        assert np.abs(run.coordinates - before)[:, :2].max() <= 1e-9
        assert abs(run.energies["friction"]) <= 1e-6 * run.energies["initial"]


def test_two_thousand_touching_bricks_come_to_rest(write_input):
    """After a few static steps, each course carries half its weight and all weight above."""
    bricks = 45
    with sitedda.Simulation(write_input(wall(bricks, bricks, steps=1))) as run:
        iterations = int(run.summary.split("at rest after ")[1].split(" ")[0])
        assert 1 <= iterations <= 20
        assert unbalanced(run) <= 1e-6
        bricks_only = [name.startswith("brick") for name in run.block_names]
        stress, height = run.stresses[bricks_only, 1], run.coordinates[bricks_only, 1]
        width = np.array([np.ptp(corners[:, 0]) for corners in run.polygons])[bricks_only]
    course = (height / 0.5).astype(int)
    forces = np.bincount(course, -stress * width)
    weight = np.bincount(course, width) * 0.5 * STONE["density"] * GRAVITY
    # measured 4e-6: bricks have strains up to 5e-5
    assert forces == pytest.approx(np.cumsum(weight[::-1])[::-1] - 0.5 * weight, rel=1e-5)


@pytest.mark.parametrize("step", [0.25e-3, 0.5e-3, 1e-3, 2e-3])
def test_the_slope_at_rest_does_not_move(step, write_input):
    run = sitedda.run(write_input(slope()), time_step=step, steps=round(0.2 / step))
    displacement = np.abs(run.history.displacement)
    assert float(displacement.max()) <= 1e-8  # rounding errors
    assert float(displacement[0].max()) == 0.0


def test_loads_of_time_zero_act_and_motions_do_not(write_input):
    groups = tower(2, 10, {"name": "bedding", "friction_angle": 35.0}, gravity=[0.0, -GRAVITY])
    groups = changed(groups, "control", settle=True)
    load = {"x": 7.5, "y": 1.5, "time": [0.0, 1.0], "force_y": [-1.0e6, -1.0e6]}
    with sitedda.Simulation(write_input(groups)) as simulation:
        first = simulation.stresses.copy()
    with sitedda.Simulation(write_input([*groups, ("load", load)])) as loaded:
        assert loaded.energies["kinetic"] == 0.0
        change = (loaded.stresses - first)[1:, 1]
        # the load acts in the middle of the upper layer and passes the lower one from top to bottom
        assert change == pytest.approx([-1.0e6 / 15.0, -0.5e6 / 15.0], rel=1e-3)


def test_blocks_that_do_not_come_to_rest_are_named(write_input, binary):
    file = write_input(slope(friction=20.0))
    message = r"does not settle.*block .*unbalanced force"
    with pytest.raises(sitedda.ConvergenceError, match=message):
        sitedda.Simulation(file)
    process = binary("run", file)
    assert process.returncode == 3
    assert "not at rest after" in process.stderr


def test_a_static_stage_fails_when_a_block_has_moved_too_far(write_input):
    def rest(friction, **limit):
        groups = changed(slope(friction=friction), "control", settle=None, steps=None)
        stage = {"name": "rest", "kind": "static"} | limit
        with sitedda.Simulation(write_input([*groups, ("stage", stage)])) as run:
            return run.coordinates

    message = "block .* has moved by .* m; displacement of &stage is {} m; .*joint"
    with pytest.raises(sitedda.ConvergenceError, match=message.format("0.05")):
        rest(20.0, displacement=0.05)
    free = rest(38.0)
    assert (rest(38.0, displacement=0.05) == free).all()
    with pytest.raises(sitedda.ConvergenceError, match=message.format("1e-6")):
        rest(38.0, displacement=1e-6)


@pytest.mark.parametrize(("size", "angle"), [(300.0, 32.0), (1000.0, 45.0)])
def test_a_small_block_that_slides_on_a_huge_base_is_not_at_rest(size, angle, write_input):
    """Its unbalanced force is less than 10⁻⁶ of the weight of all blocks."""
    with pytest.raises(sitedda.ConvergenceError, match="not at rest.*block 2 .brick. has"):
        sitedda.Simulation(write_input(brick_on_base(size, 1.0, angle)))


def test_a_summary_states_forces_below_rounding_errors(write_input):
    """With springs of 10¹² N/m, rounding of positions is a tenth of the weight of a tiny brick."""
    with sitedda.Simulation(write_input(brick_on_base(0.2, 1e-3, 20.0))) as run:
        assert "a force below 0.1" in run.summary and "block 2 'brick' is neglected" in run.summary
    with sitedda.Simulation(write_input(brick_on_base(2.0, 1.0, 20.0))) as run:
        assert "is neglected" not in run.summary


def brick_on_base(size: float, brick: float, inclination: float) -> list:
    """A brick with φ = 30° on a fixed base; gravity is rotated from the vertical (degrees)."""
    blocks = {"base": rectangle(-0.5 * size, -size, size, size)}
    blocks["brick"] = rectangle(-0.5 * brick, 0.0, brick, 0.5 * brick)
    supports = [("base", x * size, -0.9 * size) for x in (-0.4, 0.4)]
    supports.append(("base", 0.0, -0.2 * size))
    angle = math.radians(inclination)
    gravity = [GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle)]
    groups = model(blocks, 30.0, supports, [("top", "brick", 0.0, 0.25 * brick)], gravity=gravity)
    return [*groups, group("contact", normal_stiffness=1e12)]


def test_sudden_gravity_is_reported(write_input, binary, tmp_path):
    file = write_input(changed(column(2), "control", settle=False))
    process = binary("run", file, folder=tmp_path)
    assert "gravity acted suddenly" in process.stdout
    assert "gravity acted suddenly" in str(sitedda.run(file).verdict)
    assert "gravity acted suddenly" not in str(sitedda.run(file, settle=True).verdict)


def test_unsupported_static_stages_are_refused(write_input):
    with pytest.raises(sitedda.InputError, match="'original' of &contact has no static stage"):
        sitedda.Simulation(write_input(column(2)), contact_rules="original")
    moving_groups = changed(column(2), "material", initial_velocity=[1.0, 0.0, 0.0])
    with pytest.raises(sitedda.InputError, match="material 'stone' has an initial_velocity"):
        sitedda.Simulation(write_input(moving_groups))


def test_check_starts_from_the_same_equilibrium(write_input):
    report = str(sitedda.check(write_input(column(3))))
    assert "at rest after 0 static steps" in report
    report = str(sitedda.check(write_input(changed(column(3), "control", settle=False))))
    assert "at rest after" in report and "after 0 static" not in report


def test_a_settled_run_is_bit_identical_everywhere(write_input, same_everywhere):
    same_everywhere(write_input(slope(steps=30)), 11)


def test_a_flying_block_cannot_settle(write_input):
    groups = changed(flying_block(), "control", settle=True, gravity=[0.0, -GRAVITY])
    groups = changed(groups, "material", initial_velocity=None)
    with pytest.raises(sitedda.ConvergenceError, match="block 1 'brick' falls"):
        sitedda.Simulation(write_input(groups))


def test_a_block_that_falls_and_rests_is_reported(write_input, binary, tmp_path):
    """A pedestal is removed: the block lands on the floor, 0.3 m lower."""
    blocks = {"floor": rectangle(-2, -1, 4, 1), "gone": rectangle(-1, 0, 2, 0.3)}
    blocks["stone"] = rectangle(-1, 0.3, 2, 1)
    groups = model(blocks, supports=[("floor", -1.9, -0.9), ("floor", 1.9, -0.9)])
    groups = changed(groups, "control", settle=None, steps=None)
    stages = [{"name": "rest"}, {"name": "dig", "remove": "gone"}]
    groups[-1:-1] = [("stage", stage | {"kind": "static"}) for stage in stages]
    run = sitedda.run(write_input(groups), output=tmp_path / "fall.nc")
    summary_before, fell = run.summary.split("stage 'dig'")
    assert "block 3 'stone' moved farthest, by " in summary_before
    message = "block 3 'stone' moved farthest, by 0.3 m; block 3 'stone' is "
    assert message in fell
    assert run.verdict.values["displacement_from_drawn_m"] == pytest.approx(0.3, abs=1e-3)
    printed_text = "300 mm at the end; stone, including settlement"
    assert dict(run.verdict.lines)["distance from input"] == printed_text
    output = binary("run", write_input(groups), folder=tmp_path).stdout
    assert message in " ".join(output.split())
    header = next(line for line in output.splitlines() if "where, when" in line)
    line = next(row for row in output.splitlines() if row.startswith("distance from input "))
    assert line[header.index("at the end") :].startswith("300 mm")
    assert line[header.index("where") :].startswith("stone, including settlement")


# Three blocks of a beam on two piers; the blocks are glued to each other, but not to the piers.
BEAM = {"beam_l": (0.0, 1.5), "beam_m": (1.5, 4.8), "beam_r": (4.8, 6.0)}
PIERS = {"pier_l": 0.0, "pier_r": 5.0}


def beam(stages, **control) -> list:
    blocks = {name: rectangle(x, 0.0, 1.0, 2.0) for name, x in PIERS.items()}
    blocks |= {name: rectangle(a, 2.0, b - a, 1.0) for name, (a, b) in BEAM.items()}
    supports = [(name, x + dx, 0.1) for name, x in PIERS.items() for dx in (0.1, 0.9)]
    groups = model(blocks, supports=supports, points=[("tip", "beam_l", 1.5, 3.0)], **control)
    groups = changed(groups, "control", settle=None, steps=None)
    groups = changed(groups, "joint", friction_angle=35.0)
    groups.insert(3, ("joint", dict(GLUE)))
    groups.insert(4, ("material", STONE | {"name": "soft", "young_modulus": 5.0e9}))
    for name, values in groups:
        if name == "block":
            values["joint"] = "glue" if values["name"] in BEAM else "dry"
    return [*groups[:-1], *(("stage", dict(stage)) for stage in stages), groups[-1]]


GLUE = {"name": "glue", "friction_angle": 35.0, "cohesion": 1.0e8, "tensile_strength": 1.0e8}
STAGES = [
    {"name": "rest", "kind": "static"},
    {"name": "dig", "kind": "static", "remove": "beam_m"},
    {"name": "wait", "steps": 20, "zero_displacements": True},
    {"name": "soften", "steps": 20, "time_step": 2e-3, "integration": "theta",
     "change_materials": "stone -> soft"},
    {"name": "last", "kind": "static"},
]  # fmt: skip


def reactions(data: xr.Dataset, frame: int) -> list[float]:
    """Sum of the contact forces between each pier and the block on it."""
    block = data.vertex_block.values
    sides = np.stack([block[data.contact_vertex.values], block[data.contact_edge.values]])
    force = data.contact_normal_force.values * (data.contact_frame.values == frame)
    pairs = [(0, 2), (1, 4)]
    return [float(force[np.all(np.sort(sides, 0).T == pair, 1)].sum()) for pair in pairs]


def test_excavation_redistributes_the_reactions(write_input, tmp_path):
    run = sitedda.run(write_input(beam(STAGES)), output=tmp_path / "beam.nc")
    assert "is neglected" not in run.summary  # also not for the removed block
    weight = STONE["density"] * GRAVITY
    with xr.open_dataset(tmp_path / "beam.nc") as data:
        assert sum(reactions(data, 0)) == pytest.approx(6.0 * weight, rel=1e-3)
        for frame in (1, data.sizes["frame"] - 1):
            assert reactions(data, frame) == pytest.approx([1.5 * weight, 1.2 * weight], rel=1e-3)
        assert data.stage.values.tolist() == [1, 2, *[3] * 20, *[4] * 20, 5]
        assert data.attrs["stages"].split("\n") == ["rest", "dig", "wait", "soften", "last"]
        assert float(data.time[-1]) == pytest.approx(20e-3 + 40e-3)
        assert np.abs(data.displacement.values[2:]).max() < 1e-9
        assert np.abs(data.displacement.values[:2]).max() > 1e-6


def test_every_stage_has_its_term_in_the_budget(write_input):
    with sitedda.Simulation(write_input(beam(STAGES))) as run:
        while not run.advance(100):
            pass
        energies = run.energies
        assert run.warning == ""
    # The stress does not change if the modulus is halved: part of the strain energy doubles.
    for term in ("static", "removed", "changed"):
        assert energies[term] > 1e-3 * energies["initial"], term
    assert energies["zeroed"] != 0.0
    assert abs(energies["balance"]) < 1e-9 * energies["initial"]


@pytest.mark.parametrize("after", [0, 7, 20, 33, 40])
def test_a_run_resumes_in_every_stage_bit_identically(
    after, write_input, tmp_path, in_parts, same_bits
):
    groups = changed(beam(STAGES), "output", block_interval=7)
    file = write_input(groups)
    reference = sitedda.run(file, output=tmp_path / "whole.nc")
    same_bits(reference.history, in_parts(file, after))


def test_motions_begin_with_their_stage(write_input):
    """The same shaking in the first or in a later stage causes the same motion."""
    tower_ = tower(2, 60)
    at_once = sitedda.run(write_input(tower_, "once.nml")).history.displacement.values
    staged_groups = changed(tower_, "control", steps=None)
    stages = [{"name": "wait", "steps": 30}, {"name": "shake", "steps": 60, "motions": "pulse"}]
    staged_groups[-1:-1] = [("stage", stage) for stage in stages]
    later_run = sitedda.run(write_input(staged_groups, "late.nml")).history.displacement.values
    assert np.abs(later_run[:31]).max() == 0.0
    assert later_run[30:] == pytest.approx(at_once, abs=1e-9 * np.abs(at_once).max())


@pytest.mark.parametrize(
    ("stages", "control", "message"),
    [
        ([{"name": "a", "kind": "static", "steps": 3}], {},
         "steps belongs to kind = 'dynamic', but the kind here is 'static'"),
        ([{"name": "a", "steps": 3, "displacement": 1.0}], {},
         "displacement belongs to kind = 'static', but the kind here is 'dynamic'"),
        ([{"name": "a"}], {}, "give either `duration` or `steps`"),
        ([{"name": "a", "steps": 3}], {"steps": 3}, "with &stage groups, duration, steps"),
        ([{"name": "a", "steps": 3, "remove": "arch_*"}], {}, "nothing is named 'arch_*'"),
        ([{"name": "a", "steps": 3, "remove": "pier_*, beam_*"}], {}, "would leave no block"),
        ([{"name": n, "steps": 3, "remove": "beam_m"} for n in "ab"], {},
         "block 'beam_m' has been removed in stage 'a'"),
        ([{"name": "a", "steps": 3}] * 2, {}, "name = 'a' is used twice"),
        ([{"name": "a", "steps": 3, "change_joints": "dry"}], {}, "'old -> new'"),
        ([{"name": "a", "steps": 3, "change_joints": "dry -> wet"}], {}, "'wet' is not the name"),
        ([{"name": "a", "steps": 3, "theta": 0.6}], {}, "need integration = 'theta'"),
    ],
)  # fmt: skip
def test_contradictory_stages_are_refused(stages, control, message, write_input):
    groups = beam(stages)
    if control:
        groups = changed(groups, "control", **control)
    with pytest.raises(sitedda.InputError) as error_info:
        sitedda.Simulation(write_input(groups))
    assert message in str(error_info.value)


def test_the_original_rules_do_not_support_stages(write_input):
    with pytest.raises(sitedda.InputError, match="'original' of &contact does not support &stage"):
        sitedda.Simulation(write_input(beam(STAGES)), contact_rules="original")


def test_a_released_support_has_no_reaction(write_input):
    """A block on two supports rotates about the remaining one."""
    groups = model({"bar": rectangle(0.0, 0.0, 4.0, 0.5)}, points=[("end", "bar", 4.0, 0.25)])
    groups = changed(groups, "control", settle=None, steps=None)
    groups[3:3] = [group("fixed_point", name=name, x=x, y=0.25)
                   for name, x in (("stay", 0.2), ("prop", 3.8))]  # fmt: skip
    groups[-1:-1] = [
        group("stage", name="rest", kind="static"),
        group("stage", name="go", steps=100, release="prop", zero_displacements=True),
    ]
    fall = sitedda.run(write_input(groups)).history.displacement.values[-1, 0, 1]
    # Uniform bar about a point 1.8 m from its middle: angle = ½ (m g a/I) t², end 3.8 m away.
    inertia = (4.0**2 + 0.5**2) / 12 + 1.8**2
    expected = -3.8 * 0.5 * GRAVITY * 1.8 / inertia * 0.1**2
    assert fall == pytest.approx(expected, rel=0.02)


def test_a_changed_joint_lets_a_slab_slide(write_input):
    """On a plane of 35°, a slab slides with g (sin 35° − tan 20° cos 35°) once φ falls to 20°."""
    groups = changed(slope(rows=1), "control", settle=None, steps=None)
    groups.insert(3, group("joint", name="wet", friction_angle=20.0))
    groups[-1:-1] = [
        group("stage", name="rest", kind="static"),
        group("stage", name="rain", steps=100, change_joints="dry -> wet", zero_displacements=True),
    ]
    slip = sitedda.run(write_input(groups)).history.displacement.values[-1, 0]
    dip = math.radians(35.0)
    acceleration = GRAVITY * (math.sin(dip) - math.tan(math.radians(20.0)) * math.cos(dip))
    assert float(np.hypot(*slip)) == pytest.approx(0.5 * acceleration * 0.1**2, rel=0.03)


# --- Additions by stages -------------------------------------------------------------------------


def stopped(speed: float) -> float:
    """Energy lost when the points of the block are stopped: -½ (T v)ᵀ (T M⁻¹ Tᵀ)⁻¹ T v."""

    def shape(x, y):
        return np.array([[1, 0, -y, x, 0, y / 2], [0, 1, x, 0, y, x / 2]])

    gauss = 0.5 / math.sqrt(3.0)
    positions = [(x, y) for x in (-2 * gauss, 2 * gauss) for y in (-gauss, gauss)]
    inertia = sum(2643.0 * 0.5 * shape(*position).T @ shape(*position) for position in positions)
    t = np.concatenate([shape(-0.8, -0.3), shape(0.8, -0.3)])
    velocity_change = t @ (0.0, speed, 0.0, 0.0, 0.0, 0.0)
    return (-0.5 * velocity_change @ np.linalg.solve(t @ np.linalg.solve(inertia, t.T),
                                                     velocity_change))  # fmt: skip


def test_a_stage_fixes_points_at_their_present_position(write_input, tmp_path, binary, same_bits):
    """A block falls for 40 ms; then two of its points are fixed, and its kinetic energy is lost."""
    groups = changed(flying_block(gravity=[0.0, -GRAVITY]), "control", steps=None)
    groups = changed(groups, "contact", normal_stiffness=1e12)
    points = [group("fixed_point", x=x, y=0.2, name=f"prop_{x}") for x in (0.2, 1.8)]
    stages = [{"name": "fall", "steps": 40}, {"name": "held", "steps": 60, "hold": "prop_*"}]
    file = write_input([*groups, *points, *(("stage", stage) for stage in stages)])
    with sitedda.Simulation(file, tmp_path / "hold.nc") as run:
        run.advance(40)
        fall = run.point_motions[0, 0]
        speed, mass = run.rates[0, 1], 2643.0 * 2.0
        assert speed == pytest.approx(-GRAVITY * 0.04, rel=1e-12)
        run.advance(20)  # the checkpoint is within the second stage
        assert run.energies["changed"] == pytest.approx(stopped(speed), rel=1e-3)
    assert sitedda.resume(file, tmp_path / "hold.nc").complete
    with xr.open_dataset(tmp_path / "hold.nc") as data:
        assert abs(data.displacement.values[41:, 0] - fall).max() < 1e-4
        assert abs(float(data.energy_balance[-1])) < 1e-9 * mass
    sitedda.run(file, output=tmp_path / "whole.nc")
    same_bits(tmp_path / "whole.nc", tmp_path / "hold.nc")
    binary.ok("run", file, "-o", tmp_path / "native.nc", "-q")
    same_bits(tmp_path / "whole.nc", tmp_path / "native.nc")


def test_a_stage_begins_loads(write_input, tmp_path):
    """The times of a load of a stage start with the stage: v = F t / m."""
    groups = changed(flying_block(), "control", steps=None)
    load = {"name": "push", "x": 1.0, "y": 0.5, "time": [0.0, 1.0], "force_x": [5e3, 5e3]}
    stages = [{"name": "wait", "steps": 30}, {"name": "push", "steps": 30, "loads": "push"}]
    file = write_input([*groups, ("load", load), *(("stage", stage) for stage in stages)])
    with sitedda.Simulation(file, tmp_path / "load.nc") as run:
        run.advance(30)
        assert not run.rates.any()
        run.advance(10)
    with sitedda.Simulation(file, tmp_path / "load.nc", resume=True) as run:
        run.advance(20)
        assert run.rates[0, 0] == pytest.approx(5e3 * 0.03 / (2643.0 * 2.0), rel=1e-9)


@pytest.mark.parametrize(
    ("stages", "message"),
    [
        ([{"hold": "prob_*"}], "hold: nothing is named 'prob_*'"),
        ([{"loads": "pull"}], "loads: nothing is named 'pull'"),
        ([{"hold": "prop"}, {"hold": "prop"}], "fixed point 'prop' has been held since stage 's0'"),
        ([{"loads": "push"}, {"loads": "push"}], "'push' has begun in stage 's0'"),
    ],
)
def test_invalid_additions_of_a_stage_are_refused(stages, message, write_input):
    groups = changed(flying_block(), "control", steps=None)
    load = {"name": "push", "x": 1.0, "y": 0.5, "time": [0.0, 1.0]}
    file = write_input([
        *groups, ("load", load), group("fixed_point", name="prop", x=1.0, y=0.5),
        *(("stage", {"name": f"s{i}", "steps": 5} | stage) for i, stage in enumerate(stages)),
    ])  # fmt: skip
    with pytest.raises(sitedda.InputError) as error:
        sitedda.Simulation(file)
    assert message in str(error.value) and "group &stage (line " in str(error.value)


# --- Killed in every stage -----------------------------------------------------------------------

KILLED = """
import sys, time, sitedda
run = sitedda.Simulation(sys.argv[1], sys.argv[2])
run.advance(int(sys.argv[3]))
run.checkpoint()
print("ready", flush=True)
while True:
    run.advance(1)
    run.checkpoint()
    time.sleep(0.001)  # stays in the stage until it is killed
"""
LONG = [dict(stage) | ({"steps": 200} if "steps" in stage else {}) for stage in STAGES]


def test_a_run_killed_in_any_stage_resumes_bit_identically(
    write_input, tmp_path, binary, same_bits
):
    """SIGKILL of Python and of the executable; each continues the run of the other."""
    groups = changed(beam(LONG), "output", checkpoint_interval=5, block_interval=50)
    file = write_input(groups)
    sitedda.run(file, output=tmp_path / "whole.nc")
    begun = set()
    for i, after in enumerate((1, 150, 199, 250)):
        output = tmp_path / f"python_{i}.nc"
        child = subprocess.Popen([sys.executable, "-c", KILLED, file, output, str(after)],
                                 stdout=subprocess.PIPE)  # fmt: skip
        assert child.stdout.readline() == b"ready\n"
        time.sleep(0.02)
        child.send_signal(signal.SIGKILL)
        assert child.wait() == -signal.SIGKILL
        process = binary.ok("resume", file, "-o", output, "-q")
        begun.add(int(process.stdout.split("resumed at step ")[1].split(",")[0]) // 200)
        same_bits(tmp_path / "whole.nc", output)
    assert {0, 1} <= begun
    for i in range(4):
        output = tmp_path / f"native_{i}.nc"
        child = subprocess.Popen([binary.path, "run", file, "-o", output, "-q"])
        while child.poll() is None and not Path(f"{output}.checkpoint").exists():
            time.sleep(0.001)
        time.sleep(0.03 * i)
        child.send_signal(signal.SIGKILL)
        child.wait()
        sitedda.resume(file, output)
        same_bits(tmp_path / "whole.nc", output)


# --- Stopped on request --------------------------------------------------------------------------


def catches(process: int, number: signal.Signals) -> bool:
    """Return whether a process has a handler for a signal."""
    status = Path(f"/proc/{process}/status").read_text()
    return bool(int(status.split("SigCgt:")[1].split()[0], 16) >> (number - 1) & 1)


def test_a_static_stage_stops_on_request(write_input, tmp_path, binary):
    """A wall of 10,000 bricks needs a minute of static steps; a signal ends them at once."""
    wall = {"brick_length": 1.0, "brick_height": 0.5, "bricks": 100, "courses": 100}
    groups = [
        group("control", time_step=1e-3, gravity=[0.0, -9.81]),
        group("contact", normal_stiffness=1e12),
        ("material", dict(ROCK)),
        ("joint", dict(DRY)),
        ("wall", wall),
        *(group("fixed_point", x=x + 0.5, y=0.25) for x in range(100)),
        group("stage", name="rest", kind="static"),
    ]
    output = tmp_path / "out.nc"
    command = [binary.path, "run", write_input(groups), "-o", output, "-q"]
    child = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    while not catches(child.pid, signal.SIGTERM):
        time.sleep(0.01)
    child.send_signal(signal.SIGTERM)
    text = child.communicate()[1]
    assert child.returncode == 6
    assert "interrupted" in text and text.count("\n") == 1  # in the stage, or before it begins
    assert ("stage 'rest' was interrupted" in text) == ("resume" in text)
    assert not output.exists()
