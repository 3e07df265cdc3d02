# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshed elastic bodies: uniform strain, three rigid motions, closed forms."""

import numpy as np
import pytest
import shapely
from scipy.sparse.linalg import eigsh, splu
from strain_points import Body, displacement_operator
from test_meshing import CELLS, SHAPES, circle, part

from sitedda.meshing.body import mesh_body

GRADIENT = np.array([[1.1, -0.4], [0.9, 0.3]])
ONE_PART = sorted(name for name in SHAPES if len(SHAPES[name]) == 1)


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("name", SHAPES)
def test_every_face_is_found(name, cells):
    """The sum of L n over all faces and free edges of each cell is zero: no face is missing."""
    body = Body(mesh_body(SHAPES[name], cells).polygons)
    total = np.zeros((len(body.areas), 2))
    vectors = body.faces.length[:, None] * body.faces.normal
    np.add.at(total, body.faces.first, vectors)
    np.add.at(total, body.faces.second, -vectors)
    owner, start, end, normal = body.free_edges()
    np.add.at(total, owner, np.hypot(*(end - start).T)[:, None] * normal)
    assert abs(total).max() < 1e-8 * np.sqrt(body.areas.mean())
    assert body.rest.min() > -1e-9 * body.areas.mean()


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("name", SHAPES)
def test_uniform_strain_is_uniform(name, cells):
    """Patch test: inner cells are in equilibrium, and the energy is that of the whole area."""
    body = Body(mesh_body(SHAPES[name], cells).polygons)
    field = body.linear_field(GRADIENT).ravel()
    stiffness = body.stiffness()
    force = (stiffness @ field).reshape(-1, 6)
    strain = field[3:6]
    energy = 0.5 * strain @ body.matrix @ strain * body.areas.sum()
    assert 0.5 * field @ stiffness @ field == pytest.approx(energy, rel=1e-8)
    inner = np.setdiff1d(np.arange(len(body.areas)), body.free_edges()[0])
    scale = abs(force).max()
    assert abs(force[inner, :3]).max(initial=0.0) < 1e-7 * scale


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("name", ONE_PART)
def test_bodies_have_three_rigid_motions_and_no_others(name, cells):
    body = Body(mesh_body(SHAPES[name], cells).polygons)
    values = eigsh(body.stiffness(), 8, body.mass(), sigma=-1e-3, return_eigenvectors=False)
    values = np.sort(values)
    assert abs(values[:3]).max() < 1e-7 * values[3]


@pytest.mark.parametrize(("deep", "bound"), [(2, 0.035), (4, 0.015)])
@pytest.mark.parametrize("cells", CELLS)
def test_cantilever(cells, deep, bound):
    """First frequency of a beam of 10 m by 1 m, ν = 0, E 10 GPa, 2500 kg/m³: 3.2098 Hz."""
    cut = mesh_body([part([0, 0, 10, 0, 10, 1, 0, 1], 1 / deep)], cells)
    body = Body(cut.polygons, 1e10, 0.0, 2500.0, plane_strain=False)
    stiffness = body.stiffness().tolil()
    owner, start, end, _ = body.free_edges()
    for cell in owner[(start[:, 0] < 1e-9) & (end[:, 0] < 1e-9)]:
        ends = body.polygons[cell][body.polygons[cell][:, 0] < 1e-9]
        for shape in displacement_operator(ends, body.centres[cell]):
            index = 6 * cell + np.arange(6)
            stiffness[np.ix_(index, index)] += 1e14 * shape.T @ shape
    value = eigsh(stiffness.tocsc(), 1, body.mass(), sigma=0.0, return_eigenvectors=False)[0]
    assert np.sqrt(value) / (2 * np.pi) == pytest.approx(3.2098, rel=bound)


def kirsch(points, radius, side, young, poisson):
    """Displacement around a hole under the tension `side` along x, plane strain, shape (k, 2)."""
    r, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    shear, kappa = young / (2 * (1 + poisson)), 3 - 4 * poisson
    q = radius / r
    factor = side * radius / (8 * shear)
    u = r / radius * (kappa + 1) * np.cos(angle)
    u += 2 * q * ((1 + kappa) * np.cos(angle) + np.cos(3 * angle)) - 2 * q**3 * np.cos(3 * angle)
    v = r / radius * (kappa - 3) * np.sin(angle)
    v += 2 * q * ((1 - kappa) * np.sin(angle) + np.sin(3 * angle)) - 2 * q**3 * np.sin(3 * angle)
    return factor * np.column_stack([u, v])


