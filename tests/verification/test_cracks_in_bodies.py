# SPDX-License-Identifier: GPL-3.0-or-later
"""Cohesive joints between bodies, and breaking faces within a body: peeled and sheared arms, bent
beams and torn plates."""

from functools import cache

import numpy as np
import pytest
import shapely
import xarray as xr
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu
from strain_points import Body, displacement_operator
from test_bodies import cells_of
from test_meshing import part

import sitedda
from sitedda.meshing.body import mesh_body

SUPPORT = 5e9  # N/m, stiffness of the pins; their elongation yields the force


def halves(boxes, size, on_crack, steps, duration, material, welded, **law) -> sitedda.Model:
    """Return two boxes of cells and a joint 'crack' on the sides that `on_crack` names.

    The boxes are two bodies without other contact, or one body whose faces on the crack break into
    the joint, and whose other faces between the boxes have a thousandth of the strength.
    """
    model = sitedda.Model()
    model.control(time_step=duration / steps, steps=steps, gravity=[0.0, 0.0],
                  analysis="plane_stress", integration="theta")  # fmt: skip
    model.contact(normal_stiffness=SUPPORT / 100)
    model.joint(name="free", friction_angle=0.0)
    set_joints(model, boxes if welded else (), law)
    for name in [*boxes, *(f"{name_of_box} notched" for name_of_box in boxes)] if welded else boxes:
        model.material(name=name, rayleigh_beta=0.0, **material)
    border = shapely.intersection(*(shapely.box(*box) for box in boxes.values()))
    for name, box in boxes.items():
        for number, cell in enumerate(cells_of(box, size)):
            edges_of_cell = zip(cell, np.roll(cell, -1, axis=0), strict=True)
            joints = ["crack" if on_crack(*side) else "free" for side in edges_of_cell]
            model.block(vertices=np.ravel(cell).tolist(), name=f"{name}{number}", joint="free",
                        material=name, body="both" if welded else name)  # fmt: skip
            at_border = shapely.Polygon(cell).intersection(border).length > 0.1 * size
            if not welded:
                model["block"][-1].edge_joints = joints
            elif at_border and "crack" not in joints:
                model["block"][-1].material = f"{name} notched"
    model.output(block_interval=steps)
    return model


def set_joints(model, boxes, law) -> None:
    """Define the joint 'crack' and, for welded boxes, the joint of the notch in front of it."""
    joint_law = {"friction_angle": 0.0, "law": "cohesive"}
    crack = model.joint(name="crack", **joint_law, **law)
    if boxes:
        crack.between = list(boxes)
        notch = model.joint(name="notch", **joint_law, **law)
        notch.between = [f"{name} notched" for name in boxes]
        for power, names in ((1, ("tensile_strength", "cohesion")),
                             (2, ("fracture_energy", "shear_fracture_energy"))):  # fmt: skip
            notch(**{name: 1e-3**power * law[name] for name in names})


def cell_at(model, x, y, box) -> str:
    """Return the name of a cell of a box with a corner, or otherwise a side, at (x, y)."""
    positions = {
        block.name: np.reshape(block.vertices, (-1, 2))
        for block in model["block"]
        if block.name.startswith(box)
    }
    corner = [name for name, at in positions.items() if abs(at - [x, y]).max(axis=1).min() < 1e-9]
    if corner:
        return corner[0]
    return min(
        positions, key=lambda name: shapely.Polygon(positions[name]).distance(shapely.Point(x, y))
    )


