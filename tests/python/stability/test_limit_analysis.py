# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis against closed forms, and errors for unsupported models."""

import math

import numpy as np
import pytest
import shapely

import sitedda
from sitedda.errors import InputError
from sitedda.masonry import Arch
from sitedda.stability import Backfill, Limit

LEFT, RIGHT = (-1.0, 0.0), (1.0, 0.0)


def assembly(blocks: dict, friction: float, gravity=(0.0, -9.81), held=("base",)) -> sitedda.Model:
    """Blocks by their corners, with tan φ in all joints; `held` blocks have two fixed points."""
    model = sitedda.Model("Blocks at their limit", time_step=1e-2, gravity=gravity)
    model.contact(normal_stiffness=1e10)
    model.material("stone", density=2500.0, young_modulus=1e12, poisson_ratio=0.2)
    model.joint("dry", friction_angle=math.degrees(math.atan(friction)))
    for name, corners in blocks.items():
        model.block(np.array(corners, dtype=float), name=name)
    for name in held:
        for x, y in blocks[name][:2]:
            model.fixed_point(x, y, name)
    return model


def box(left: float, bottom: float, width: float, height: float) -> list:
    right, top = left + width, bottom + height
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


BASE = box(-5, -1, 20, 1)


def check_forces(limit: Limit, friction: float, model: sitedda.Model, direction):
    """Check that forces balance each block except the base, within friction."""
    normal, shear = limit.normal_force, limit.shear_force
    assert (normal >= 0).all()
    assert (abs(shear) <= friction * normal + 1e-8 * normal.max()).all()
    tangents = np.column_stack([-limit.normals[:, 1], limit.normals[:, 0]])
    force = normal[:, None] * limit.normals + shear[:, None] * tangents
    gravity = np.array(model.control.gravity)
    for i, polygon in enumerate(limit.polygons[1:], 1):
        mass, centre = mass_and_centre(polygon)
        push = limit.factor * np.linalg.norm(gravity) * np.array(direction)
        weight_and_load = mass * (gravity + push)
        total, moment = weight_and_load.copy(), 0.0
        for side, sign in ((1, 1.0), (0, -1.0)):
            is_of_block = limit.blocks[:, side] == i
            arm = limit.points[is_of_block] - centre
            total += sign * force[is_of_block].sum(axis=0)
            x_force, y_force = force[is_of_block].T
            moment += sign * (arm[:, 0] * y_force - arm[:, 1] * x_force).sum()
        assert abs(total).max() < 1e-6 * np.linalg.norm(weight_and_load)
        assert abs(moment) < 1e-6 * np.linalg.norm(weight_and_load) * np.ptp(polygon, axis=0).max()


def mass_and_centre(polygon):
    """Mass and centroid of a polygon."""
    shape = shapely.Polygon(polygon)
    return 2500.0 * shape.area, np.array(shape.centroid.coords[0])


@pytest.mark.parametrize("direction", [LEFT, RIGHT])
@pytest.mark.parametrize(
    ("width", "height", "friction"), [(2, 1, 0.5), (2, 1, 1.9), (1, 3, 0.6), (1, 3, 0.3)]
)
def test_a_block_slides_at_tan_phi_or_topples_at_its_slenderness(
    width, height, friction, direction
):
    model = assembly({"base": BASE, "block": box(1, 0, width, height)}, friction)
    limits = sitedda.limit_analysis(model, direction=direction)
    slides = friction < width / height
    for limit in (limits.upper, limits.lower):
        assert limit.factor == pytest.approx(min(friction, width / height), rel=1e-6)
        assert limit.slides is slides
        assert limit.verdicts == ("stable", "slides" if slides else "topples")
        check_forces(limit, friction, model, direction)
    displacement = limits.lower.displacement[1]
    assert displacement[0] * direction[0] > 0
    if slides:
        assert abs(displacement[1:]).max() < 1e-6  # it does not dilate
    else:
        assert displacement[1] > 0 and displacement[2] * direction[0] < 0


