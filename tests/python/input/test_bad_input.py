# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: one message with file, group and value from both programs, and no changed files."""

import re
import time
from functools import partial

import numpy as np
import pytest
from model_text import DRY, changed, flying_block, namelist, rectangle, tower, without

import sitedda
from sitedda.input.groups import read_values
from sitedda.input.input_text import find_groups

SQUARE = rectangle(0.0, 0.0, 1.0, 1.0)
OLD = b"an older result"
AUGMENTED = {"penetration_tolerance": 1e-9}


def blocks(*outlines, **options) -> list:
    """Return the model of the flying block with other blocks."""
    groups = without(without(flying_block(**options), "block"), "measured_point")
    return [*groups, *(("block", {"vertices": outline}) for outline in outlines)]


def moved(**values) -> list:
    """Return the tower with a changed motion."""
    return changed(tower(), "motion", **values)


def with_record(text: str, **values) -> dict:
    """Return the tower with a record file of this text as motion."""
    source = {"values": None, "time_step": None, "file": "record.txt"}
    format = {"quantity": "acceleration", "unit": "m/s2", "format": "text"}
    return {"groups": moved(**source | format | values), "record.txt": text}


def refused(case: str, groups, group: str, *phrases: str):
    """Return a case: name, input, group that the message must name, and its required phrases."""
    return pytest.param(groups, group, phrases, id=case)


def invalid(case: str, group: str, /, *phrases: str, contact=(), **values):
    """Return a case: the tower with changed variables of a group and of &contact."""
    groups = changed(changed(tower(), "contact", **dict(contact)), group, **values)
    return refused(case, groups, f"&{group}", *phrases)


def joint_of(law: str, case: str, /, *phrases: str, **values):
    """Return a case: the tower with a joint of a law and changed variables of it."""
    strengths = {} if law == "cohesive" else {"cohesion": None, "tensile_strength": None}
    return invalid(case, "joint", *phrases, **{"law": law} | strengths | LAWS[law] | values)


LAWS = {
    "barton_bandis": {"jrc": 8.0, "jcs": 1e8, "normal_stiffness_per_area": 1e9,
                      "max_closure": 1e-4},
    "plesha": {},
    "rate_state": {"direct_effect": 0.01, "threshold_velocity": 1e-6},
    "cohesive": {"cohesion": 1e5, "tensile_strength": 1e5, "fracture_energy": 4.0,
                 "normal_stiffness_per_area": 1e9},
}  # fmt: skip
barton_bandis, plesha, rate_state, cohesive = (partial(joint_of, law) for law in LAWS)


def of_blocks(case: str, outlines: list, *phrases: str):
    """Return a case with blocks of these outlines."""
    return refused(case, blocks(*outlines), "&block", *phrases)


def with_group(case: str, group: str, /, *phrases: str, **values):
    """Return a case with the tower and one more group."""
    return refused(case, [*tower(), (group, values)], f"&{group}", *phrases)