def kirsch_stress(points, radius, side):
    """Stresses σx, σy, τ around the hole, shape (k, 3)."""
    r, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    q = (radius / r) ** 2
    c2, s2, c4, s4 = (f(k * angle) for k in (2, 4) for f in (np.cos, np.sin))
    x = 1 - q * (1.5 * c2 + c4) + 1.5 * q**2 * c4
    y = -q * (0.5 * c2 - c4) - 1.5 * q**2 * c4
    xy = -q * (0.5 * s2 + s4) + 1.5 * q**2 * s4
    return side * np.column_stack([x, y, xy])


def kirsch_error(size, sides, cells, fine):
    """Relative error of the displacements around a hole under the exact tractions."""
    near = [shapely.LinearRing(circle(1.0, sides))] if fine else []
    cut = mesh_body(
        [part([-5, -5, 5, -5, 5, 5, -5, 5], size, [circle(1.0, sides)])],
        cells, near, fine * size if fine else None,
    )  # fmt: skip
    return solve_kirsch(cut.polygons)


def solve_kirsch(polygons):
    """Relative error of the displacements of a plate of cells under the exact tractions."""
    radius, young, poisson = 1.0, 1.0, 0.25
    body = Body(polygons, young, poisson)
    force = np.zeros((len(body.areas), 6))
    owner, start, end, normal = body.free_edges()
    length = np.hypot(*(end - start).T)
    outer = np.hypot(*(0.5 * (start + end)).T) > 2.0
    for fraction in 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3):
        points = start + fraction * (end - start)
        x, y, xy = kirsch_stress(points, radius, 1.0).T
        traction = np.column_stack(
            [x * normal[:, 0] + xy * normal[:, 1], xy * normal[:, 0] + y * normal[:, 1]]
        )
        work = np.einsum("kai,ka->ki", displacement_operator(points, body.centres[owner]), traction)
        np.add.at(force, owner[outer], (0.5 * length[:, None] * work)[outer])
    # A small mass prevents rigid motions.
    tiny = 1e-9 * body.mass()
    displacements = splu((body.stiffness() + tiny).tocsc()).solve(force.ravel()).reshape(-1, 6)
    exact = kirsch(body.centres, radius, 1.0, young, poisson)
    weight = body.areas[:, None]
    rigid = displacement_operator(body.centres, 0.0)[:, :, :3]
    errors = displacements[:, :2] - exact
    off = np.linalg.lstsq(
        (rigid * np.sqrt(weight)[:, None]).reshape(-1, 3), (errors * np.sqrt(weight)).ravel(), None
    )[0]
    errors -= rigid @ off
    return np.sqrt((weight * errors**2).sum() / (weight * exact**2).sum())


@pytest.mark.parametrize(
    ("cells", "fine", "bounds"),
    [
        ("quadrilateral", None, (0.005, 0.002)),
        ("quadrilateral", 0.25, (0.0025, 0.001)),
        ("voronoi", None, (0.006, 0.0025)),
        ("voronoi", 0.25, (0.003, 0.0013)),
    ],
)
def test_hole_in_a_plate(cells, fine, bounds):
    """Kirsch: a hole of radius 1 in a square of side 10 under the exact tractions."""
    for size, sides, bound in ((0.5, 128, bounds[0]), (0.25, 256, bounds[1])):
        assert kirsch_error(size, sides, cells, fine) < bound


@pytest.mark.parametrize("cells", CELLS)
def test_order_on_cells_fitted_to_a_hole(cells):
    """Kirsch with sides of the hole as long as cells: order 1.8 over two halvings, 2.5 found.
    Each of many short sides would have its own narrow cell."""
    coarse, fine = (kirsch_error(0.5 / part, 12 * part, cells, None) for part in (1, 4))
    assert np.log2(coarse / fine) / 2 > 1.8
