# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes on probable mistakes in a model: one line in run, native run and check; none if correct."""

import math
import re
from pathlib import Path

import pytest
from model_text import changed, flying_block, group, namelist, rectangle, without

import sitedda
from sitedda.command import main
from sitedda.errors import CostWarning

ROCK = {"name": "rock", "density": 2500.0, "young_modulus": 1e9, "poisson_ratio": 0.2}
GRAVITY = 9.81
INPUTS = sorted((Path(__file__).parents[3] / "inputs").rglob("*.nml"))


def pile(*blocks, supports="xy", **control) -> list:
    """A fixed floor of 4 m x 1 m with a brick of 1 m, or with other blocks."""
    bricks = blocks or (("brick", rectangle(0.0, 0.0, 1.0, 1.0)),)
    timing = {} if "duration" in control else {"steps": 3}
    return [
        ("control", {"time_step": 1e-3, "gravity": [0.0, -GRAVITY], **timing, **control}),
        group("contact", normal_stiffness=1e9),
        ("material", dict(ROCK)),
        group("joint", name="dry", friction_angle=30.0),
        group("block", name="floor", vertices=rectangle(-2.0, -1.0, 4.0, 1.0)),
        *(group("block", name=name, vertices=shape) for name, shape in blocks or bricks),
        *(group("fixed_point", x=x, y=-0.5, block="floor", direction=supports)
          for x in (-1.5, 1.5)),
    ]  # fmt: skip


def notes_of(groups, write_input) -> list[str]:
    with sitedda.Simulation(write_input(groups)) as run:
        return run.notes.splitlines()


def shaken(**motion) -> list:
    """The pile in coordinates that move with a record."""
    file = str(Path(__file__).parents[2] / "data/records/sine.at2")
    return [*pile(base_motion_x="quake"), group("motion", name="quake", file=file, **motion)]