CASES = [
    # The most frequent ones
    with_group("unknown group", "blok", "no such group", "&block", x=1.0),
    invalid("unknown variable", "control", "time_stop", time_stop=1.0),
    invalid("missing record", "motion", "gone.smc", values=None, file="gone.smc"),
    invalid("negative density", "material", "density", "-5", density=-5.0),
    invalid("zero time step", "control", "time_step = 0", time_step=0.0),
    of_blocks("self-crossing", [[0.0, 0, 1, 1, 1, 0, 0, 1]], "crosses"),
    of_blocks("clockwise", [[0.0, 0, 0, 1, 1, 1, 1, 0]], "clockwise"),
    of_blocks("overlap", [SQUARE, rectangle(0.5, 0.5, 1, 1)], "overlaps", "0.5 m"),
    with_group("fixed point outside", "fixed_point", "99", "outside every block", x=99.0, y=0.5),
    invalid("one sample", "motion", "too few samples", values=[0.5]),
    refused("record of one sample", with_record("0.0 1.0\n"), "&motion", "record.txt", "sample"),
    refused("empty record", with_record(""), "&motion", "record.txt"),
    # Numbers
    invalid("density missing", "material", "density", density=None),
    invalid("not a number", "control", "time_step", "NaN", time_step=np.nan),
    invalid("infinite", "material", "density", "Inf", density=np.inf),
    invalid("Poisson", "material", "poisson_ratio", "0.5", poisson_ratio=0.5),
    invalid("Poisson missing", "material", "poisson_ratio", poisson_ratio=None),
    invalid("no stiffness", "material", "young_modulus", young_modulus=0.0),
    invalid("stiffness missing", "material", "young_modulus is missing", young_modulus=None),
    invalid("friction missing", "joint", "friction_angle", friction_angle=None),
    invalid("tension", "joint", "tensile_strength = -5", tensile_strength=-5.0),
    invalid("time step missing", "control", "time_step is missing", time_step=None),
    invalid("no room to move", "control", "ratio = 0", max_displacement_ratio=0.0),
    invalid("step control", "control", "'often'", time_step_control="often"),
    invalid("endless gravity", "control", "gravity", gravity=[0.0, 1e40]),
    invalid("shear springs", "contact", "shear_ratio = -2", shear_ratio=-2.0),
    invalid("one iteration", "contact", "max_iterations = 1", max_iterations=1),
    invalid("any force", "contact", "force_tolerance = 1", force_tolerance=1.0),
    invalid("no supports", "contact", "fixed_point_ratio = 0", fixed_point_ratio=0.0),
    invalid("frames", "output", "block_interval = -1", block_interval=-1),
    invalid("friction", "joint", "friction_angle", "90", friction_angle=90.0),
    rate_state("friction without a direct effect", "direct_effect is missing", direct_effect=None),
    rate_state("a state without a distance", "state_distance is missing", evolution_effect=0.01),
    rate_state("an age of nothing", "initial_age", initial_age=0.0),
    rate_state("friction that rebounds", "excludes restitution", restitution=0.5),
    rate_state("friction with dashpots", "excludes damping", damping=1e5),
    rate_state("yielding without roughness", "initial_friction_angle is missing",
               law="continuously_yielding", direct_effect=None, threshold_velocity=None),
    rate_state("a joint that slip strengthens", "initial_friction_angle = 20 is below",
               law="continuously_yielding", direct_effect=None, threshold_velocity=None,
               friction_angle=30.0, initial_friction_angle=20.0, roughness=1e-3),
    cohesive("bonds without a fracture energy", "fracture_energy is missing", fracture_energy=None),
    cohesive("bonds without tension", "cohesion and tensile_strength above 0",
             tensile_strength=None),
    cohesive("bonds without stiffness", "normal_stiffness_per_area is missing",
             normal_stiffness_per_area=None),
    cohesive("bonds that break at once", "fracture_energy = 4 N/m",
             "energy stored at the strength, 5 N/m", "break at once"),
    plesha("asperities steeper than friction", "asperity_angle = 40 is above friction_angle",
           "slip back by itself", asperity_angle=40.0, friction_angle=30.0),
    plesha("asperities that no force climbs", "asperity_angle = 40", "add up to more than 89",
           friction_angle=60.0, asperity_angle=40.0),
    plesha("asperities without an angle", "asperity_angle is missing"),
    plesha("shear stiffness of a rough joint alone", "needs normal_stiffness_per_area",
           asperity_angle=4.0, shear_stiffness_per_area=1e9),
    plesha("a rough joint that jumps back", "1000 times the shear stiffness", "jump back",
           asperity_angle=10.0, contact={"shear_ratio": 1e3}),
    invalid("a solver that is gone", "control", "'banded'", "'direct'", solver="banded"),
    invalid("joint law", "joint", "law", "'mohr'", "'mohr_coulomb'", law="mohr"),
    invalid("residual above peak", "joint", "residual_friction_angle = 80", "above the peak",
            law="mohr_coulomb", residual_friction_angle=80.0),
    invalid("residual cohesion above peak", "joint", "residual_cohesion", "above the peak",
            law="mohr_coulomb", residual_cohesion=1e14, cohesion=1e3),
    invalid("residual strength without its law", "joint", "residual_cohesion", "'mohr_coulomb'",
            "'coulomb'", residual_cohesion=1e3),
    invalid("more dilation than friction", "joint", "dilation_angle = 59", "energy",
            law="mohr_coulomb", dilation_angle=59.0),
    invalid("a limit of no dilation", "joint", "dilation_slip", law="mohr_coulomb",
            dilation_slip=0.1),
    barton_bandis("negative closure", "max_closure", "positive", max_closure=-1e-3),
    barton_bandis("no closure", "max_closure", "missing", normal_stiffness_per_area=None),
    barton_bandis("two closures", "compressive_strength", compressive_strength=1e8),
    barton_bandis("closure beyond the formulas", "jrc = 0.5", "range", max_closure=None,
                  normal_stiffness_per_area=None, jrc=0.5, compressive_strength=1.1e8),
    barton_bandis("no roughness", "jrc is missing", jrc=None),
    invalid("four points", "joint", "contact_points = 4", "2, 3, 5, 9 or 17", contact_points=4),
    invalid("points of augmented contacts", "joint", "contact_points", "penetration_tolerance",
            contact=AUGMENTED, contact_points=3),
    invalid("a law under the original rules", "joint", "original",
            contact={"contact_rules": "original"}, law="mohr_coulomb"),
    invalid("a law with augmented contacts", "joint", "penetration_tolerance", contact=AUGMENTED,
            law="mohr_coulomb"),
    invalid("cohesion", "joint", "cohesion", "-1", cohesion=-1.0),
    invalid("no steps", "control", "duration", "steps", steps=None),
    invalid("both", "control", "duration", "steps", duration=1.0),
    invalid("half steps", "control", "steps = 1.5", steps=1.5),
    invalid("negative steps", "control", "steps = -3", steps=-3),
    invalid("too short", "control", "duration", steps=None, duration=1e-5),
    invalid("dynamic factor", "control", "dynamic_factor", dynamic_factor=1.2),
    invalid("gravity", "control", "gravity", "NaN", gravity=[0.0, np.nan]),
    invalid("one gravity", "control", "gravity", "is missing", gravity=-9.81),
    invalid("stiffness", "contact", "normal_stiffness", normal_stiffness=-1.0),
    invalid("rebound", "joint", "restitution = 1.5", restitution=1.5),
    invalid("attracting joint", "joint", "restitution = -0.1", restitution=-0.1),
    invalid("driving dashpot", "joint", "damping = -1", damping=-1.0),
    invalid("rebound under the original rules", "joint",
            "restitution cannot be combined with contact_rules = 'original'",
            contact={"contact_rules": "original"}, restitution=0.5),
    invalid("dashpots of augmented contacts", "joint",
            "damping cannot be combined with penetration_tolerance", contact=AUGMENTED,
            damping=5.0),
    invalid("interval", "output", "history_interval", history_interval=0),
    invalid("text", "control", "fast", time_step="fast"),
    invalid("word", "control", "analysis", "'3d'", analysis="3d"),
    invalid("solver", "control", "solver", "'magic'", solver="magic"),
    invalid("layers", "layers", "thickness", "-1", thickness=-1.0),
    invalid("no layers", "layers", "count", "0", count=0),
    invalid("no width", "layers", "width is missing", width=None),
    with_group("no drums", "drums", "height = 0", width=1.0, height=0.0),
    with_group("no bricks", "wall", "brick_height", brick_length=1.0),
    # Names
    invalid("material name", "layers", "material", "'gold'", material="gold"),
    invalid("joint name", "layers", "joint", "'glue'", joint="glue"),
    invalid("motion name", "fixed_point", "motion_x", "'x'", motion_x="x"),
    invalid("motion across what is held", "fixed_point", "not fixed", direction="y"),
    invalid("base motion", "control", "base_motion_y", "'x'", base_motion_y="x"),
    invalid("block name", "measured_point", "block", "'no'", block="no"),
    invalid("other block", "measured_point", "layer_1", block="layer_1"),
    refused("twice", [*tower(), ("material", tower()[3][1])], "&material", "'rock'", "twice"),
    with_group("two titles", "run", "only once", title="b"),
    invalid("point twice", "measured_point", "twice", name="surface"),
    invalid("nameless", "measured_point", "name", name=None),
    invalid("nameless motion", "motion", "name is missing", name=None),
    with_group("joint twice", "joint", "twice", name="bedding", friction_angle=3.0),
    invalid("half a place", "fixed_point", "y is missing", y=None),
    invalid("direction", "fixed_point", "direction = 'z'", direction="z"),
    # Shapes
    of_blocks("two corners", [[0.0, 0.0, 1.0, 0.0]], "2", "at least 3"),
    of_blocks("no corners", [[]], "vertices"),
    of_blocks("half a corner", [[0.0, 0, 1, 0, 1, 1, 0]], "vertices"),
    of_blocks("flat", [[0.0, 0, 1, 0, 2, 0]], "vertices"),
    of_blocks("corner twice", [[0.0, 0, 1, 0, 1, 0, 1, 1, 0, 1]], "repeats a vertex"),
    of_blocks("touches itself", [[0.0, 0, 4, 0, 4, 2, 2, 0, 0, 2]], "touches itself"),
    of_blocks("vertex not a number", [[0.0, 0, 1, np.nan, 1, 1]], "vertices", "NaN"),
    of_blocks("inside another", [rectangle(0, 0, 3, 3), rectangle(1, 1, 1, 1)], "overlaps"),
    of_blocks("the same twice", [SQUARE, SQUARE], "overlaps"),
    of_blocks("a cross of two", [rectangle(-2, 0, 5, 1), rectangle(0, -2, 1, 5)], "overlaps"),
    # Records, motions, loads
    invalid("both sources", "motion", "file", "values", file="record.txt"),
    invalid("no source", "motion", "file", "values", values=None),
    invalid("quantity", "motion", "'jerk'", quantity="jerk"),
    invalid("unit", "motion", "'gal'", unit="gal"),
    invalid("motion step", "motion", "time_step", "-0.01", time_step=-0.01),
    invalid("no motion step", "motion", "time_step", time_step=None),
    invalid("taper", "motion", "taper = 2", taper=2.0),
    invalid("drift", "motion", "drift_order = 7", drift_order=7),
    invalid("value", "motion", "values", "NaN", values=[0.0, np.nan, 1.0]),
    invalid("gap in values", "motion", "values", "Inf", values=[0.0, np.inf, 1.0]),
    refused("letters in a record", with_record("0.0 1.0\n0.1 abc\n0.2 1.0\n"), "&motion",
            "record.txt", "abc"),
    refused("record NaN", with_record("0.0 1.0\n0.1 NaN\n0.2 1.0\n"), "&motion", "record.txt"),
    refused("record format", with_record("0.0 1.0\n", format="xls"), "&motion", "'xls'"),
    with_group("load", "load", "time", x=1.0, y=0.5, time=[0.0]),
    with_group("load backwards", "load", "time", x=1.0, y=0.5, time=[1.0, 0.0], force_x=[1.0, 2.0]),
    with_group("load of other length", "load", "force_x", x=1.0, y=0.5, time=[0.0, 1.0],
               force_x=[1.0]),
    with_group("amplification point", "amplification", "surface", "'top'", surface="top",
               lowest=1.0, highest=9.0),
    with_group("amplification band", "amplification", "highest", lowest=9.0, highest=1.0),
]  # fmt: skip

