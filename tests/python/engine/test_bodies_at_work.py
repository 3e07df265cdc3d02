# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies in time steps against closed forms: spinning disc, Hertz, non-matching meshes."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from strain_points import Body
from test_bodies import DENSITY, YOUNG, model_of
from test_meshing import circle, part

import sitedda
from sitedda.meshing.body import mesh_body


def second_moments(polygon):
    """Second moments of a polygon about its centroid, shape (2, 2)."""
    after = np.roll(polygon, -1, axis=0)
    double = polygon[:, 0] * after[:, 1] - polygon[:, 1] * after[:, 0]
    midpoints = (0.5 * polygon, 0.5 * after, 0.5 * (polygon + after))
    return sum(np.einsum("k,ki,kj->ij", double / 6, at, at) for at in midpoints)


def angular_momentum(run, areas, moments):
    """Angular momentum about the origin over the density, with the initial masses of the blocks."""
    position, rate = run.coordinates, run.rates
    x, y = position[:, :2].T
    orbit = areas * (x * rate[:, 1] - y * rate[:, 0])
    a, b, c = moments[:, 0, 0], moments[:, 1, 1], moments[:, 0, 1]
    spin = (a + b) * rate[:, 2] + c * (rate[:, 4] - rate[:, 3]) + 0.5 * (a - b) * rate[:, 5]
    return (orbit + spin).sum()


def test_a_spinning_disc():
    """Initial stress σ_r(0) = (3 + ν) ρ ω² R²/8 over 2 rad in plane stress, ωΔt = 0.01: momentum to
    1e-12, stress of the centre within 3 %, energy within 1e-6 and of order 2."""
    radius, rate, poisson = 5.0, 10.0, 0.25
    cells = mesh_body([part(circle(radius, 48), 1.145)], "voronoi").polygons
    body = Body(cells)
    r, angle = np.hypot(*body.centres.T), np.arctan2(*body.centres.T[::-1])
    unit = DENSITY * rate**2 / 8
    radial = unit * (3 + poisson) * (radius**2 - r**2)
    hoop = unit * ((3 + poisson) * radius**2 - (1 + 3 * poisson) * r**2)
    mean, half = (radial + hoop) / 2, (radial - hoop) / 2
    stress = np.stack([mean + half * np.cos(2 * angle), mean - half * np.cos(2 * angle),
                       half * np.sin(2 * angle)], axis=1)  # fmt: skip
    moments = np.array([second_moments(c - m) for c, m in zip(cells, body.centres, strict=True)])
    energy_gain = []
    for step in (1e-3, 5e-4):
        steps = round(0.2 / step)
        model = model_of([], time_step=step, steps=steps, integration="midpoint")
        for number, (cell, (x, y)) in enumerate(zip(cells, body.centres.tolist(), strict=True)):
            model.material(
                name=f"m{number}", density=DENSITY, young_modulus=YOUNG, poisson_ratio=poisson,
                initial_stress=stress[number].tolist(),
                initial_velocity=[-rate * y, rate * x, rate],
            )  # fmt: skip
            model.block(vertices=np.ravel(cell).tolist(), body="disc", material=f"m{number}")
        with sitedda.Simulation(model) as run:
            kinetic = run.energies["kinetic"]
            start = angular_momentum(run, body.areas, moments)
            run.advance(steps)
            change = angular_momentum(run, body.areas, moments) / start - 1
            assert abs(change) < (1e-12 if step == 1e-3 else 1e-10)  # tolerance of the solver
            assert abs(run.energies["balance"]) < 1e-9 * kinetic
            energy_gain.append(abs(run.energies["geometric"]) / kinetic)
            middle = run.stresses[np.argmin(r), :2]
            np.testing.assert_allclose(middle, unit * (3 + poisson) * radius**2, rtol=0.03)
            assert np.mean(run.coordinates[:, 2]) == pytest.approx(rate * step * steps, rel=1e-3)
    assert energy_gain[0] < 1e-6
    assert energy_gain[1] < energy_gain[0] / 4