SIDES = [
    *without(pile(analysis="plane_strain", settle=True), "fixed_point"),
    group("block", name="column", vertices=rectangle(-6.0, -1.0, 4.0, 1.0)),
    group("boundary", kind="viscous", side="bottom"),
    group("boundary", kind="free_field", side="left"),
]
YIELDING = {"law": "mohr_coulomb", "cohesion": 1e6, "friction_angle": 30.0}
TWINS = [("twin", rectangle(x, 0.0, 0.5, 0.5)) for x in (0.0, 1.0)]
FLOOD = {"name": "flood", "surface": [-2.0, 0.0, 2.0, 0.0]}
HEAP = {"left": (-1.0, 2.0), "right": (0.0, 2.0), "upper": (-0.5, 3.0)}
FALLING = [(name, rectangle(*place, 1.0, 1.0)) for name, place in HEAP.items()]
PILLAR = [(f"drum {i}", rectangle(0.0, float(i), 1.0, 1.0)) for i in range(4)]
ODD = {
    "strain": (changed(pile(*PILLAR), "material", young_modulus=1e6),
               r"the weight strains block 'drum 0' by about 8.584 %, limit 2 %: 85838 Pa / young"),
    "depth": (changed(pile(), "contact", normal_stiffness=1e4),
              r"the weight presses block 'brick' about 1.226 m into its support, 122\.6 %"),
    "no stiffness": (changed(pile(), "contact", normal_stiffness=1e-3),
                     r"the weight presses block 'brick' about 1.226e7 m into its support"),
    "gravity": (pile(gravity=[0.0, GRAVITY]), r"gravity = 0, 9.81 m/s² points upwards"),
    "radians": (changed(pile(), "joint", friction_angle=0.52),
                r"friction_angle = 0.52° of &joint 'dry': is it meant in radians\? .* 29.79°"),
    "duration": (
        pile(duration=7e-4),
        r"duration = 7\S* s of stage 'run' is not a multiple of time_step = .* rounded to 0.001 s"),
    "no support": (
        without(pile(), "fixed_point"),
        r"nothing supports the blocks against gravity, because no &fixed_point and no &boundary"),
    "support across gravity": (pile(supports="x"), r"nothing supports the blocks against gravity"),
    "beside the floor": (
        pile(("brick", rectangle(5.0, 0.0, 1.0, 1.0)), ("tile", rectangle(7.0, 3.0, 1.0, 1.0))),
        r"nothing supports block 'brick' \(and 1 more\) against gravity",
    ),
    "gravity in cm/s²": (pile(gravity=[0.0, -981.0]),
                         r"gravity = 0, -981 m/s²: is it meant in cm/s"),
    "gravity in mm/s²": (pile(gravity=[0.0, -9810.0]), r"gravity = 0, -9810 m/s²: is it meant in"),
    "gravity sideways": (
        without(pile(gravity=[GRAVITY, 0.0], supports="xy"), "nothing"),
        r"gravity = 9.81, 0 m/s² acts only along x; the second value is vertical",
    ),
    "unit weight": (
        changed(pile(), "material", density=25.0),
        r"density = 25 kg/m³ of &material 'rock': is it a unit weight in kN/m³\? .* 2548 kg/m³"),
    "unit weight of soft rock": (
        [
            *without(pile(gravity=[0.0, 0.0]), "material"),
            group("material", **(ROCK | {"density": 25.0, "young_modulus": 5e3})),
        ],
        r"density = 25 kg/m³ of &material 'rock': is it a unit weight",
    ),
    "lengths in mm": (
        pile(("stone", rectangle(6000.0, 0.0, 1.0, 1.0)), gravity=[0.0, 0.0]),
        r"the model is 6003 m wide or high; lengths must be in m, not in mm",
    ),
    "cohesion in kPa": (
        changed(pile(), "joint", cohesion=50.0),
        r"cohesion = 50 Pa of &joint 'dry' is almost zero: is it meant in kPa or MPa\?"),
    "tensile strength in MPa": (
        changed(pile(), "joint", tensile_strength=2.0),
        r"tensile_strength = 2 Pa of &joint 'dry' is almost zero: is it meant in kPa or MPa\?",
    ),
    "record in gal": (shaken(scale=100.0),
                      r"PGA = .* m/s² is .* g: is the record in gal \(cm/s²\), or scaled twice\?"),
    "step of a record": (changed(shaken(), "control", time_step=10.0),
                         r"motion 'quake' lasts .* s, fewer than ten steps of time_step = 10 s"),
    "one side": (SIDES, r"only one side has a free field: give both sides one, or neither"),
    "yielding of one block": (
        changed(pile()[:5] + pile()[-2:], "material", **YIELDING),
        r"&material 'rock' yields, but its block has uniform strain and yields as a whole",
    ),
    "few samples": ([*pile(), group("output", history_interval=500000)],
                    r"history_interval = 500000 of &output is more than the \d+ steps of the run"),
    "water of another unit": (
        [*pile(), group("water", surface=[-2.0, 5000.0, 2.0, 5000.0])],
        r"&water reaches up to 4999 m above the model, which is 2 m high: are its levels in m",
    ),
    "water that rises": (
        [*pile(), ("water", FLOOD | {"time": [0.0, 1.0], "rise": [0.0, 300.0]})],
        r"&water 'flood' reaches up to 299 m above the model",
    ),
    "level of another unit": ([*pile(), group("traction", side="top", level=600.0)],
                              r"&traction reaches up to 599 m above the model"),
    "water below all": ([*pile(), group("water", surface=[-2.0, -3.0, 2.0, -3.0])],
                        r"&water has no effect, because the water is below the model"),
    "soft bed": (
        [
            *without(pile(), "fixed_point"),
            group("boundary", kind="springs", side="bottom", stiffness_per_area=5e4),
        ],
        r"the weight presses the model about 0.6131 m into its bed of springs",
    ),
    "speed": (changed(pile(), "material", initial_velocity=[50.0, 0.0, 0.0]),
              r"initial_velocity of &material 'rock' is 50 m/s, faster than falling rock"),
    "turn": (changed(pile(), "material", initial_velocity=[0.0, 0.0, 300.0]),
             r"turns its blocks by 0.3 rad per step; check the third value \(rad/s\)"),
    "point on two blocks": (
        [*pile(), group("measured_point", name="joint", x=0.5, y=0.0)],
        r"measured point 'joint' lies on block 'floor' and block 'brick' and follows the first",
    ),
    "names": (pile(*TWINS), r"2 blocks are named 'twin': this name in a list selects all of them"),
}  # fmt: skip