# Texts that are not namelists: name, text, required phrases of the message.
TOWER = namelist(tower())
TEXTS = {
    "no slash": (TOWER.replace("/\n&contact", "\n&contact"), "&control", "slash"),
    "no last slash": (TOWER.rstrip().removesuffix("/"), "&output", "slash"),
    "open quote": (TOWER.replace("'tower.nc'", "'tower.nc"), "&output", "quote"),
    "prose": ("shake it well\n" + TOWER, "line 1", "'shake'"),
    "prose in other letters": ("xx" + "地" * 30 + "\n" + TOWER, "line 1", "地"),
    "stray word": (TOWER.replace("&contact", "oops\n&contact"), "line ", "'oops'"),
    "nameless group": ("& time_step = 1 /\n" + TOWER, "line 1"),
    "empty": ("", "&control"),
    "only a comment": ("! nothing yet\n", "&control"),
    "no control": (namelist(without(tower(), "control")), "&control"),
    "no material": (namelist(without(tower(), "material")), "&material"),
    "no joint": (namelist(without(tower(), "joint")), "&joint"),
    "no blocks": (namelist(without(without(flying_block(), "block"), "measured_point")), "block"),
    "two values": (TOWER.replace("time_step = 0.001", "time_step = 0.001, 0.002"), "&control"),
    "decimal comma": (TOWER.replace("density = 2643.0", "density = 2643,5"), "&material"),
    "a megabyte of noise": ("&control " + "x" * 1_000_000 + " /\n", "&control"),
    "a null byte": (TOWER.replace("steps = 60", "steps = 6\0"), "not a text file", "zero"),
    "a picture": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" * 20, "not a text file"),
}


