# SPDX-License-Identifier: GPL-3.0-or-later
"""Each step of each joint law: forces and states obey the law and balance each block.

The output alone provides all values: formulas of the laws, contact directions from the vertices
at the start of a step, inertia from velocities.  Twice the tolerance of the iteration is allowed.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import hard
import numpy as np
import pytest
import xarray as xr
from shapely import Polygon

import sitedda

OPEN, SLIDE, STICK = 0, 1, 2
DENSITY = 2500.0
ANGLE = 30
GRAVITY = 6.5, -7.0  # steeper than friction
AREA_NORMAL, AREA_SHEAR = 1e11, 4e10


def hyperbola(closure, length, _):
    """Return the normal force of the law of Barton and Bandis, N/m."""
    compression = np.maximum(closure, 0.0)
    return AREA_NORMAL * length * compression / (1.0 - compression / 5e-4)


def rough(force, length):
    """Return the shear strength of the law of Barton and Bandis, N/m."""
    stress = np.maximum(force, 1e-9) / length
    angle = np.clip(ANGLE + 10.0 * np.log10(5e7 / stress), ANGLE, 70.0)
    return force * np.tan(np.radians(angle))


def linear(closure, *_):
    """Return the normal force of contacts of constant stiffness, N/m."""
    return hard.PENALTY * np.maximum(closure, 0.0)


def by_area(closure, length, _=None):
    """Return the normal force of joints with a stiffness per area, N/m."""
    return AREA_NORMAL * length * np.maximum(closure, 0.0)


def lifted(closure, length, path):
    """Return the normal force of joints whose slip dilates by tan 15°, up to 5 mm of slip."""
    return by_area(closure + np.tan(np.radians(15)) * np.minimum(path, 5e-3), length)


def coulomb(force, _):
    """Return the shear strength of friction without cohesion, N/m."""
    return np.tan(np.radians(ANGLE)) * force


LAWS = {  # normal force of a closure, strength at a normal force
    "coulomb": (linear, coulomb),
    "stiffness per area": (by_area, coulomb),
    "barton_bandis": (hyperbola, rough),
    "mohr_coulomb that dilates": (lifted, coulomb),
}


@pytest.fixture(scope="module", params=[(1e-3, 30), (8e-3, 6)], ids=["1 ms", "8 ms"])
def step(request):
    """Return the time step, s, and the number of steps."""
    return request.param


@pytest.fixture(scope="module", params=LAWS)
def run(request, step, tmp_path_factory):
    """Return the law and the output of a wall under sudden inclined gravity."""
    file = tmp_path_factory.mktemp("wall") / "wall.nml"
    text = hard.model(request.param, "sudden", 20, *step, ANGLE, False)
    text = text.replace("&output ", "&output block_interval = 1, ")
    file.write_text(text.replace("gravity = 0.0, -9.81", f"gravity = {GRAVITY[0]}, {GRAVITY[1]}"))
    sitedda.run(file, output=file.with_suffix(".nc"))
    with xr.open_dataset(file.with_suffix(".nc"), decode_times=False) as data:
        return request.param, data.load()


def contacts_of(data, frame):
    """Return the contacts of a frame."""
    return data.isel(contact=np.flatnonzero(data.contact_frame.values == frame))


def tolerance(data):
    """Return the tolerance of a force, N/m: twice the round-off of the stiffest spring."""
    y = data.vertices.values[0, :, 1]
    return 2 * 16 * np.finfo(float).eps * 0.5 * np.ptp(y) * 1e13


def test_forces_and_states_obey_the_law(run):
    law, data = run
    normal_law, strength = LAWS[law]
    states = set()
    for frame in range(1, data.sizes["frame"]):
        contacts = contacts_of(data, frame)
        length = contacts.contact_length.values if "contact_length" in contacts else 1.0
        normal, shear = contacts.contact_normal_force.values, contacts.contact_shear_force.values
        state, bound = contacts.contact_state.values, strength(normal, length)
        tolerance_of_case = tolerance(data)
        path = contacts.contact_slip_path.values if "contact_slip_path" in contacts else 0.0
        expected = normal_law(-contacts.contact_gap.values, length, path)
        assert np.all(np.abs(normal - expected) <= tolerance_of_case)
        assert np.all(np.abs(shear) <= bound + tolerance_of_case)
        assert np.all(np.abs(np.abs(shear) - bound)[state == SLIDE] <= tolerance_of_case)
        assert np.all(normal[state == OPEN] == 0.0)
        assert np.all(normal[state != OPEN] > 0.0)
        states |= set(state)
    assert states == {OPEN, SLIDE, STICK}


def masses(data):
    """Return the masses of all blocks, kg per metre."""
    block_of, position = data.vertex_block.values, data.vertices.values[0]
    blocks = (Polygon(position[block_of == block]) for block in range(data.sizes["block"]))
    return DENSITY * np.array([block.area for block in blocks])


def test_forces_balance_each_block(run, step):
    _, data = run
    vertices, block_of = data.vertices.values, data.vertex_block.values
    mass, rates = masses(data)[:, None], data.block_rates.values[:, :, :2]
    after = np.arange(len(block_of)) + 1
    first_rows = np.flatnonzero(np.diff(block_of, append=-1))
    after[first_rows] = [0, *first_rows[:-1] + 1]
    for frame in range(1, data.sizes["frame"]):
        contacts, position = contacts_of(data, frame), vertices[frame - 1]
        edge = contacts.contact_edge.values
        edge_vectors = position[after[edge]] - position[edge]
        edge_vectors /= np.linalg.norm(edge_vectors, axis=1)[:, None]
        normals = np.stack([edge_vectors[:, 1], -edge_vectors[:, 0]], axis=1)
        normal, shear = contacts.contact_normal_force.values, contacts.contact_shear_force.values
        force = normal[:, None] * normals - shear[:, None] * edge_vectors
        left = mass * (GRAVITY - (rates[frame] - rates[frame - 1]) / step[0])
        np.add.at(left, block_of[contacts.contact_vertex.values], force)
        np.add.at(left, block_of[edge], -force)
        assert np.abs(left[1:]).max() <= 10 * tolerance(data)  # without the fixed base
        assert np.abs(left[1:]).max() < 1e-4 * np.abs(force).max()