@pytest.fixture(params=["python", "native"])
def output_of(request, binary, tmp_path, capsys, monkeypatch):
    """Return a caller that returns the text of a command; Python runs in this process."""

    def call(*words: str) -> str:
        if request.param == "native":
            process = binary(*words, folder=tmp_path)
            return process.stdout + process.stderr
        monkeypatch.chdir(tmp_path)
        main([*map(str, words), *(["--no-plot"] if words[0] == "run" else [])])
        return "".join(capsys.readouterr())

    return call


@pytest.mark.parametrize("name", ODD)
def test_a_probable_mistake_is_one_line(output_of, name, write_input):
    groups, message = ODD[name]
    file = write_input(groups)
    rows = [
        line
        for line in output_of("run", file, "-q").replace("\n      ", " ").splitlines()
        if line.startswith("note: ")
    ]
    assert len(rows) == 1 and re.search(message, rows[0]), rows
    report = re.sub(r"\n {24}(?!->)", " ", output_of("check", file))  # its lines are wrapped
    rows = [line for line in report.splitlines() if line.startswith("warn  input")]
    assert len(rows) == 1 and re.search(message, rows[0]), rows
    assert "nothing to do" not in report


MEANT = {
    "as drawn": pile(),
    "no friction": changed(pile(), "joint", friction_angle=0.0),
    "next to no friction": changed(pile(), "joint", friction_angle=0.01),
    "little friction": changed(pile(), "joint", friction_angle=5.0),
    "a falling block": pile(("brick", rectangle(0.0, 3.0, 1.0, 1.0))),
    "a falling heap": pile(*FALLING),
    "a pillar": pile(*PILLAR),
    "whole steps": pile(duration=3e-3),
    "many steps and a bit": pile(duration=0.2004),
    "no weight": without(pile(gravity=[0.0, 0.0]), "fixed_point"),
    "weight sideways": pile(gravity=[3.0, -GRAVITY]),
    "held along gravity alone": pile(supports="y"),
    "a flooded model": [*pile(), group("water", surface=[-2.0, 15.0, 2.0, 15.0])],
    "water at the foot": [*pile(), group("water", surface=[-2.0, -0.9, 2.0, -0.9])],
    "a bed": [
        *without(pile(), "fixed_point"),
        group("boundary", kind="springs", side="bottom", stiffness_per_area=1e7),
    ],
    "a hit": changed(pile(), "material", initial_velocity=[30.0, 0.0, 50.0]),
    "a point of a named block": [
        *pile(),
        group("measured_point", name="joint", x=0.5, y=0.0, block="brick"),
    ],
    "a point inside": [*pile(), group("measured_point", name="top", x=0.5, y=1.0)],
    "nameless twins": pile(*(("", shape) for _, shape in TWINS)),
}


@pytest.mark.parametrize("name", MEANT)
def test_a_deliberate_value_has_no_note(name, write_input):
    assert notes_of(MEANT[name], write_input) == []


def test_a_block_hanging_on_a_bolt_is_supported(write_input):
    """A bolt suspends the block from the floor; without the bolt it has no support."""
    hung = pile(("hung", rectangle(3.0, -1.0, 1.0, 1.0)))
    bolt = group("bolt", name="bolt", from_=[1.5, -0.5], to=[3.5, -0.5], axial_stiffness=1e8)
    assert "nothing supports block 'hung' against gravity" in notes_of(hung, write_input)[0]
    assert notes_of([*hung, bolt], write_input) == []


def test_a_fixed_point_of_a_later_stage_counts(write_input):
    groups = pile(supports="none")
    for at, (name, values) in enumerate(groups):
        if name == "fixed_point":
            groups[at] = (name, values | {"name": "grip", "direction": "xy"})
    groups[0][1].pop("steps")
    stages = [group("stage", name=name, steps=2) for name in ("fall", "hold")]
    stages[1][1]["hold"] = "grip"
    assert notes_of([*groups, *stages], write_input) == []


