# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact points between corners: bending of dry and bonded joints, and changing overlaps."""

import numpy as np
import pytest
from scipy.optimize import brentq

from sitedda_evidence import model as nml

POINTS = (2, 3, 5)
RIGID = 1e16  # Pa; joints have 1e10 to 1e11 Pa/m
WIDTH, PRESS, STIFFNESS = 2.0, 1e6, 1e11  # m, N/m, Pa/m
# Abscissae and weights of Lobatto rules on -1 … 1, for a length of 1.
NODES = {2: [1.0], 3: [0.0, 1.0], 5: [0.0, np.sqrt(3 / 7), 1.0]}
WEIGHTS = {2: [1 / 2], 3: [2 / 3, 1 / 6], 5: [16 / 45, 49 / 180, 1 / 20]}


def moment(points: int, angle: float) -> float:
    """Return M/(N L/2) at θ/θ₀ of a dry joint with these points; θ₀ = 2N/kL²."""
    x, w = np.array(NODES[points]), np.array(WEIGHTS[points])
    x, w = np.concatenate([-x[x > 0], x]), np.concatenate([w[x > 0], w])
    forces = lambda closure: w * np.maximum(0.0, closure + angle * x)  # noqa: E731
    closure = brentq(lambda c: forces(c).sum() - 1.0, -angle, angle + 2.0, xtol=1e-14)
    return forces(closure) @ x


FLOOR = nml.rectangle(-5.0, -1.0, 10.0, 1.0)


def pressed(
    points: int, moment_load: float, stiffness: dict, displacement: float = 0.0, floor=FLOOR
) -> str:
    """A rigid block on a rigid floor under a force and a couple in units of N L/2."""
    force = PRESS * moment_load / 2  # at both corners
    text = [
        nml.control(1e-2, 60, gravity=(0.0, 0.0), dynamic_factor=0.0),
        nml.contact(STIFFNESS * WIDTH / 2, shear_ratio=1.0),
        nml.material("rigid", 2500.0, RIGID),
        nml.joint("dry", 30.0, contact_points=points, **stiffness),
        nml.fixed_block("floor", floor, "rigid", "dry"),
        nml.block("block", nml.rectangle(-WIDTH / 2, 0.0, WIDTH, 1.0), "rigid", "dry"),
        nml.measured_point("left", (-WIDTH / 2, 0.0), "block"),
        nml.measured_point("right", (WIDTH / 2, 0.0), "block"),
        nml.measured_point("below", (0.0, 0.0), "floor"),
    ]
    loads = ((0.0, displacement, -PRESS), (-WIDTH / 2, 0.0, force), (WIDTH / 2, 0.0, -force))
    for x, shear_load, normal_load in loads:
        values = {"force_x": (shear_load, shear_load), "force_y": (normal_load, normal_load)}
        text.append(nml.group("load", x=x, y=0.0, block="block", time=(0, 10), **values))
    return "".join(text)


@pytest.mark.parametrize("stiffness", [{}, {"normal_stiffness_per_area": STIFFNESS}])
@pytest.mark.parametrize("points", POINTS)
def test_points_do_not_change_axial_and_shear_stiffness(points, stiffness):
    """The displacements are N/(k L) and T/(k_s L) for each number of points."""
    data = nml.history(pressed(points, 0.0, stiffness, displacement=0.1 * PRESS))
    for axis, force in (("x", 0.1 * PRESS), ("y", -PRESS)):
        left, right, below = data.displacement.sel(axis=axis)[-1].values
        assert (left + right) / 2 - below == pytest.approx(force / (STIFFNESS * WIDTH), rel=2e-4)


SPENT = {"law": "cohesive", "tensile_strength": 1e-2, "cohesion": 1e9, "fracture_energy": 1e-9,
         "shear_fracture_energy": 1e8, "normal_stiffness_per_area": STIFFNESS}  # fmt: skip


@pytest.mark.parametrize("stiffness", [{}, {"normal_stiffness_per_area": STIFFNESS}, SPENT],
                         ids=["dry", "per area", "bond spent"])  # fmt: skip