@pytest.fixture
def both_refuse(binary, main, tmp_path):
    """Return a check that both programs refuse an input with one message, and keep the output."""

    def check(file, phrases) -> None:
        output = tmp_path / "tower.nc"
        output.write_bytes(OLD)
        messages = []
        for program in (binary, main):
            process = program("run", file, "--quiet", "--output", output)
            assert process.returncode == 1, (program.name, process.stdout, process.stderr)
            lines = process.stderr.strip().splitlines()
            assert len(lines) == 1, process.stderr
            assert program is main or lines[0].startswith(f"{program.name}: ")
            messages.append(lines[0].removeprefix(f"{program.name}: "))
        assert messages[0] == messages[1]
        for phrase in (str(file), *phrases):
            assert phrase in messages[0], f"{phrase!r} is not in {messages[0]!r}"
        assert output.read_bytes() == OLD
        assert not list(tmp_path.glob("*.partial"))
        with pytest.raises(sitedda.InputError, match=f"^{re.escape(messages[0])}$"):
            sitedda.run(file)

    return check


@pytest.mark.parametrize(("groups", "group", "phrases"), CASES)
def test_invalid_values_are_refused(groups, group, phrases, write_input, both_refuse, tmp_path):
    if isinstance(groups, dict):
        (tmp_path / "record.txt").write_text(groups["record.txt"])
        groups = groups["groups"]
    both_refuse(write_input(groups), [group, *phrases])