def test_rollers_support_along_their_normals(write_input):
    """Rollers on vertical edges do not carry weight; on an inclined edge they do."""
    model = sitedda.Model(time_step=1e-3, steps=2, gravity=(0, -GRAVITY))
    model.material("rock", density=2500.0, young_modulus=1e9, poisson_ratio=0.2)
    model.joint("dry", friction_angle=30.0)
    model.block([0, 0, 2, 0, 2, 1, 1, 1], name="wedge")
    model.boundary("side", "roller", along=[2.0, 0.0, 2.0, 1.0])
    with sitedda.Simulation(write_input(model.to_namelist())) as run:
        assert "nothing supports the blocks against gravity" in run.notes
    model.boundary("slope", "roller", along=[0.0, 0.0, 1.0, 1.0])
    with sitedda.Simulation(write_input(model.to_namelist())) as run:
        assert run.notes == ""


def test_a_name_of_two_blocks_selects_the_one_at_the_point(write_input):
    twins = pile(*TWINS)
    point = group("measured_point", name="right", x=1.25, y=0.25, block="twin")
    with sitedda.Simulation(write_input([*twins, point])) as run:
        assert run.notes.count("\n") == 0


def test_the_reference_of_stop_must_be_one_block(write_input):
    twins = pile(*TWINS)
    stop = group("stop", displacement=1.0, reference="twin")
    with pytest.raises(sitedda.InputError, match="'twin' is the name of 2 blocks"):
        sitedda.Simulation(write_input([*twins, stop]))


# --- Results of a run ----------------------------------------------------------------------------


def unwrapped(text: str) -> list[str]:
    """Lines of a verdict without wrapping."""
    return re.sub(r"\n {7,}", " ", text).splitlines()


def test_large_strains_and_penetrations_are_reported_at_the_end(output_of, write_input):
    """By statics, a brick of weight W penetrates the floor by W/2k."""
    soft = changed(pile(settle=True), "contact", normal_stiffness=1e5)
    output = output_of("run", write_input(soft), "-q")
    row = next(line for line in unwrapped(output) if "a vertex of block" in line)
    depth = float(re.search(r"penetrates (\S+) m into block", row)[1])
    assert depth == pytest.approx(2500 * GRAVITY / 2 / 1e5, rel=1e-3), row
    assert re.search(r"12\.2\d* % of the size .* limit 5 %", row)
    assert "has a strain of" not in output

    weak = changed(pile(settle=True), "material", young_modulus=2e5)
    output = output_of("run", write_input(weak), "-q")
    strain = "block .* has a strain of .* % at t = .* s; small-strain theory holds up to 2 %"
    assert re.search(strain, " ".join(output.split()))
    assert "a vertex of block" not in output


def test_the_largest_penetration_is_reported_with_its_time(output_of, write_input):
    """A stone of mass m falls by h on two corners: 2kd²/2 = mg(h + d); it ends in the air."""
    stiffness, height = 2e6, 0.2
    groups = pile(("stone", rectangle(0.0, height, 1.0, 1.0)), duration=0.4,
                  integration="backward_euler")  # fmt: skip
    groups = changed(changed(groups, "contact", normal_stiffness=stiffness), "control",
                     time_step=1e-4)  # fmt: skip
    output = output_of("run", write_input(groups), "-q")
    row = next(line for line in unwrapped(output) if "a vertex of block" in line)
    weight = 2500 * GRAVITY
    static = weight / (2 * stiffness)
    depth = static * (1 + math.sqrt(1 + 2 * height / static))
    match = re.search(r"penetrates (\S+) m into block .* at t = (\S+) s", row)
    assert depth > 0.05
    assert float(match[1]) == pytest.approx(depth, rel=0.02), row
    fall, omega = math.sqrt(2 * height / GRAVITY), math.sqrt(GRAVITY / static)
    slowed = math.pi / 2 + math.atan(math.sqrt(static / (2 * height)))
    assert float(match[2]) == pytest.approx(fall + slowed / omega, rel=0.02), row


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_gap_closed_by_static_steps_is_reported(output_of, write_input, command):
    """Displacements count from equilibrium, so no other result contains the closure."""
    gap, sinks = 0.01, 2500 * GRAVITY / 2 / 1e9
    file = write_input(pile(("brick", rectangle(0.0, gap, 1.0, 1.0)), settle=True))
    output = " ".join(output_of(command, file).split())
    match = re.search(r"block 2 'brick' is (\S+) m from its position in the input", output)
    match = match or re.search(r"block 2 'brick' moved farthest, by (\S+) m", output)
    assert float(match[1]) == pytest.approx(gap + sinks, rel=1e-3)