def test_a_block_on_a_slope_bears_the_remaining_friction():
    """Along the dip (1, 0) with gravity at an angle α: k = μ cos α − sin α; up the dip: the sum."""
    dip, friction = math.radians(15.0), 0.6
    gravity = (9.81 * math.sin(dip), -9.81 * math.cos(dip))
    model = assembly({"base": BASE, "block": box(1, 0, 4, 0.5)}, friction, gravity)
    down = friction * math.cos(dip) - math.sin(dip)
    up = friction * math.cos(dip) + math.sin(dip)
    for direction, expected in ((RIGHT, down), (LEFT, up)):
        limits = sitedda.limit_analysis(model, direction=direction)
        assert limits.upper.factor == pytest.approx(expected, rel=1e-6)
        assert limits.lower.factor == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("floor", "between", "which"), [(0.5, 0.3, 2), (0.25, 0.4, 1)])
def test_two_blocks_slide_where_friction_is_least(floor, between, which):
    blocks = {"base": BASE, "lower": box(0, 0, 4, 0.5), "upper": box(1, 0.5, 3, 0.25)}
    model = assembly(blocks, between)
    model.joint("floor", friction_angle=math.degrees(math.atan(floor)))
    for name in ("base", "lower"):
        block = model[f"block.{name}"]
        block.joint = "floor"
    model["block.upper"].joint = "dry"
    limits = sitedda.limit_analysis(model)
    assert limits.upper.factor == pytest.approx(min(floor, between), rel=1e-6)
    assert limits.upper.verdicts[which] == "slides"
    assert limits.upper.verdicts[1] == ("slides" if which == 1 else "stable")


@pytest.mark.parametrize("direction", [LEFT, RIGHT])
def test_a_stack_topples_about_the_joint_below_its_most_slender_part(direction):
    """The part of a stack above a joint topples at the lever arm of its centre."""
    sizes = [(3.0, 1.0), (2.0, 1.5), (0.9, 1.0), (0.8, 1.2)]  # width, height, from below
    blocks, bottom = {"base": BASE}, 0.0
    for i, (width, height) in enumerate(sizes):
        blocks[f"{i}"] = box(-0.5 * width, bottom, width, height)
        bottom += height
    limits = sitedda.limit_analysis(assembly(blocks, 2.0), direction=direction)
    weights = np.array([width * height for width, height in sizes])
    tops = np.cumsum([height for _, height in sizes])
    levels = tops - 0.5 * np.array([height for _, height in sizes])
    factors = [
        0.5 * sizes[i][0] * weights[i:].sum() / (weights[i:] @ (levels[i:] - tops[i] + sizes[i][1]))
        for i in range(len(sizes))]  # fmt: skip
    assert limits.upper.factor == pytest.approx(min(factors), rel=1e-6)
    assert limits.lower.factor == pytest.approx(min(factors), rel=1e-3)
    assert not limits.upper.slides


def test_a_ladder_is_supported_by_single_corners():
    """A bar with its foot on the floor and its head at a wall: forces at two corners, closed form.

    Both corners slip at the limit.  With the weight W and a horizontal force k W on the bar:
    N₁ + μN₂ = W, μN₁ + kW = N₂; moments about the foot yield k.
    """
    friction, angle, length, thick = 0.5, math.radians(50.0), 4.0, 0.2
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    foot = np.array([0.0, 0.0])
    bar = [foot, foot + length * along, foot + length * along + thick * across,
           foot + thick * across]  # fmt: skip
    wall = bar[1][0]
    blocks = {"base": BASE, "wall": box(wall, 0.5, 2, 5), "bar": bar}
    model = assembly(blocks, friction, held=("base", "wall"))
    limits = sitedda.limit_analysis(model, direction=LEFT)
    centre = 0.5 * (length * along + thick * across)
    head = length * along
    # Unknown N₁, N₂, k (weight 1), equilibrium of x, y and moments about the foot.
    matrix = np.array([
        [friction, -1.0, -1.0],
        [1.0, friction, 0.0],
        [0.0, head[1] + friction * head[0], centre[1]],
    ])  # fmt: skip
    n1, n2, k = np.linalg.solve(matrix, [0.0, 1.0, centre[0]])
    assert k > 0 and n1 > 0 and n2 > 0
    assert limits.upper.factor == pytest.approx(k, rel=1e-6)
    assert limits.lower.factor == pytest.approx(k, rel=1e-3)
    assert limits.upper.slides