def test_hertz():
    """A cylinder of 1 m on a rigid plane, 1 MN/m, ν = ¼: half-width 10.93 mm within 3 %, largest
    pressure 58.27 MPa within 5 %, with 5.6 cells over the half-width."""
    radius, force, poisson, fine = 1.0, 1e6, 0.25, 0.125 / 64
    width = np.sqrt(4 * force * radius * (1 - poisson**2) / (np.pi * YOUNG))
    assert width == pytest.approx(10.9255e-3, rel=1e-5)
    angle = np.arcsin(fine * np.arange(np.ceil(1.5 * width / fine) + 1))
    side = fine
    while angle[-1] + side < np.pi:
        angle = np.append(angle, angle[-1] + side)
        side = min(0.12, 1.25 * side)
    angle = np.concatenate([angle, -angle[:0:-1]])
    outline = radius * np.column_stack([np.sin(angle), 1 - np.cos(angle)])
    fine_lines = [shapely.LineString([(-1.6 * width, 0), (1.6 * width, 0)])]
    cells = mesh_body([part(outline.ravel(), 0.125)], "quadrilateral", fine_lines, fine).polygons
    model = model_of([], steps=None, analysis="plane_strain")
    model.material(name="hard", density=DENSITY, young_modulus=1e6 * YOUNG, poisson_ratio=0.0)
    model.contact(normal_stiffness=1e11)
    model["joint"][0].friction_angle = 0.0
    model["joint"][0].normal_stiffness_per_area = 1e15
    model.block(name="plane", vertices=[-2, -1, 2, -1, 2, 0, -2, 0], material="hard")
    for cell in cells:
        model.block(vertices=np.ravel(cell).tolist(), body="disc", material="rock")
    for x in (-2.0, 2.0):
        model.fixed_point(x=x, y=-1.0, block="plane")
    for y in (radius, 1.95 * radius):
        model.fixed_point(x=0.0, y=y, block="disc", direction="x")
    model.load(x=0.0, y=1.95 * radius, block="disc", time=[0.0, 1.0], force_y=[-force, -force])
    model.stage(name="rest", kind="static")
    history = model.run().history
    corners = np.concatenate([np.reshape(model["block"][0].vertices, (-1, 2)), *cells])
    owner = np.repeat(np.arange(len(cells) + 1), [4, *map(len, cells)])
    is_last = history.contact_frame.values == history.contact_frame.values.max()
    vertex = history.contact_vertex.values[is_last]
    x, normal_force = corners[vertex, 0], history.contact_normal_force.values[is_last]
    assert normal_force.sum() == pytest.approx(force, rel=1e-6)
    assert 2 * np.sqrt(normal_force @ x**2 / force) == pytest.approx(width, rel=0.03)
    length = np.bincount(owner[vertex], history.contact_length.values[is_last])
    forces = np.bincount(owner[vertex], normal_force)
    pressure = (forces / np.maximum(length, 1e-9)).max()
    assert pressure == pytest.approx(2 * force / (np.pi * width), rel=0.05)


def rows_of(left, right, low, count, shift=0.0):
    """Four rows of cells from `low` over 1 m; their inner joints are displaced by `shift`."""
    x, y = np.linspace(left, right, count + 1), np.linspace(low, low + 1, 5)
    x[1:-1] += shift
    rows = [(c, d, a, b) for c, d in pairwise(y) for a, b in pairwise(x)]
    return [np.array([[a, c], [b, c], [b, d], [a, d]]) for c, d, a, b in rows]


APART = {
    "polygons": mesh_body([part([0, 1, 3, 1, 3, 2, 0, 2], 0.3)], "voronoi").polygons,
    **{
        f"apart by {name}": rows_of(0.0, 3.0, 1.0, 12, shift)
        for name, shift in (("40%", 0.1), ("5%", 0.012), (".4%", 0.001), (".004%", 1e-5), ("0", 0))
    },
}


def stress_under(pressure, upper, poisson, friction=30.0, **joint):
    """Stresses of two bodies with non-matching meshes over the pressure, shape (cells, 3)."""
    model = model_of([rows_of(0.0, 3.0, 0.0, 12), upper], poisson, steps=40, time_step=1.0,
                     dynamic_factor=0.0)  # fmt: skip
    model["joint"][0](friction_angle=friction, **joint)
    model.contact(normal_stiffness=1e3 * YOUNG, force_tolerance=1e-13)
    for side in ("top", "bottom"):
        model.traction(side=side, normal=[pressure])
    model.fixed_point(x=0.0, y=0.0)
    model.fixed_point(x=3.0, y=0.0, direction="y")
    if not friction:
        model.fixed_point(x=0.0, y=2.0, direction="x")
    return model.run().history.block_stress.values[-1] / pressure


@pytest.mark.parametrize("points", [2, 3])
@pytest.mark.parametrize("name", APART)
def test_bodies_whose_meshes_do_not_match_bear_uniform_pressure(name, points):
    """Following pressure acts on 1 + ν p/E of the edge length; otherwise only the rounding of
    positions remains, 10⁻¹⁶ over the strain."""
    pressure, poisson = 1e5, 0.25
    stress = stress_under(pressure, APART[name], poisson, contact_points=points,
                          normal_stiffness_per_area=100 * YOUNG)  # fmt: skip
    np.testing.assert_allclose(abs(stress[:, 1] + 1), poisson * pressure / YOUNG, atol=1e-9)
    np.testing.assert_allclose(stress[:, [0, 2]], 0.0, atol=1e-9)


@pytest.mark.parametrize("name", list(APART)[:4])
def test_pressure_is_uniform_to_twelve_digits(name):
    """A pressure of E/100 on soft joints reduces rounding of positions: p/(1 − ν p/E).  (7·10⁻⁸ if
    vertices coincide; friction retains 3·10⁻⁹ of the displacement of the first step.)"""
    pressure, poisson = 0.01 * YOUNG, 0.25
    stress = stress_under(pressure, APART[name], poisson, friction=0.0, contact_points=3,
                          normal_stiffness_per_area=10 * YOUNG)  # fmt: skip
    stretch = 1 / (1 - poisson * pressure / YOUNG)
    np.testing.assert_allclose(stress, len(stress) * [[0.0, -stretch, 0.0]], rtol=0, atol=2e-12)