def test_small_strains_and_penetrations_are_not_reported(output_of, write_input):
    output = output_of("run", write_input(pile()), "-q")
    assert "has a strain of" not in output and "a vertex of block" not in output


@pytest.mark.parametrize("file", INPUTS, ids=lambda file: file.stem)
def test_shipped_inputs_have_no_probable_mistakes(file):
    with sitedda.Simulation(file) as run:
        notes = [line for line in run.notes.splitlines() if "softens within a step" not in line]
        assert not notes and "is it meant in" not in run.block_notes()


def test_a_compliant_base_without_motion_is_reported(write_input):
    """With a motion, or with a base that only absorbs, the same model has no note."""
    model = sitedda.Model(time_step=1e-3, steps=2, analysis="plane_strain")
    model.material("soil", density=2000.0, young_modulus=1e8, poisson_ratio=0.3)
    model.joint("j", friction_angle=45.0)
    model.block(rectangle(0.0, 0.0, 10.0, 1.0))
    model.motion("m", values=[0.0, 1.0, 0.0], time_step=0.01, quantity="velocity")
    for kind, motion, message in (("compliant", "", "has no motion"), ("compliant", "m", ""),
                                ("viscous", "", "")):  # fmt: skip
        changed_model = sitedda.Model.from_namelist(
            model.to_namelist() if motion else without_motion(model)
        )
        changed_model.boundary(
            "base", kind, side="bottom", **({"motion_x": motion} if motion else {})
        )
        with sitedda.Simulation(write_input(changed_model.to_namelist())) as run:
            assert message in run.notes, (kind, motion)
            assert bool(run.notes) == bool(message), run.notes


def without_motion(model) -> str:
    """The text of a model without its motion."""
    return re.sub("(?s)&motion.*?/\n", "", model.to_namelist())


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("&joint_set angle = 30, spacing = 500 /", "spacing = 500 m is more than 56.57 m"),
        ("&mesh regions = '*', size = 2, fine_size = 4, fine_along = 0, 0, 9, 9 /",
         "fine_size = 4 m is above size = 2 m"),
        ("&joint_set angle = 30, spacing = 50 /", ""),
        ("&mesh regions = '*', size = 4, fine_size = 2, fine_along = 0, 0, 9, 9 /", ""),
    ],
)  # fmt: skip
def test_doubtful_sizes_of_regions_and_joint_sets_have_notes(more, message, write_input):
    groups = [group for group in pile() if group[0] not in ("block", "fixed_point")]
    region = f"&region outline = 0, 0, 40, 0, 40, 40, 0, 40 /\n{more}\n"
    with sitedda.Simulation(write_input(namelist(groups) + region)) as run:
        assert message in run.block_notes()
        assert message or "m is" not in run.block_notes()


def test_many_cells_are_announced(monkeypatch):
    monkeypatch.setattr("sitedda.build.meshing.meshed._MANY", 10)
    model = sitedda.Model(time_step=1e-3, steps=1)
    model.block(rectangle(0.0, 0.0, 10.0, 1.0), name="beam")
    model.mesh(blocks="beam", size=0.5)
    with pytest.warns(CostWarning, match="about 40 cells take minutes"):
        model.build()


def test_blocks_of_very_different_widths_have_notes(write_input, binary):
    """A width of 1e-9 of the model once ended the process by overflow of an integer."""
    wall = {"brick_length": 6.5e-9, "brick_height": 0.5, "bricks": 2, "courses": 3}
    groups = changed(flying_block(gravity=[0.0, -9.8]), "block", vertices=rectangle(-1, -1, 5, 1))
    groups = [*without(groups, "measured_point"), ("wall", wall)]
    groups.append(group("fixed_point", x=0.0, y=-0.5))
    assert binary("check", write_input(groups)).returncode >= 0  # no signal