def bent(model, block, strength, tension, young, depth, size, pin) -> tuple[float, xr.Dataset]:
    """Return 6M/D² over T of a beam of depth D in three-point bending, and the history of the run.

    The pins are at x = ± `pin`; `block` names the block of a point; at the end of 0.2 s the load
    would be about three times the expected `strength`.
    """
    span = 4 * depth
    load = 4 * strength * tension * depth**2 / 6 / span
    deflection = -3 * (1.3 * load * span**3 / (48 * young * depth**3 / 12) + 1.5 * load / SUPPORT)
    model.motion("drive", [0.0, deflection], 0.2, "displacement")
    for sign in (-1, 1):
        x, support = sign * size / 2, block(sign * pin, 0.0)
        model.fixed_point(x=x, y=depth, block=block(x, depth), direction="y", motion_y="drive")
        model.fixed_point(x=sign * pin, y=0.0, block=support, direction="xy" if sign < 0 else "y")
        model.measured_point(f"pin {sign}", sign * pin, 0.0, support)
    history = model.run(output=False).history
    pins = -SUPPORT * history.displacement.sel(axis="y").values.sum(axis=1)
    return 6 * pins.max() / 2 * (pin - size / 2) / depth**2 / tension, history


@pytest.mark.parametrize(
    ("ratio", "strength", "welded", "steps"),
    [(0.25, 1.760, False, 1600), (1.0, 1.387, False, 1600), (1.0, 1.387, True, 500)],
)
def test_a_beam_in_three_point_bending(ratio, strength, welded, steps):
    """6M/D² over T for a span of 4 D over D/l, l = EG/T²: linear softening, published elements."""
    depth, cells_in_depth, tension, young = 0.2, 8, 3e6, 30e9
    size, span = depth / cells_in_depth, 4 * depth
    energy = depth / ratio * tension**2 / young
    end = span / 2 + depth / 4
    boxes = {"left": (-end, 0, 0, depth), "right": (0, 0, end, depth)}
    model = halves(
        boxes, size, lambda a, b: max(abs(a[0]), abs(b[0])) < 1e-9, steps, 0.2,
        {"density": 2400.0, "young_modulus": young, "poisson_ratio": 0.2, "rayleigh_alpha": 600.0},
        welded, tensile_strength=tension, cohesion=10 * tension, fracture_energy=energy,
        shear_fracture_energy=1000 * energy, normal_stiffness_per_area=200 * young / depth,
    )  # fmt: skip
    curve, history = bent(
        model, lambda x, y: cell_at(model, x, y, "left" if x < 0 else "right"),
        strength, tension, young, depth, size, span / 2,
    )  # fmt: skip
    tolerance = 0.01 if welded else 0.0  # few steps delay the load
    assert curve == pytest.approx(strength, rel=0.02 + tolerance)
    fracture_energy = float(history.energy_fracture[-1])
    assert abs(history.energy_balance.values).max() < 1e-6 * fracture_energy


def test_a_beam_whose_faces_break():
    """The strength is that of two bodies if the faces in the middle of one body break."""
    depth, cells, tension, young, ratio, strength = 0.2, 8, 3e6, 30e9, 0.25, 1.760
    size, steps = depth / cells, 600
    energy, ends = depth / ratio * tension**2 / young, round(2 * cells * 1.125) + 0.5
    model = sitedda.Model()
    model.control(time_step=0.2 / steps, steps=steps, gravity=[0.0, 0.0],
                  analysis="plane_stress", integration="theta")  # fmt: skip
    model.contact(normal_stiffness=SUPPORT / 100)
    for material, joint, factor in (("stone", "strong", 100), ("middle", "weak", 1)):
        model.joint(
            joint, friction_angle=30.0, law="cohesive", tensile_strength=factor * tension,
            cohesion=10 * factor * tension, fracture_energy=factor**2 * energy,
            shear_fracture_energy=1000 * factor**2 * energy,
            normal_stiffness_per_area=200 * young / depth,
        )  # fmt: skip
        model.material(material, density=2400.0, young_modulus=young, poisson_ratio=0.2,
                       rayleigh_alpha=600.0, fracture=joint)  # fmt: skip
    names = {}
    for number, cell in enumerate(cells_of((-ends * size, 0, ends * size, depth), size)):
        x, y = cell.mean(axis=0) / size
        names[round(x), int(y)] = f"c{number}"
        model.block(vertices=np.ravel(cell).tolist(), body="beam", joint="weak",
                    material="middle" if abs(x) < 0.1 else "stone", name=f"c{number}")  # fmt: skip
    model.output(block_interval=steps)
    curve, history = bent(
        model, lambda x, y: names[(0, cells - 1) if y else (round(x / abs(x)) * 2 * cells, 0)],
        strength, tension, young, depth, size, (2 * cells - 0.5) * size,
    )  # fmt: skip
    assert curve == pytest.approx(strength, rel=0.03)  # 1 % is the delay by the steps
    assert abs(history.energy_balance.values).max() < 1e-9 * float(history.energy_fracture[-1])