@pytest.mark.parametrize("name", TEXTS)
def test_texts_that_are_not_namelists_are_refused(name, write_input, both_refuse):
    text, *phrases = TEXTS[name]
    both_refuse(write_input(text), phrases)


def test_a_missing_file_is_named(both_refuse, tmp_path):
    both_refuse(tmp_path / "gone.nml", ["no such file"])


@pytest.mark.parametrize("line", [3, 40, 1000])
def test_the_message_gives_the_line_of_the_group(line, write_input):
    invalid_text = namelist([("material", {"density": -1.0})])
    other_groups = namelist([("control", {"time_step": 1.0, "steps": 1}), ("joint", dict(DRY))])
    file = write_input("\n" * (line - 1) + invalid_text + other_groups)
    with pytest.raises(sitedda.InputError, match=rf"&material \(line {line}\): density = -1"):
        sitedda.run(file)


def test_a_word_instead_of_a_number_is_not_reported_as_a_variable(write_input):
    with pytest.raises(sitedda.InputError, match="^((?!no variable).)*$"):
        sitedda.run(write_input(changed(tower(), "control", time_step="fast")))


# --- What must not be refused --------------------------------------------------------------------

UNUSUAL = {
    "windows line ends": lambda text: text.replace(b"\n", b"\r\n"),
    "byte-order mark": lambda text: b"\xef\xbb\xbf" + text,
    "both": lambda text: b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n"),
    "no last line end": lambda text: text.rstrip(),
    "tabs": lambda text: text.replace(b"   ", b"\t"),
    "capitals": lambda text: text.replace(b"&control", b"&CONTROL").replace(b"steps", b"STEPS"),
    "comments": lambda text: b"! caf\xc3\xa9 / & ' \"\n" + text.replace(b"\n", b" ! it's / & \"\n"),
    "one line": lambda text: text.replace(b"\n", b" "),
    "exponent d": lambda text: text.replace(b"2643.0", b"2.643D3"),
}