def arch(friction: float, ratio=0.165, count=15, half=76.4) -> sitedda.Model:
    """Voussoirs of a circular arch of radius 5 m on two fixed abutments."""
    half = math.radians(half)
    span, rise = 10.0 * math.sin(half), 5.0 * (1 - math.cos(half))
    geometry = Arch(span=span, rise=rise, thickness=5.0 * ratio, voussoirs=count, abutment=2.0)
    blocks = {stone.name: stone.polygon for stone in geometry.blocks()}
    fixed = [name for name in blocks if name.endswith(("left", "right"))]
    return assembly(blocks, friction, held=fixed)


def test_an_arch_has_its_published_limit():
    """15 voussoirs, half angle 76.4°, t/R 0.165, μ 0.61: computed independently."""
    limits = sitedda.limit_analysis(arch(0.61))
    assert limits.upper.factor == pytest.approx(0.45488, abs=2e-5)
    other = sitedda.limit_analysis(arch(0.61), direction=LEFT)
    assert other.upper.factor == pytest.approx(limits.upper.factor, rel=1e-6)


def test_an_output_and_its_input_have_the_same_limits(tmp_path):
    model = assembly({"base": BASE, "block": box(1, 0, 1, 3)}, 0.6)
    model.control(steps=2)
    output = tmp_path / "block.nc"
    model.run(output)
    for source in (output, sitedda.open_output(output), model):
        assert sitedda.limit_analysis(source).upper.factor == pytest.approx(1 / 3, rel=1e-6)


def test_a_confined_block_is_stable_only_with_dilation():
    """A block between floor and ceiling cannot dilate; without dilation it slides."""
    blocks = {"base": BASE, "ceiling": box(-5, 1, 20, 1), "block": box(0, 0, 3, 1)}
    limits = sitedda.limit_analysis(assembly(blocks, 0.4, held=("base", "ceiling")))
    assert limits.upper.factor == math.inf and set(limits.upper.verdicts) == {"stable"}
    assert limits.lower.factor == pytest.approx(0.4, rel=1e-2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: m["joint.dry"](law="plesha", asperity_angle=5.0), "law 'plesha'"),
        (lambda m: m["joint.dry"](law="mohr_coulomb", cohesion=1e3), "residual_cohesion = 1000"),
        (
            lambda m: m.bolt("a", (0.5, -0.5), (1.5, 2), axial_stiffness=1e8, grouted=True),
            "grouted",
        ),
        (lambda m: m.load(1.5, 0.5, time=(0, 1), force_y=(1e6, 1e6)), "no factor of the load"),
        (lambda m: m.control(gravity=(0.0, 0.0)), "requires weight"),
        (lambda m: m.control(gravity=(9.0, -9.0)), "no factor of the load"),
        (lambda m: m.clear("fixed_point"), "no support"),
        (lambda m: m.mesh(blocks="block", size=0.5), "bodies that bend"),
    ],
)
def test_unsupported_models_are_errors(change, message):
    model = assembly({"base": BASE, "block": box(1, 0, 1, 3)}, 0.6)
    change(model)
    with pytest.raises(InputError, match=message):
        sitedda.limit_analysis(model)


@pytest.mark.parametrize("direction", [(0, 0), (1,), (math.nan, 0), "x"])
def test_a_direction_has_two_numbers(direction):
    with pytest.raises(InputError, match="direction"):
        sitedda.limit_analysis(assembly({"base": BASE}, 0.6), direction=direction)