@pytest.mark.parametrize(("welded", "steps", "bound"), [(False, 1300, 0.01), (True, 650, 0.03)])
def test_arms_that_are_peeled_off_each_other(welded, steps, bound, tmp_path):
    """P √opening does not depend on the crack length: (8/Eh³)^½ (G E h³/12)^¾ in beam theory.
    The tolerance is 1 % plus the delay by the steps: 2 % for 1,450 steps, 1 % for 2,900, per metre
    of crack."""
    young, energy, depth, notch, length, tension = 20e9, 60.0, 0.1, 0.44, 1.0, 2e6
    boxes = {"low": (0, -depth, length, 0), "high": (0, 0, length, depth)}
    model = halves(
        boxes, depth / 4,
        lambda a, b: max(abs(a[1]), abs(b[1])) < 1e-9 and min(a[0], b[0]) > notch - 1e-9, steps,
        1e-3 * steps,
        {"density": 2500.0, "young_modulus": young, "poisson_ratio": 0.0, "rayleigh_alpha": 60.0},
        welded, tensile_strength=tension, cohesion=10 * tension, fracture_energy=energy,
        shear_fracture_energy=100 * energy, normal_stiffness_per_area=200 * tension**2 / energy,
    )  # fmt: skip
    knee = 3 * steps // 13
    half_openings = np.interp(np.arange(steps + 1), [0, knee, steps], [0.0, 0.46e-3, 0.76e-3])
    for name, sign in (("high", 1), ("low", -1)):
        at = cell_at(model, 0.0, sign * depth / 2, name)
        model.motion(name, (sign * half_openings).tolist(), 1e-3, "displacement")
        model.fixed_point(x=0.0, y=sign * depth / 2, block=at, motion_y=name,
                          direction="xy" if sign > 0 else "y")  # fmt: skip
        model.measured_point(name, 0.0, sign * depth / 2, at)
    history = model.run(output=tmp_path / "out.nc").history
    high, low = history.displacement.sel(axis="y").values.T
    product = SUPPORT * (half_openings - high) * np.sqrt(np.maximum(high - low, 0.0))
    exact = np.sqrt(8 / (young * depth**3)) * (energy * young * depth**3 / 12) ** 0.75
    assert product[-4 * steps // 13 :].mean() == pytest.approx(exact, rel=bound)
    fracture_energy = float(history.energy_fracture[-1])
    assert abs(history.energy_balance.values).max() < 1e-9 * fracture_energy


class Notched(Body):
    """An elastic body in plane stress whose faces on y = 0 slide freely up to x = `length`."""

    def __init__(self, polygons, length, young):
        super().__init__(polygons, young, 0.0, plane_strain=False)
        f = self.faces
        on_line = np.maximum(abs(f.start[:, 1]), abs(f.end[:, 1])) < 1e-9
        is_notched = on_line & (np.maximum(f.start[:, 0], f.end[:, 0]) < length + 1e-9)
        for cells in (f.first[is_notched], f.second[is_notched]):
            arms = self.centres[cells] - f.start[is_notched]
            high = abs((arms * f.normal[is_notched]).sum(axis=1))
            np.add.at(self.rest, cells, 0.5 * f.length[is_notched] * high)
        self.strain[is_notched] = 0.0
        normal = f.normal[is_notched]
        for jump_operator in (self.mean, self.linear):  # closed with a thousand times the stiffness
            jump_operator[is_notched] = (
                30
                * normal[:, :, None]
                * np.einsum("ka,kai->ki", normal, jump_operator[is_notched])[:, None]
            )

    def row(self, x, y, axis):
        """Return the influence of the unknowns on the displacement at (x, y), shape (6 cells,)."""
        distance = [shapely.Polygon(cell).distance(shapely.Point(x, y)) for cell in self.polygons]
        cell = int(np.argmin(distance))
        row = np.zeros((len(self.areas), 6))
        row[cell] = displacement_operator(np.array([[x, y]]), self.centres[cell])[0, axis]
        return row.ravel()


@cache
def flexure(span, depth, length, young, cells_in_depth=12):
    """Return the deflection under a unit force at midspan of a beam notched to `length`, and the
    slip at its mouth."""
    cells = [cell for low in (-depth, 0.0)
             for cell in cells_of((0, low, span, low + depth), depth / cells_in_depth)]  # fmt: skip
    body = Notched(cells, length, young)
    load, matrix = -body.row(span / 2, depth, 1), body.stiffness()
    for at in ((0.0, -depth / 2, 0), (0.0, -depth / 2, 1), (span, -depth / 2, 1)):
        row = csc_array(body.row(*at)[:, None])
        matrix = matrix + 1e4 * young * (row @ row.T)
    displacements = splu(matrix.tocsc()).solve(load)
    mouth = body.row(0.0, 1e-6, 0) - body.row(0.0, -1e-6, 0)
    return load @ displacements, mouth @ displacements


@pytest.mark.parametrize("welded", [False, True])
def test_a_notched_beam_that_shears(welded, tmp_path):
    """P = √(2 G/(dC/da)) within 2 %; C is the compliance of the plane body, whose crack length is
    known from the slip at its mouth over P.  (With 4 cells over an arm dC/da is 4 % too large, P is
    2 % too small; in beam theory dC/da is 10 % too small.)"""
    young, energy, depth, span, notch, shear = 20e9, 60.0, 0.1, 1.0, 0.36, 3e6
    steps, knee = 300, 42
    lengths = np.array([0.35, 0.4, 0.45, 0.475])
    table = np.array([flexure(span, depth, length, young) for length in lengths]).T
    sag, slip = (np.polynomial.Polynomial.fit(lengths, values, 3) for values in table)
    strength = np.sqrt(2 * energy / sag.deriv()(lengths[:3]))
    boxes = {"low": (0, -depth, span, 0), "high": (0, 0, span, depth)}
    model = halves(
        boxes, depth / 6,
        lambda a, b: max(abs(a[1]), abs(b[1])) < 1e-9 and min(a[0], b[0]) > notch - 1e-9, steps,
        1e-3 * steps,
        {"density": 2500.0, "young_modulus": young, "poisson_ratio": 0.0, "rayleigh_alpha": 60.0},
        welded, tensile_strength=5 * shear, cohesion=shear, fracture_energy=100 * energy,
        shear_fracture_energy=energy, normal_stiffness_per_area=200 * shear**2 / energy,
    )  # fmt: skip
    displacements = strength * (sag(lengths[:3]) + 1 / SUPPORT)
    deflections = -np.interp(np.arange(steps + 1), [0, knee, steps],
                             [0.0, 0.97 * displacements[0], 1.03 * displacements[2]])  # fmt: skip
    model.motion("drive", deflections.tolist(), 1e-3, "displacement")
    for x, y, box, motion in (
        (span / 2, depth, "high", {"direction": "y", "motion_y": "drive"}),
        (0.0, -depth / 2, "low", {}),
        (span, -depth / 2, "low", {"direction": "y"}),
    ):
        model.fixed_point(x=x, y=y, block=cell_at(model, x, y, box), **motion)
    model.measured_point("load", span / 2, depth, cell_at(model, span / 2, depth, "high"))
    for name in boxes:
        model.measured_point(name, 0.0, 0.0, cell_at(model, 0.0, 0.0, name))
    history = model.run(output=tmp_path / "out.nc").history
    displacement = history.displacement.values
    force = SUPPORT * (displacement[:, 0, 1] - deflections)
    peak = np.argmax(force)
    fine = np.linspace(0.35, 0.45, 1001)
    crack = np.interp(
        (displacement[:, 1, 0] - displacement[:, 2, 0])[peak:] / force[peak:], -slip(fine), fine
    )
    runs = (crack > notch + 0.04) & (crack < 0.449)
    assert np.ptp(crack[runs]) > 0.03
    np.testing.assert_allclose(
        force[peak:][runs] / np.sqrt(2 * energy / sag.deriv()(crack[runs])), 1.0, atol=0.02
    )
    fracture_energy = float(history.energy_fracture[-1])
    assert abs(history.energy_balance.values).max() < 1e-9 * fracture_energy


def test_a_crack_in_a_plate_under_tension(tmp_path):
    """Griffith: σ = √(E G/π a) for a half-length a = 1 m in a plate of 20 m, l = E G/T² = 0.03 a.

    The model is a quarter of the plate on a rigid floor: its joint has half of G and half of the
    opening.  The crack grows when its tip has opened by 2 G/T.
    """
    young, tension, half_length, width, fine = 20e9, 2e6, 1.0, 10.0, 0.5 / 64
    energy = 0.03 * half_length * tension**2 / young
    finite = np.sqrt(1 / np.cos(np.pi * half_length / (2 * width)))
    strength = np.sqrt(young * energy / (np.pi * half_length)) / finite
    fine_lines = [shapely.LineString([(half_length - 2 * fine, 0), (1.25 * half_length, 0)])]
    plate = part([0, 0, half_length, 0, width, 0, width, width, 0, width], 0.5)
    cells = mesh_body([plate], "quadrilateral", fine_lines, fine).polygons
    model = sitedda.Model()
    model.control(time_step=1e-3, steps=500, gravity=[0.0, 0.0], settle=True,
                  analysis="plane_stress", integration="theta")  # fmt: skip
    model.contact(normal_stiffness=1e12)
    model.material("stone", density=2400.0, young_modulus=young, poisson_ratio=0.2,
                   rayleigh_alpha=100.0)  # fmt: skip
    model.material("rigid", density=2400.0, young_modulus=1e7 * young,
                   poisson_ratio=0.0)  # fmt: skip
    model.joint("free", friction_angle=0.0)
    model.joint(
        "crack", friction_angle=0.0, law="cohesive", tensile_strength=tension, cohesion=tension,
        fracture_energy=energy / 2, shear_fracture_energy=1e10, shear_stiffness_per_area=1e7,
        normal_stiffness_per_area=400 * tension**2 / energy,
    )  # fmt: skip
    floor = [-0.5, -1, width + 0.5, -1, width + 0.5, 0, -0.5, 0]
    model.block(vertices=floor, name="floor", material="rigid", joint="crack")
    for number, cell in enumerate(cells, 2):
        edges_of_cell = zip(cell, np.roll(cell, -1, axis=0), strict=True)
        on_crack = [max(a[1], b[1]) < 1e-9 and min(a[0], b[0]) > half_length - 1e-9
                    for a, b in edges_of_cell]  # fmt: skip
        model.block(vertices=np.ravel(cell).tolist(), body="plate", material="stone",
                    edge_joints=["crack" if on else "free" for on in on_crack])  # fmt: skip
        for x, y in cell[cell[:, 0] < 1e-9].tolist():
            model.fixed_point(x=x, y=y, block=str(number), direction="x")
    for x in (-0.5, width + 0.5):
        model.fixed_point(x=x, y=-1.0, block="floor")
    fractions = [0.6, 0.95, 1.05]
    model.traction(side="top", time=[0.0, 0.15, 0.5],
                   normal=[-fraction * strength for fraction in fractions])  # fmt: skip
    model.measured_point("tip", half_length, 0.0, "plate")
    model.output(block_interval=500)
    history = model.run(output=tmp_path / "out.nc").history
    opening = history.displacement[:, 0, 1].values
    runs = float(history.time[np.argmax(opening > energy / tension)])
    assert np.interp(runs, [0.15, 0.5], fractions[1:]) == pytest.approx(1.0, abs=0.03)


def test_a_welded_plate_tears(tmp_path):
    """Griffith's plate of 10 m by 10 m with a notch of a = 1 m at each side: breaking faces bear
    σ = √(E G/π a), with the secant correction for the width, within 3 %."""
    young, tension, half_length, width, fine = 20e9, 2e6, 1.0, 5.0, 0.5 / 32
    energy = 0.03 * half_length * tension**2 / young
    strength = np.sqrt(
        young * energy / (np.pi * half_length) * np.cos(np.pi * half_length / (2 * width))
    )
    fine_lines = [shapely.LineString([(half_length - 2 * fine, 0), (1.25 * half_length, 0)])]
    low = part([0, -width, width, -width, width, 0, half_length, 0, 0, 0], 0.5)
    high = part([0, 0, half_length, 0, width, 0, width, width, 0, width], 0.5)
    cut = mesh_body([low, high], "quadrilateral", fine_lines, fine)
    model = sitedda.Model()
    model.control(time_step=1e-3, steps=500, gravity=[0.0, 0.0], analysis="plane_stress",
                  integration="theta")  # fmt: skip
    model.contact(normal_stiffness=1e12)
    model.joint("free", friction_angle=0.0)
    set_joints(model, ("low", "high"), {
        "tensile_strength": tension, "cohesion": 5 * tension, "fracture_energy": energy,
        "shear_fracture_energy": 100 * energy,
        "normal_stiffness_per_area": 400 * tension**2 / energy})  # fmt: skip
    for name in ("low", "high", "low notched", "high notched"):
        model.material(name, density=2400.0, young_modulus=young, poisson_ratio=0.2,
                       rayleigh_alpha=400.0)  # fmt: skip
    for number, (cell, upper) in enumerate(zip(cut.polygons, cut.parts, strict=True)):
        edges_of_cell = zip(cell, np.roll(cell, -1, axis=0), strict=True)
        notched = any(max(abs(a[1]), abs(b[1])) < 1e-9 and max(a[0], b[0]) < half_length + 1e-9
                      for a, b in edges_of_cell)  # fmt: skip
        name = "high" if upper else "low"
        model.block(vertices=np.ravel(cell).tolist(), body="plate", joint="free",
                    material=f"{name} notched" if notched else name,
                    name=f"{name}{number}")  # fmt: skip
        for x, y in cell[cell[:, 0] < 1e-9].tolist():
            model.fixed_point(x=x, y=y, block=f"{name}{number}", direction="x")
    model.fixed_point(x=width, y=0.0, block=cell_at(model, width, 0.0, "low"), direction="y")
    fractions = [0.0, 0.8, 0.92, 1.06]
    for side in ("top", "bottom"):
        model.traction(side=side, time=[0.0, 0.2, 0.35, 0.5],
                       normal=[-fraction * strength for fraction in fractions])  # fmt: skip
    for name in ("low", "high"):
        model.measured_point(name, half_length, 0.0, cell_at(model, half_length, 0.0, name))
    model.output(block_interval=500)
    history = model.run(output=tmp_path / "out.nc").history
    opening = (history.displacement[:, 1, 1] - history.displacement[:, 0, 1]).values
    tears = float(history.time[np.argmax(opening > 2 * energy / tension)])
    assert np.interp(tears, [0.0, 0.2, 0.35, 0.5], fractions) == pytest.approx(1.0, abs=0.03)
    assert abs(history.energy_balance).max() < 1e-9 * abs(history.energy_input).max()