@pytest.mark.parametrize("name", UNUSUAL)
def test_unusual_valid_texts_run_equally(name, write_input, binary, main, tmp_path, same_bits):
    plain_file = write_input(tower(steps=10))
    expected = sitedda.run(plain_file).history
    unusual_file = write_input(UNUSUAL[name](plain_file.read_bytes()), "odd.nml")
    for program in (binary, main):
        program.ok("run", unusual_file, "--quiet", "--output", tmp_path / "odd.nc")
        same_bits(expected, tmp_path / "odd.nc", attributes=("title", "step_control"))


@pytest.mark.parametrize("folder", ["two words", "Größe α 地震", "it's 100%"])
def test_paths_may_contain_any_letters(folder, write_input, binary, main, tmp_path, same_bits):
    values_of_record = {"values": None, "time_step": None, "file": "rec dir/сейсмо грамма.txt",
                        "unit": "m/s2"}  # fmt: skip
    file = write_input(changed(moved(format="text", **values_of_record), "control", steps=10),
                       f"{folder}/Modell ü.nml")  # fmt: skip
    (file.parent / "rec dir").mkdir()
    samples = "".join(f"{0.01 * i} {np.sin(0.3 * i)}\n" for i in range(30))
    (file.parent / "rec dir/сейсмо грамма.txt").write_text(samples)
    outputs = []
    for program in (binary, main):
        outputs.append(file.parent / f"Ausgabe β {program.name}.nc")
        program.ok("run", file, "--quiet", "--output", outputs[-1])
        assert outputs[-1].exists()
    same_bits(*outputs)
    same_bits(sitedda.run(file).history, outputs[0])


# --- Every variable ------------------------------------------------------------------------------

# All variables of all groups, with valid values.
EVERYTHING = """
&run title = 'Everything' /
&control time_step = 1e-3, steps = 2, time_step_control = 'adaptive', least_time_step = 1e-8,
   max_displacement_ratio = 0.01, dynamic_factor = 0.99, gravity = 0.0, -9.81,
   analysis = 'plane_strain', base_motion_x = 'shake', solver = 'direct' /
&contact normal_stiffness = 1e10, shear_ratio = 2.5, fixed_point_ratio = 100.0,
   penetration_tolerance = 0.0, contact_rules = 'consistent', force_tolerance = 1e-9,
   max_iterations = 400 /
&material name = 'rock', density = 2643.0, young_modulus = 4.788e9, poisson_ratio = 0.25,
   initial_stress = 0.0, 0.0, 0.0, initial_velocity = 0.0, 0.0, 0.0 /
&joint name = 'bedding', friction_angle = 50.0, cohesion = 1e8, tensile_strength = 5e7 /
&block name = 'floor', material = 'rock', joint = 'bedding', vertices = 0 0, 1 0, 1 1, 0 1 /
&layers name = 'layer', left = 9.0, bottom = 0.0, width = 1.0, thickness = 1.0, count = 2 /
&drums name = 'drum', centre = 20.0, bottom = 0.0, width = 1.0, top_width = 0.9, height = 1.0,
   count = 2 /
&wall name = 'brick', left = 30.0, bottom = 0.0, brick_length = 1.0, brick_height = 0.5,
   bricks = 2, courses = 2, head_joint = 0.001, geostatic = .true., overburden = 1.0e3 /
&motion name = 'shake', quantity = 'acceleration', unit = 'm/s2', time_step = 0.01,
   values = 0.0, 0.1, 0.0, scale = 1.0, taper = 0.1, drift_order = 1, channel = 1,
   after_end = 'hold' /
&fixed_point x = 0.5, y = 0.5, block = 'floor', direction = 'xy', motion_x = 'shake' /
&load x = 0.5, y = 1.0, block = 'floor', time = 0.0, 1.0, force_x = 0.0, 1.0,
   force_y = 0.0, 1.0 /
&measured_point name = 'base', x = 0.5, y = 0.5, block = 'floor' /
&measured_point name = 'surface', x = 0.5, y = 1.0, block = '1' /
&amplification surface = 'surface', base = 'base', direction = 'x', lowest = 1.0,
   highest = 9.0, padding = 2 /
&output file = 'everything.nc', history_seconds = 1e-3, block_interval = 0 /
"""
EVERYTHING = [(group.name, read_values(group, "everything")) for group in find_groups(EVERYTHING)]