@pytest.mark.parametrize(("sides", "factor"), [(("left",), 0.5), ((), 0.0)])
def test_boundaries_support_in_their_direction(sides, factor):
    model = assembly({"base": BASE, "block": box(1, 0, 2, 1)}, 0.5, held=())
    model.boundary(kind="springs", side="bottom", direction="y", stiffness_per_area=1e9)
    for side in sides:
        model.boundary(kind="fixed", side=side, direction="x")
    limits = sitedda.limit_analysis(model, direction=RIGHT)
    assert limits.upper.factor == pytest.approx(factor, abs=1e-6)


def test_loads_of_an_output_are_refused(tmp_path):
    model = assembly({"base": BASE, "block": box(1, 0, 1, 3)}, 0.6)
    model.load(1.5, 0.5, time=(0, 1), force_y=(-1e3, -1e3))
    model.control(steps=2)
    model.run(tmp_path / "loaded.nc")
    with pytest.raises(InputError, match="loads of &load: give the input"):
        sitedda.limit_analysis(tmp_path / "loaded.nc")


WEIGHT = 2500.0 * 9.81 * 2.0  # weight of a block of 2 m by 1 m, N/m


def squat(friction=0.5, **joint) -> sitedda.Model:
    """A block of 2 m by 1 m on a base."""
    model = assembly({"base": BASE, "block": box(1, 0, 2, 1)}, friction)
    model["joint.dry"](**joint)
    return model


@pytest.mark.parametrize(("friction", "expected"), [(0.5, 0.5 * 1.4), (4.0, 2 + 3.2 * 0.4)])
def test_a_load_increases_friction_or_resists_toppling(friction, expected):
    """Q = 0.4 W at 1.6 m from the right edge: k W = μ(W + Q), or k W h/2 = W b/2 + 1.6 m Q."""
    model = squat(friction)
    model.load(1.4, 1.0, "block", time=(0, 1), force_y=(-0.4 * WEIGHT, -0.4 * WEIGHT))
    assert sitedda.limit_analysis(model).upper.factor == pytest.approx(expected, rel=1e-6)