@pytest.mark.parametrize(
    ("points", "angle"), [(2, 0.5), *((n, t) for n in (3, 5) for t in (0.5, 1.0, 2.0, 4.0))]
)
def test_a_dry_joint_opens_by_the_moment_of_its_points(points, angle, stiffness):
    """The computed moment turns a block by θ; 2 points are 3 times as stiff as a continuum."""
    moment_load = moment(points, angle)
    data = nml.history(pressed(points, moment_load, stiffness))
    left, right, _ = data.displacement.sel(axis="y")[-1].values
    unit = 2 * PRESS / (STIFFNESS * WIDTH**2)
    assert (left - right) / WIDTH / unit == pytest.approx(angle, rel=2e-3)


SIDE, DENSITY, GRAVITY = 1.0, 2000.0, 9.81
STEPS = 1000
FLEXURE = 6 * (DENSITY * SIDE**2 * GRAVITY * SIDE / 2) / SIDE**2  # Pa, 58.86 kPa


def glued(tensile_strength: float, points: int, timing: str, **options) -> str:
    """A block of 1 m whose side is glued to a wall."""
    return nml.text(
        timing,
        nml.contact(1e9),
        nml.material("stone", DENSITY, 1e12),
        nml.joint("mortar", 30.0, cohesion=1e6, tensile_strength=tensile_strength,
                  contact_points=points,
                  **({"normal_stiffness_per_area": 1e10} | options)),
        nml.fixed_block("wall", nml.rectangle(-1.0, -2.0, 1.0, 5.0), "stone", "mortar"),
        nml.block("block", nml.rectangle(0.0, 0.0, SIDE, SIDE), "stone", "mortar"),
    )  # fmt: skip


@pytest.mark.parametrize("options", [{}, {"law": "mohr_coulomb", "weakening_slip": 1e-3}])
@pytest.mark.parametrize(("points", "fraction"), [(2, 1 / 3), (3, 1.0), (5, 1.0)])
def test_flexural_strength(points, fraction, options):
    """A bonded joint cracks at M = T L²/6; with two corners at three times that moment."""
    timing = nml.control(1e-2, 5, (0.0, -GRAVITY), dynamic_factor=0.0)
    for load_factor, intact in ((1.01, True), (0.99, False)):
        with nml.simulation(
            glued(load_factor * fraction * FLEXURE, points, timing, **options)
        ) as run:
            run.advance(5)
            assert run.contacts["bonded"].all() == intact


def brittle(strength: float) -> dict:
    """Return a cohesive joint with a fracture energy of 1.1 times its largest elastic energy."""
    return {"tensile_strength": strength, "fracture_energy": 0.55 * strength**2 / 1e10}


@pytest.mark.parametrize("law", [{}, {"law": "cohesive", "shear_fracture_energy": 200.0}],
                         ids=["bond", "cohesive"])  # fmt: skip
@pytest.mark.parametrize(("strength", "is_stable"), [(62e3, True), (56e3, False)])
def test_a_glued_block(strength, is_stable, law):
    """After an end has cracked, the oscillation breaks the rest; two corners would not crack."""
    timing = nml.control(1e-4, STEPS, (0.0, -GRAVITY), settle=True, integration="midpoint")
    changed = {"tensile_strength": strength}
    if law:
        law, changed = law | brittle(62e3), brittle(strength)
        law.pop("tensile_strength")
    with nml.simulation(glued(62e3, 3, timing, **law)) as run:
        run.change({"joint.mortar": changed})
        run.advance(STEPS)
        assert (run.contacts["bonded"].sum() == 3) == is_stable
        assert (run.coordinates[1, 1] > 0.4999) == is_stable
        assert abs(run.energies["balance"]) < 1e-6 * run.energies["initial"]


def ultimate(points: int) -> float:
    """Return the largest moment of brittle points that break from one end, over T L²/6."""
    x, w = np.array(NODES[points]), np.array(WEIGHTS[points])
    x, w = np.concatenate([-x[x > 0], x]) / 2, np.concatenate([w[x > 0], w])
    largest, order = 0.0, np.argsort(x)
    for left in range(len(x), 1, -1):
        x, w = x[order[:left]], w[order[:left]]
        middle = w @ x / w.sum()
        largest = max(largest, 6 * w @ (x - middle) ** 2 / (x[-1] - middle))
        order = np.arange(left)
    return largest


@pytest.mark.parametrize("law", [{}, {"law": "cohesive", "shear_fracture_energy": 200.0}],
                         ids=["bond", "cohesive"])  # fmt: skip