NO_NUMBERS = ["NaN", "Inf", "-Infinity", "1e400", "-1e400", "''", "word", ".true.", "(1.0,2.0)"]
EXTREMES = ["0", "-1", "1e30", "-1e30", "1e300", "1e-300", "5e-324", "2147483648", "-0.0"]
STRANGE = [
    "",
    "1 2 3 4 5 6 7 8 9",
    "5*1.0",
    "1000000000*1",
    "'" + "x" * 1_000_000 + "'",
    "9" * 100_000,
]


def test_an_input_with_all_variables_runs(write_input):
    assert sitedda.run(write_input(EVERYTHING)).complete


@pytest.mark.parametrize(
    ("group_index", "variable"),
    [(i, variable) for i, (_, values) in enumerate(EVERYTHING) for variable in values],
    ids=[f"{name}-{variable}" for name, values in EVERYTHING for variable in values],
)
def test_invalid_values_of_each_variable(group_index, variable, write_input):
    """Each is refused with file and group, or the results are finite."""
    group, values = EVERYTHING[group_index]
    text = namelist(EVERYTHING)
    line = namelist([(group, {variable: values[variable]})]).splitlines()[1]
    number = not isinstance(values[variable], str | bool)
    for value in [*NO_NUMBERS, *EXTREMES, *STRANGE]:
        at = text.index(line, text.index(namelist([EVERYTHING[group_index]])))
        file = write_input(text[:at] + f"   {variable} = {value}" + text[at + len(line) :])
        begin = time.process_time()
        try:
            with sitedda.Simulation(file) as run:
                assert not (number and value in NO_NUMBERS), f"{variable} = {value} is accepted"
                run.advance(2)
                assert np.all(np.isfinite(run.coordinates)), value[:20]
                assert np.all(np.isfinite(list(run.energies.values()))), value[:20]
        except sitedda.InputError as error:
            assert str(file) in str(error), (value[:20], str(error))
            referenced_names = ("name", "time_step", "gravity")  # other groups refer to them
            assert f"&{group}" in str(error) or variable in referenced_names, str(error)
            assert len(str(error)) < 1000, value[:20]
        except (sitedda.ConvergenceError, sitedda.SolverError) as error:
            assert str(error).startswith("step "), (value[:20], str(error))
        assert time.process_time() - begin < 1.0, f"{variable} = {value[:20]}"


def test_a_group_of_twenty_megabytes_is_refused(write_input):
    vertices = "1.0 " * 5_000_000
    with pytest.raises(sitedda.InputError, match="&block"):
        sitedda.run(write_input(TOWER + f"&block vertices = {vertices} /\n"))


def test_thousands_of_equal_blocks_are_refused_in_a_second(write_input):
    file = write_input(blocks(*30_000 * [SQUARE]))
    begin = time.process_time()
    with pytest.raises(sitedda.InputError, match="overlaps"):
        sitedda.run(file)
    assert time.process_time() - begin < 3.0  # mostly for reading the text


@pytest.mark.parametrize(
    "name", ["$(touch harm)", "`touch harm`", "; touch harm", "|touch harm", "%s%n"]
)
def test_nothing_in_an_input_is_executed(name, write_input, binary, tmp_path):
    title = changed(tower(steps=2), "run", title=name)
    binary.ok("run", write_input(title), "--quiet", "--output", tmp_path / "o.nc", folder=tmp_path)
    groups = moved(values=None, quantity=None, time_step=None, file=name)
    process = binary("run", write_input(groups), folder=tmp_path)
    assert process.returncode == 1
    assert name in process.stderr
    assert sitedda.run(write_input(title)).history.attrs["title"] == name
    assert not list(tmp_path.rglob("harm"))


@pytest.mark.filterwarnings("error::sitedda.AuditWarning")
def test_touching_blocks_do_not_overlap(write_input):
    outlines = [rectangle(0.1 * i, 0.0, 0.1, 0.3) for i in range(20)]
    assert sitedda.run(write_input(blocks(*outlines, steps=2))).complete


def test_blocks_far_apart_do_not_overlap(write_input):
    assert sitedda.run(write_input(blocks(SQUARE, rectangle(1e4, 0, 1, 1), steps=2))).complete