def test_uplift_reduces_friction():
    """Uplift U below the block: k W = μ(W − U)."""
    model = squat()
    model.water(along=[(1, 0), (3, 0)], head=[1.0, 1.0])
    limits = sitedda.limit_analysis(model)
    expected = 0.5 * (1 - 9810.0 * 2.0 / WEIGHT)
    assert limits.upper.factor == pytest.approx(expected, rel=1e-6)
    assert limits.lower.factor == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("level", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("direction", [LEFT, RIGHT])
def test_backfill_adds_weight_and_passive_pressure(level, direction):
    """k W = μ (W + γ b h) + K_p γ ∫ z dz, h above the block, K_p = 3 at 30°."""
    fill = Backfill([(-4, level), (10, level)], 18e3, 30.0)
    limits = sitedda.limit_analysis(squat(), direction=direction, backfill=fill)
    above, side = max(level - 1, 0.0), 0.5 * (level**2 - max(level - 1, 0.0) ** 2)
    expected = 0.5 * (1 + 18e3 * 2 * above / WEIGHT) + 3 * 18e3 * side / WEIGHT
    assert limits.upper.factor == pytest.approx(expected, rel=1e-6)
    assert limits.lower.factor == pytest.approx(expected, rel=1e-3)
    assert not limits.upper.bolt_force


def test_backfill_ends_with_its_surface_and_strengthens_an_arch():
    beside = Backfill([(4, 1), (10, 1)], 18e3, 30.0)  # no soil at the block, x = 1 to 3 m
    assert sitedda.limit_analysis(squat(), backfill=beside).upper.factor == pytest.approx(0.5)
    model = arch(0.6)
    polygons = sitedda.limit_analysis(model).upper.polygons
    stones = [mass_and_centre(polygon)[1] for polygon in polygons]
    line = sorted(tuple(point) for point in stones if point[1] > 2.5)
    bare = sitedda.travelling_axle(model, line, positions=9)
    fill = Backfill([(-9, 5), (9, 5)], 18e3, 30.0)
    filled = sitedda.travelling_axle(model, line, positions=9, backfill=fill)
    assert filled.least > 1.5 * bare.least


@pytest.mark.parametrize("blocks", [1, 2])
def test_backfill_loads_the_free_part_of_a_stepped_wall(blocks):
    """Soil of 2 m² on the step: k W = μ (W + W_s) for a stepped block and for two blocks."""
    step, upper = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)], box(0, 1, 1, 1)
    parts = {"wall": step} if blocks == 1 else {"lower": box(0, 0, 3, 1), "upper": upper}
    model = assembly({"base": BASE, **parts}, math.tan(math.radians(60)))
    model.joint("slick", friction_angle=10.0)
    model["block.base"].joint = "slick"
    fill = Backfill([(1, 2), (10, 2)], 20e3, 0.0)
    limits = sitedda.limit_analysis(model, direction=LEFT, backfill=fill)
    expected = math.tan(math.radians(10)) * (1 + 2 * 20e3 / (4 * 2500.0 * 9.81))
    assert limits.upper.factor == pytest.approx(expected, rel=1e-6)
    assert limits.lower.factor == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("surface", "area", "side"),
    [
        ([(1.5, 2), (2.5, 2)], 1.0, 0.0),
        ([(-4, 2), (2.5, 2)], 1.5, 0.0),
        ([(-4, 1), (2, 2), (10, 1)], 0.5 * (5 / 6 + 1) + 0.5 * (1 + 7 / 8), 15 / 8 - 0.5),
        ([(-4, 0.5), (2, 1.5), (2.5, 0.5), (10, 0.5)], 0.5 * (1 / 3 + 1 / 2) + 1 / 16, 1 / 8),
    ],
)
def test_backfill_follows_its_surface(surface, area, side):
    """k W = μ (W + γ A) + γ K_p ∫ z dz, with the area A above the block, x = 1 to 3 m."""
    limits = sitedda.limit_analysis(squat(), backfill=Backfill(surface, 18e3, 30.0))
    expected = 0.5 * (1 + 18e3 * area / WEIGHT) + 3 * 18e3 * side / WEIGHT
    assert limits.upper.factor == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"surface": [(2, 3), (0, 3)]}, "ascending x"),
        ({"surface": [(0, 3), (math.nan, 3)]}, "finite"),
        ({"surface": [(0, 3)]}, r"surface has shape \(1, 2\)"),
        ({"surface": "x"}, "surface"),
        ({"unit_weight": -2e4}, "unit_weight = -20000"),
        ({"friction_angle": -30.0}, "friction_angle = -30"),
        ({"friction_angle": 95.0}, "friction_angle = 95"),
        ({"friction_angle": math.nan}, "friction_angle = nan"),
    ],
)
def test_invalid_backfill_is_refused(change, message):
    valid = {"surface": [(0, 3), (2, 3)], "unit_weight": 2e4, "friction_angle": 30.0}
    with pytest.raises(InputError, match=message):
        Backfill(**valid | change)


def test_a_bolt_resists_with_its_yield_force():
    """Bolt force F at the left side: k W h/2 = W b/2 + F b; slack under a push the other way."""
    model, force = squat(5.0), 0.2 * WEIGHT
    model.bolt("tie", (1.0, -0.5), (1.0, 0.5), "base", "block", axial_stiffness=1e8,
               yield_force=force, pretension=0.5 * force)  # fmt: skip
    limits = sitedda.limit_analysis(model)
    assert limits.upper.factor == pytest.approx(2.0 + 4 * 0.2, rel=1e-6)
    assert limits.upper.bolt_force["tie"] == pytest.approx(force, rel=1e-6)
    assert sitedda.limit_analysis(model, direction=LEFT).upper.factor == pytest.approx(2, rel=1e-6)


