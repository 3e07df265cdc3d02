# SPDX-License-Identifier: GPL-3.0-or-later
"""Strength reduction against closed forms, and messages without a factor of safety."""

import json
import math
import re

import numpy as np
import pytest
from lattices import lattice
from matplotlib.text import Text

import sitedda
from sitedda import InputError
from sitedda.boundary_marks import SIGNS
from sitedda.command import main
from sitedda.engine import engine_names, reduced_group
from sitedda.model import Model
from sitedda.schema import GROUPS
from sitedda.stability import bisect
from sitedda.stability.strength import static_model


def block_on_plane(slope, friction, cohesion=0.0, height=1.0, **stages) -> Model:
    """A block 4 m long, of 25 kN/m³, on a plane, in axes of the plane."""
    dip = math.radians(slope)
    model = Model("Block on a plane", time_step=1e-2)
    model.control(gravity=(10.0 * math.sin(dip), -10.0 * math.cos(dip)))
    model.contact(normal_stiffness=1e10, shear_ratio=1.0)
    model.material("rock", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("plane", friction_angle=friction, cohesion=cohesion)
    model.block([(-20, -1), (30, -1), (30, 0), (-20, 0)], name="base")
    model.block([(0, 0), (4, 0), (4, height), (0, height)], name="block")
    model.fixed_point(-20.0, -1.0, "base")
    model.fixed_point(30.0, -1.0, "base")
    return model


@pytest.mark.parametrize(
    ("slope", "friction", "cohesion", "height"),
    [(20.0, 35.0, 0.0, 1.0), (35.0, 20.0, 0.0, 1.0), (40.0, 30.0, 0.5e3, 0.02)],
)
def test_factor_of_a_block_on_a_plane(slope, friction, cohesion, height):
    """F = (c A + W cos α tan φ)/(W sin α), also below 1; an intact joint has its cohesion.

    The block with cohesion is thin, so that its two bonds, which break singly, carry equal forces.
    """
    weight = 4.0 * height * 25e3
    dip = math.radians(slope)
    resistance = cohesion * 4.0 + weight * math.cos(dip) * math.tan(math.radians(friction))
    expected = resistance / (weight * math.sin(dip))
    trials: list = []
    result = sitedda.safety(block_on_plane(slope, friction, cohesion, height), tolerance=1e-3,
                           progress=trials.append)  # fmt: skip
    assert tuple(trials) == result.trials and str(trials[-1]) in str(result)
    assert result.low <= result.factor <= result.high
    assert result.factor == pytest.approx(expected, rel=2e-3)
    assert result.high - result.low <= 1e-3 * result.high
    assert result.mechanism.verdicts == ("stable", "slides")
    assert result.mechanism.displacement[1, 0] > 0.0
    assert not result.warning
    assert all("displacement of &stage" in trial.words for trial in trials if not trial.stands)
    assert f"{result.factor:.4g}" in str(result)


def test_small_mechanisms_are_removed_until_a_larger_one(tmp_path, capsys, monkeypatch):
    """Two blocks on a plane, the smaller one on the weaker joint: each has F = tan φ/tan α."""
    model = block_on_plane(20.0, 35.0)
    model.joint("clay", friction_angle=25.0)
    model.block([(10, 0), (11, 0), (11, 0.5), (10, 0.5)], joint="clay")
    small, large = (math.tan(math.radians(f)) / math.tan(math.radians(20.0)) for f in (25.0, 35.0))
    first = sitedda.safety(model)
    assert first.factor == pytest.approx(small, rel=2e-3) and not first.smaller
    assert first.mechanism.moving == ["block 3"] and first.mechanism.joint == "clay"
    assert "block 3 moves: 0.5 m², 0.917 % of the model, on joint 'clay'" in first.words
    assert "set least_area" in first.words
    result = sitedda.safety(model, least_area=1.0)
    assert result.factor == pytest.approx(large, rel=2e-3)
    assert (result.mechanism.moving, result.mechanism.joint) == (["block"], "plane")
    assert [trial_result.mechanism.moving for trial_result in result.smaller] == [["block 3"]]
    monkeypatch.chdir(tmp_path)
    model.write("two.nml")
    assert main(["safety", "two.nml", "--least-area", "1", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert (printed["joint"], printed["area"]) == ("plane", 4.0)
    assert printed["smaller"][0]["joint"] == "clay"
    nothing_larger = sitedda.safety(model, least_area=100.0)
    assert nothing_larger.mechanism is None and len(nothing_larger.smaller) == 2


def test_a_block_that_falls_at_any_strength_is_removed():
    """A block beyond the edge of the base falls; the other block determines the factor."""
    model = block_on_plane(20.0, 35.0)
    model.block([(29.9, 0), (31, 0), (31, 0.1), (29.9, 0.1)], name="overhang")
    assert sitedda.safety(model).low == 0.0
    result = sitedda.safety(model, least_area=1.0)
    assert result.factor == pytest.approx(math.tan(math.radians(35)) / math.tan(math.radians(20)),
                                         rel=2e-3)  # fmt: skip
    assert result.smaller[0].mechanism.moving == ["overhang"]


@pytest.mark.parametrize("size", [None, 1.0, 0.5])
def test_failure_is_a_fraction_of_the_radius_of_the_whole_body(size):
    """√(2² + ½²) m for a block of 4 m by 1 m, for any size of its cells."""
    model = block_on_plane(20.0, 35.0)
    if size:
        model.mesh(blocks="block", size=size)
    trials = sitedda.safety(model, displacement=0.03, tolerance=0.1).trials
    allowed = {parts[1] for trial in trials if (parts := trial.words.split(" m, allowed "))[1:]}
    assert allowed == {f"{0.03 * math.hypot(2.0, 0.5):.3g}"}


def test_factor_of_rough_joints():
    """F W sin α = Σ N tan[φ_r + JRC log₁₀(JCS L/N)] over two contacts with unequal forces."""
    model, dip = block_on_plane(30.0, 25.0), math.radians(30.0)
    model["joint.plane"](law="barton_bandis", jrc=9.0, jcs=50e6, max_closure=1e-3,
                         cohesion=None, normal_stiffness_per_area=1e10)  # fmt: skip
    weight, length, height = 4.0 * 25e3, 4.0, 1.0
    normal = 0.5 * weight * (math.cos(dip) + math.sin(dip) * height / length * np.array([1, -1]))
    angle = 25.0 + 9.0 * np.log10(50e6 * 0.5 * length / normal)
    expected = float(np.sum(normal * np.tan(np.radians(angle)))) / (weight * math.sin(dip))
    result = sitedda.safety(model, tolerance=1e-3)
    assert result.factor == pytest.approx(expected, rel=2e-3)
    assert result.mechanism.verdicts == ("stable", "slides")
    area, total_area = result.mechanism.areas
    assert area == pytest.approx(length * height) and total_area > area
    assert f"block moves: 4 m², {100 * area / total_area:.3g} % of the model" in result.words


def test_a_toppling_block_has_no_factor_of_safety():
    result = sitedda.safety(block_on_plane(40.0, 50.0, height=8.0))
    assert result.low == 0.0
    assert "fails even with all strengths" in result.words
    assert result.mechanism.verdicts == ("stable", "topples")


@pytest.mark.parametrize("analysis", [sitedda.safety, sitedda.stability.mechanism])
def test_a_model_without_loads_or_supports_is_refused(analysis):
    model = block_on_plane(20.0, 35.0)
    model.clear("fixed_point")
    with pytest.raises(InputError, match="the blocks have no support"):
        analysis(model)
    model = block_on_plane(20.0, 35.0)
    model.control(gravity=(0.0, 0.0))
    with pytest.raises(InputError, match="requires weight or loads: set gravity"):
        analysis(model)


def test_a_load_replaces_weight():
    """Loads W sin α along and W cos α onto the plane, without gravity: F = tan φ/tan α."""
    model, dip = block_on_plane(20.0, 35.0), math.radians(20.0)
    model.control(gravity=(0.0, 0.0))
    push, press = 1e5 * math.sin(dip), -1e5 * math.cos(dip)
    model.load(2.0, 0.1, "block", time=(0, 1), force_x=(push, push), force_y=(press, press))
    found = sitedda.safety(model)
    assert found.factor == pytest.approx(math.tan(math.radians(35.0)) / math.tan(dip), rel=2e-3)


def test_a_block_on_level_ground_has_no_mechanism():
    result = sitedda.safety(block_on_plane(0.0, 30.0))
    assert math.isinf(result.high) and result.mechanism is None
    assert "stands even with all strengths" in str(result)
    assert result.to_dict()["fails_at"] is None
    with pytest.raises(ValueError, match="no mechanism"):
        result.draw()


def test_mechanism_at_one_factor_and_its_picture():
    stable_mechanism = sitedda.mechanism(block_on_plane(20.0, 30.0), 1.5)
    assert stable_mechanism.verdicts == ("stable", "stable") and not stable_mechanism.moves
    slides = sitedda.mechanism(block_on_plane(20.0, 30.0), 1.65)
    assert slides.verdicts == ("stable", "slides") and slides.moves
    axes = slides.draw()
    assert len(axes.collections[0].get_paths()) == 2
    with pytest.raises(sitedda.InputError, match="factor = -1"):
        sitedda.mechanism(block_on_plane(20.0, 30.0), -1)


def test_dynamic_stages_become_static():
    """A prop that a dynamic stage removes has no effect; loads have their values at time 0."""
    model = block_on_plane(35.0, 20.0)
    model.block([(4, 0), (6, 0), (6, 1), (4, 1)], name="prop")
    model.fixed_point(6.0, 0.0, "prop")
    model.load(2.0, 1.0, "block", time=(0.0, 1.0), force_x=(10.0, 20.0))
    model.traction(side="right", level=[0.0, 1.0], time=(-1.0, 1.0))
    model.water(surface=(-20, -3, 30, -3), rise=[0.0, -0.5], time=(-1.0, 1.0))
    model.stage(name="rest", kind="static")
    model.stage(name="free", remove="prop", steps=5)
    model.stage(name="idle", steps=5)
    static = static_model(model)
    assert [(s.name, s.kind) for s in static["stage"]] == [("rest", "static"), ("free", "static")]
    assert static["load"][0].force_x.tolist() == [10.0, 10.0]
    assert static["traction"][0].level.tolist() == [0.5, 0.5]
    assert static["water"][0].rise.tolist() == [-0.25, -0.25]
    expected = math.tan(math.radians(20.0)) / math.tan(math.radians(35.0))
    assert sitedda.safety(model, tolerance=5e-3).factor == pytest.approx(expected, rel=5e-3)


def test_bolts_and_water_are_in_the_picture():
    model = block_on_plane(35.0, 20.0)
    model.bolt("tie", (1.0, -0.5), (1.0, 0.5), axial_stiffness=1e7, yield_force=1e3)
    model.water(surface=(-20, -0.5, 30, -0.5))
    axes = sitedda.mechanism(model).draw()
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert {"bolt", "water"} <= set(labels)
    none = sitedda.mechanism(block_on_plane(35.0, 20.0)).draw().get_legend().get_texts()
    assert not {"bolt", "water"} & {text.get_text() for text in none}


def test_bisection_works_in_both_directions():
    assert bisect(lambda x: x < 2.0, 0.0, 5.3, 1e-6) == pytest.approx((2.0, 2.0), rel=2e-6)
    low, high = bisect(lambda x: x > 2.0, 5.3, 1.1, 1e-3)
    assert low > 2.0 > high


def test_the_command_prints_the_factor_of_safety(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = block_on_plane(20.0, 30.0).write(tmp_path / "block.nml")
    assert main(["safety", str(file), "--tolerance", "0.01", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["stands_at"] < 1.5863 < printed["fails_at"] * 1.001
    assert printed["blocks"] == {"base": "stable", "block": "slides"}
    assert (tmp_path / "block_mechanism.png").stat().st_size > 5000
    assert main(["safety", str(file), "--factor", "1", "--set", "joint.friction_angle=10"]) == 0
    assert "the model moves" in capsys.readouterr().out
    assert main(["safety", "missing.nml"]) == 1
    assert np.isfinite(printed["factor"])


def test_free_field_sides_are_rollers_at_rest():
    """Level ground between rollers settles as between free fields."""
    sag = []
    ground = lattice("free_field", columns=3, gravity=(0.0, -9.81), settle=True)
    for model in (ground, static_model(ground)):
        with sitedda.Simulation(model) as run:
            sag.append(run.coordinates[:, 1].copy())
    still = np.ravel([[j + 0.5] * 3 for j in range(3)])
    assert (still - sag[0]).min() > 0
    np.testing.assert_allclose(sag[1] - still, sag[0] - still, rtol=1e-3)


# --- Laws of joints and kinds of boundaries--------------------------------------------------------

OF_LAWS = {
    "coulomb": "friction_angle = 30, cohesion = 4e4, tensile_strength = 2e4",
    "crushing": "friction_angle = 30, cohesion = 4e4, tensile_strength = 2e4, "
    "crushing_strength = 1e6, crushing_energy = 500",
    "mohr_coulomb": "friction_angle = 30, cohesion = 4e4, tensile_strength = 2e4, "
    "residual_friction_angle = 20, residual_cohesion = 1e3, residual_tensile_strength = 500, "
    "weakening_slip = 1e-3, dilation_angle = 10, dilation_slip = 0.1",
    "barton_bandis": "friction_angle = 30, jrc = 10, jcs = 1e8, compressive_strength = 1.5e8, "
    "strength_reduction = 1.5",
    "plesha": "friction_angle = 30, asperity_angle = 15, asperity_wear = 1e-5",
    "cohesive": "friction_angle = 30, cohesion = 4e4, tensile_strength = 2e4, "
    "fracture_energy = 50, shear_fracture_energy = 80, normal_stiffness_per_area = 1e10",
    "continuously_yielding": "friction_angle = 30, initial_friction_angle = 45, roughness = 1e-3",
    "rate_state": "friction_angle = 30, direct_effect = 0.01, evolution_effect = 0.015, "
    "threshold_velocity = 1e-6, state_distance = 1e-4",
}


def choices(group: str, name: str) -> list[str]:
    """The permitted words of a variable in the schema."""
    row = next(v for v in GROUPS[group].variables if v.name == name)
    return re.findall("'([^']+)'", row.values)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.5])
def test_each_law_defines_the_strengths_that_a_factor_divides(factor):
    assert choices("joint", "law") == list(OF_LAWS)
    divided = {law: reduced_group(f"&joint name = 'j', law = '{law}', {values} /", factor)
               for law, values in OF_LAWS.items()}  # fmt: skip
    for law, values in OF_LAWS.items():
        variables = {
            k: float(v) for k, v in (assignment.split(" = ") for assignment in values.split(", "))
        }
        if law == "barton_bandis":
            assert divided[law] == {"strength_reduction": 1.5 * factor}
            continue
        of_slip = {"weakening_slip", "dilation_slip", "asperity_wear", "normal_stiffness_per_area",
                   "roughness", "threshold_velocity", "state_distance"}  # fmt: skip
        assert divided[law].keys() == variables.keys() - of_slip
        for name, value in divided[law].items():
            if name.endswith("angle"):
                expected = np.degrees(np.arctan(np.tan(np.radians(variables[name])) / factor))
            else:
                expected = variables[name] / factor
            assert value == pytest.approx(expected, rel=1e-14), name


def test_a_friction_angle_stays_below_a_right_angle():
    group = reduced_group("&joint name = 'j' friction_angle = 80 /", 1e-3)
    assert group == {"friction_angle": 89.0, "cohesion": 0.0, "tensile_strength": 0.0}


def test_an_invalid_joint_is_refused_with_its_variable():
    with pytest.raises(sitedda.InputError, match="friction_angle = 95"):
        reduced_group("&joint name = 'j' friction_angle = 95 /", 2.0)


def test_every_kind_of_boundary_has_a_kind_at_rest():
    kinds = choices("boundary", "kind")
    assert list(engine_names("boundary kinds")) == kinds
    at_rest = engine_names("boundary kinds at rest")
    assert set(at_rest) <= set(kinds) and len(at_rest) == len(kinds)


def test_a_boundary_without_a_symbol_is_drawn_with_its_kind(monkeypatch, tmp_path):
    model = sitedda.Model(time_step=1e-3, steps=1)
    model.material("rock", density=2500.0, young_modulus=1e9, poisson_ratio=0.2)
    model.joint("dry", friction_angle=30.0)
    model.block([0, 0, 2, 0, 2, 1, 0, 1], name="floor")
    model.boundary("base", "roller", side="bottom")
    monkeypatch.delitem(SIGNS, "roller")
    axes = sitedda.draw(model.write(tmp_path / "m.nml"))
    assert "roller" in [text.get_text() for text in axes.figure.findobj(Text)]


def test_rate_without_age_has_a_factor_of_safety():
    """A rate_state joint without evolution_effect needs no state_distance in a trial either."""
    divided = reduced_group(
        "&joint name = 'j', law = 'rate_state', friction_angle = 35, direct_effect = 0.01, "
        "threshold_velocity = 1e-6 /", 2.0)  # fmt: skip
    assert divided.keys() == {"friction_angle", "direct_effect"}