@pytest.mark.parametrize(("points", "fraction"), [(3, 2.0), (5, 1.1906)])
def test_a_glued_block_at_rest(points, fraction, law):
    """Without oscillation, the rest of a brittle joint resists 2 TL²/6 on 3 points, 1.19 on 5."""
    assert ultimate(points) == pytest.approx(fraction, rel=1e-4)
    timing = nml.control(1e-2, 120, (0.0, -GRAVITY), dynamic_factor=0.0)
    for load_factor, is_stable in ((1.02, True), (0.98, False)):
        strength = load_factor * FLEXURE / fraction
        options = dict(law)
        if law:
            options["fracture_energy"] = 0.505 * strength**2 / 1e10
        with nml.simulation(glued(strength, points, timing, **options)) as run:
            run.advance(120)
            assert (run.coordinates[1, 1] > 0.499) == is_stable


def test_a_vertex_within_a_straight_edge_changes_nothing():
    """An overlap that ends at such a vertex has a point there: the joint turns equally."""
    floor = [(-5, -1), (5, -1), (5, 0), (0.3, 0), (-5, 0)]  # a vertex in the edge
    area = {"normal_stiffness_per_area": STIFFNESS}
    one_edge, two_edges = (nml.history(pressed(5, 0.25, area, floor=shape))
                           for shape in (FLOOR, floor))  # fmt: skip
    displacement, expected = (data.displacement.sel(axis="y")[-1] for data in (two_edges, one_edge))
    np.testing.assert_allclose(displacement, expected, atol=1e-3 * float(abs(expected).max()))
    assert len(one_edge.contact_vertex) // one_edge.sizes["frame"] == 5
    assert len(two_edges.contact_vertex) // two_edges.sizes["frame"] == 10


def across(points: int, block_count: int, load: float, **stiffness) -> str:
    """A block that is pushed across the joints of a base, or off the base."""
    edges = np.linspace(-2.0, 7.0, block_count + 1)
    return nml.text(
        nml.control(2e-3, 500, gravity=(0.0, -10.0), settle=True),
        nml.contact(1e10),
        nml.material("rock", 2500.0, 1e12),
        nml.joint("j", 5.0, contact_points=points, **stiffness),
        *(
            nml.fixed_block(f"base{i}", nml.rectangle(a, -1.0, b - a, 1.0), "rock", "j")
            for i, (a, b) in enumerate(zip(edges[:-1], edges[1:], strict=True))
        ),
        nml.block("top", nml.rectangle(0.0, 0.0, WIDTH, 1.0), "rock", "j"),
        nml.group(
            "load", x=1.0, y=0.5, block="top", time=(0, 0.01, 0.3, 0.31), force_x=(0, load, load, 0)
        ),
        nml.measured_point("top", (1.0, 0.5), "top"),
        nml.group("output", block_interval=50),
    )


@pytest.mark.parametrize("stiffness", [{}, {"normal_stiffness_per_area": 5e8}])
@pytest.mark.parametrize(("cuts", "load"), [(2, 6e4), (9, 6e4), (2, 15e4)])
@pytest.mark.parametrize("points", POINTS)
def test_energy_balance_with_changing_overlaps(points, cuts, load, stiffness):
    """Overlaps end, begin and move from base to base."""
    data = nml.history(across(points, cuts, load, **stiffness))
    assert float(data.displacement.sel(point="top", axis="x")[-1]) > (5.0 if load > 1e5 else 1.0)
    assert nml.energy_residual(data) < 1e-6
    if stiffness and load < 1e5:
        assert np.abs(data.energy_length).max() > 0
        for frame in np.unique(data.contact_frame):
            of_frame = (data.contact_frame == frame) & (data.contact_normal_force > 1.0)
            total = data.contact_length.values[of_frame.values].sum()
            assert total == pytest.approx(WIDTH, rel=0.04)


def test_points_do_not_change_a_smooth_slide():
    """Friction dissipates the same work for each number of points."""
    work = [
        float(
            nml.history(across(points, 2, 6e4, normal_stiffness_per_area=5e8)).energy_friction[-1]
        )
        for points in POINTS
    ]
    np.testing.assert_allclose(work, work[0], rtol=1e-3)