def test_cohesion_and_tensile_strength_resist():
    """Sliding: k W = μW + c b.  Toppling: k h/2 = (1 + f_t b/W) b/2."""
    ductile = {"law": "mohr_coulomb", "residual_cohesion": 5e3}
    slides = sitedda.limit_analysis(squat(cohesion=5e3, **ductile))
    assert slides.upper.factor == pytest.approx(0.5 + 5e3 * 2 / WEIGHT, rel=1e-6)
    assert slides.lower.factor == pytest.approx(0.5 + 5e3 * 2 / WEIGHT, rel=1e-3)
    turns = sitedda.limit_analysis(squat(4.0, cohesion=1e6, tensile_strength=1e4))
    assert turns.upper.factor == pytest.approx(2 * (1 + 1e4 * 2 / WEIGHT), rel=1e-6)
    assert not turns.upper.slides


def test_a_named_load_can_be_the_variable_load():
    """P at the end of an overhang of 1 m tilts a beam whose weight has an arm of 1 m: P = W."""
    model = assembly({"base": box(-1, -1, 2, 1), "beam": box(-2, 0, 4, 0.5)}, 0.5)
    weight = 2500.0 * 9.81 * 2.0
    model.load(2.0, 0.5, "beam", name="live", time=(0, 1), force_y=(-1e3, -1e3))
    model.load(0.0, 0.5, "beam", name="dead", time=(0, 1), force_y=(-1e4, -1e4))
    limits = sitedda.limit_analysis(model, load="live")
    assert limits.upper.factor == pytest.approx((weight + 1e4) / 1e3, rel=1e-6)
    with pytest.raises(InputError, match="no &load of this name"):
        sitedda.limit_analysis(model, load="lives")


@pytest.mark.parametrize(
    ("axles", "position_of_minimum"), [([(0, 1)], 1.0), ([(0, 1), (0.5, 1)], 1 / 0.75)]
)
def test_an_axle_is_worst_at_the_end_of_an_overhang(axles, position_of_minimum):
    """P (x − 1) = W within the overhang, no limit above the base; two axles share P."""
    model = assembly({"base": box(-1, -1, 2, 1), "beam": box(-2, 0, 4, 0.5)}, 0.5)
    weight = 2500.0 * 9.81 * 2.0
    result = sitedda.travelling_axle(model, [(-0.5, 0.5), (2, 0.5)], axles=axles, positions=26)
    assert result.least == pytest.approx(position_of_minimum * weight, rel=1e-4)
    assert result.worst == pytest.approx(2.5, abs=1e-3)
    assert np.isinf(result.load[result.position < 1.4]).all()
    assert result.limit.verdicts == ("stable", "topples")
    with pytest.raises(InputError, match="no block is at"):
        sitedda.travelling_axle(model, [(-0.5, 0.6), (2, 0.6)])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"axles": []}, "axles has shape"),
        ({"axles": 5}, "axles has shape"),
        ({"axles": [1, 2]}, "axles has shape"),
        ({"axles": [(0, 0)]}, "weights of axles .* got 0"),
        ({"axles": [(0, 1), (1, -1)]}, "weights of axles .* got -1"),
        ({"axles": [(0, math.nan)]}, "axles must be finite, got nan"),
        ({"axles": [(-3, 1)]}, "distances of axles .* got -3"),
        ({"axles": [(2.6, 1)]}, "none is on the line, because all distances exceed 2.5 m"),
        ({"axles": [(1, 1)], "positions": 1}, "none is on the line"),
        ({"line": [(0, 0.5)]}, "line has shape"),
        ({"line": [(0, 0.5), (math.nan, 0.5)]}, "line must be finite"),
    ],
)
def test_invalid_axles_and_lines_are_refused(arguments, message):
    model = assembly({"base": box(-1, -1, 2, 1), "beam": box(-2, 0, 4, 0.5)}, 0.5)
    with pytest.raises(InputError, match=message):
        sitedda.travelling_axle(
            model, **{"line": [(-0.5, 0.5), (2, 0.5)], "positions": 3} | arguments
        )


def test_an_arch_with_a_bolt_and_a_load_has_an_upper_bound_proof():
    """Virtual work of the mechanism: the load does the work that weight and bolt absorb."""
    model = arch(0.6)
    crown = max(sitedda.limit_analysis(model).upper.polygons, key=lambda p: p[:, 1].max())
    x, y = crown.mean(axis=0)
    model.load(x + 1.0, y, time=(0, 1), force_y=(-5e3, -5e3))
    names = [group.name for group in model.of_kind("block")]
    low = {name: np.reshape(model[f"block.{name}"].vertices, (-1, 2)).mean(0) for name in names}
    ends = [low[names[4]], low[names[-5]]]
    model.bolt("tie", *ends, names[4], names[-5], axial_stiffness=1e8, yield_force=2e3)
    limit = sitedda.limit_analysis(model).upper
    ways = limit.displacement

    def way(i, position):
        arm = position - mass_and_centre(limit.polygons[i])[1]
        return ways[i, :2] + ways[i, 2] * np.array([-arm[1], arm[0]])

    for (a, b), position, normal in zip(limit.blocks, limit.points, limit.normals, strict=True):
        opening = way(b, position) - way(a, position)
        slip = abs(opening @ [-normal[1], normal[0]])
        assert opening @ normal >= 0.6 * slip - 1e-5  # joints do no work
    masses = [mass_and_centre(polygon)[0] for polygon in limit.polygons]
    dead = sum(m * -9.81 * w[1] for m, w in zip(masses, ways, strict=True))
    live = sum(m * 9.81 * w[0] for m, w in zip(masses, ways, strict=True))
    loaded = next(i for i, p in enumerate(limit.polygons) if inside(p, (x + 1.0, y)))
    dead += -5e3 * way(loaded, np.array([x + 1.0, y]))[1]
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    first, last = limit.names.index(names[4]), limit.names.index(names[-5])
    dissipation = 2e3 * max(0.0, along @ (way(last, ends[1]) - way(first, ends[0])))
    assert dissipation > 0
    assert (dissipation - dead) / live == pytest.approx(
        limit.factor, rel=1e-3
    )  # error of prestress


def test_the_line_of_thrust_passes_through_the_hinges_of_an_arch():
    """At an opening hinge the resultant is at the closed end; the table has the same forces."""
    model = arch(0.9, ratio=0.12)
    model.bolt("tie", (-1.0, 3.8), (1.0, 3.8), axial_stiffness=1e8, yield_force=10.0)
    limit = sitedda.limit_analysis(model).upper
    rows = [line.split(",") for line in limit.to_csv().split("\n")[1:-1]]
    table = np.array([[float(value) for value in row[2:]] for row in rows])
    assert len(table) == len(limit.points)
    assert table[:, 2] == pytest.approx(limit.normal_force, rel=1e-6, abs=1e-3)
    hinges = 0
    for first, second, x, y, normal, _ in limit.thrust:
        ends = (limit.blocks == (first, second)).all(axis=1)
        opening = table[ends, 4]
        assert normal == pytest.approx(table[ends, 2].sum(), rel=1e-6)
        if opening.max() > 0.01:
            closed = table[ends][np.argmin(opening)]
            assert (x, y) == pytest.approx(tuple(closed[:2]), abs=0.01)
            hinges += 1
    assert hinges == 4
    axes = limit.draw()
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert {"bolt", "line of thrust"} <= set(labels)


def inside(polygon, point) -> bool:
    one, after = polygon, np.roll(polygon, -1, axis=0)
    along, offset = after - one, np.array(point) - one
    return bool((along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0] >= 0).all())
