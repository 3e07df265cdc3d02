# SPDX-License-Identifier: GPL-3.0-or-later
"""One step of DDA in plain Python: numpy for the assembly, scipy.sparse.linalg.splu to solve.

The reference of the speed benchmark: a simple vectorised program that reuses its factor while no
spring changes.  The engine provides the pairs of vertex and edge, so that contact detection is not
part of the measured time.
"""

import statistics
import time

import numpy as np
import speed_models as given
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

OPEN, SLIDE, STICK = 0, 1, 2
STEPS = 3  # number of compared steps
MOST = 25  # open–close iterations of the plain step, which has no line search and may not converge


class PlainStep:
    """Constants of a model; `take` computes one step."""

    def __init__(self, model, penalty: float, step: float):
        self.step = step
        self.normal, self.shear = penalty, penalty / given.SHEAR_RATIO
        self.friction = np.tan(np.radians(given.FRICTION_ANGLE))
        sizes = np.array([len(polygon) for polygon in model.polygons])
        self.first = np.concatenate([[0], np.cumsum(sizes)])
        self.owner = np.repeat(np.arange(len(sizes)), sizes)
        self.next = np.arange(len(self.owner)) + 1
        self.next[self.first[1:] - 1] = self.first[:-1]
        area, centre, moments = polygon_integrals(np.concatenate(model.polygons), self)
        self.reference = np.concatenate(model.polygons) - centre[self.owner]
        self.mass = given.DENSITY * area
        self.inertia = mass_matrices(self.mass, given.DENSITY * moments)
        poisson = given.POISSON_RATIO
        elastic = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
        elastic *= given.YOUNG_MODULUS / (1 - poisson**2)
        self.stiffness = area[:, None, None] * elastic
        self.prestress = area[:, None] * model.stress[:, None] * [model.lateral, 1.0, 0.0]
        self.fixed = model.fixed
        self.fixed_at = np.array([[x, y] for x, y, _ in model.fixed])
        self.fixed_reference = self.fixed_at - centre[[block for *_, block in model.fixed]]
        self.weight = self.mass.max() * given.GRAVITY

    def axes(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation matrices and deformation gradients of the blocks."""
        c, s = np.cos(q[:, 2]), np.sin(q[:, 2])
        rotation = np.array([[c, -s], [s, c]]).transpose(2, 0, 1)
        strain = np.array([[1 + q[:, 3], q[:, 5] / 2], [q[:, 5] / 2, 1 + q[:, 4]]])
        return rotation, rotation @ strain.transpose(2, 0, 1)

    def rows(self, rotation, offset, reference, direction) -> np.ndarray:
        """Return the influence on material points along directions, shape (points, 6)."""
        along = np.einsum("pij,pi->pj", rotation, direction)
        spin = direction[:, 1] * offset[:, 0] - direction[:, 0] * offset[:, 1]
        skew = (along[:, 0] * reference[:, 1] + along[:, 1] * reference[:, 0]) / 2
        return np.column_stack([direction, spin, along * reference, skew])

    def contact_rows(self, q, vertex, edge):
        """Return gaps, and the rows of gap and slip, of (vertex, edge) pairs."""
        rotation, gradient = self.axes(q)
        positions = q[self.owner, :2] + np.einsum(
            "vij,vj->vi", gradient[self.owner], self.reference
        )
        i, j, end = self.owner[vertex], self.owner[edge], self.next[edge]
        edge_vector = positions[end] - positions[edge]
        length = np.linalg.norm(edge_vector, axis=1, keepdims=True)
        tangent = edge_vector / length
        normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        gap = np.einsum("ci,ci->c", positions[vertex] - positions[edge], normal)
        reach_v, reach_e = positions[vertex] - q[i, :2], positions[vertex] - q[j, :2]
        fraction = (
            np.einsum("ci,ci->c", positions[vertex] - positions[edge], tangent)[:, None] / length
        )
        foot_point = self.reference[edge] + fraction * (self.reference[end] - self.reference[edge])
        reference = self.reference[vertex]
        gap_rows = np.stack(
            [self.rows(rotation[i], reach_v, reference, normal),
             -self.rows(rotation[j], reach_e - gap[:, None] * normal, foot_point, normal)], axis=1
        )  # fmt: skip
        slip_rows = np.stack(
            [self.rows(rotation[i], reach_v, reference, tangent),
             -self.rows(rotation[j], reach_e, foot_point, tangent)], axis=1
        )  # fmt: skip
        return gap, gap_rows, slip_rows, np.column_stack([i, j])

    def base(self, q, v, acceleration):
        """Return diagonal blocks and right-hand side without contacts."""
        blocks = 2 / self.step**2 * self.inertia
        blocks[:, 3:, 3:] += self.stiffness
        load = 2 / self.step * np.einsum("bij,bj->bi", self.inertia, v)
        load[:, 3:] -= np.einsum("bij,bj->bi", self.stiffness, q[:, 3:]) + self.prestress
        load[:, 0] -= self.mass * acceleration
        load[:, 1] -= self.mass * given.GRAVITY
        rotation, gradient = self.axes(q)
        stiff = given.FIXED_POINT_RATIO * self.normal
        for (_, _, b), at, reference in zip(
            self.fixed, self.fixed_at, self.fixed_reference, strict=True
        ):
            offset = gradient[b] @ reference
            displacement = q[b, :2] + offset - at
            for direction, distance in zip(np.eye(2), displacement, strict=True):
                row = self.rows(
                    rotation[b : b + 1], offset[None], reference[None], direction[None]
                )[0]
                dashpot = 0.5 * stiff * self.step  # for the velocity at the end, 2 d / step - v
                blocks[b] += (stiff + 2 / self.step * dashpot) * np.outer(row, row)
                load[b] -= (stiff * distance - dashpot * row @ v[b]) * row
        return blocks, load

    def take(self, q, v, contacts, acceleration):
        """Return new coordinates, whether the open–close iteration converged, and its solutions.

        `contacts`: vertex, edge, state, stretch, slide force.
        """
        vertex, edge, state, stretch, slide = contacts
        blocks, load = self.base(q, v, acceleration)
        gap, gap_rows, slip_rows, pair = self.contact_rows(q, vertex, edge)
        factor = None
        for count in range(1, MOST + 1):  # noqa: B007
            if factor is None:
                factor = self.factor(blocks, gap_rows, slip_rows, pair, state)
            is_closed, sticks = state != OPEN, state == STICK
            shear_force = np.where(sticks, self.shear * stretch, np.where(is_closed, slide, 0.0))
            force = load.copy()
            np.add.at(force, pair, gap_rows * (-self.normal * gap * is_closed)[:, None, None])
            np.add.at(force, pair, slip_rows * -shear_force[:, None, None])
            d = factor.solve(force.ravel()).reshape(-1, 6)
            normal_change = np.einsum("cki,cki->c", gap_rows, d[pair])
            shear_change = np.einsum("cki,cki->c", slip_rows, d[pair])
            normal_force = np.where(is_closed, -self.normal * (gap + normal_change), 0.0)
            new_shear_force = np.where(sticks, self.shear * (stretch + shear_change), shear_force)
            pressure = -self.normal * np.minimum(gap + normal_change, 0.0)
            trial = self.shear * (stretch + shear_change)
            bound = self.friction * pressure
            new_state = np.where(pressure > 0, np.where(np.abs(trial) <= bound, STICK, SLIDE), OPEN)
            sliding_force = np.where(new_state == SLIDE, np.sign(trial) * bound, 0.0)
            shear = np.where(new_state == STICK, trial, sliding_force)
            error = max(np.abs(pressure - normal_force).max(),
                        np.abs(shear - new_shear_force).max())  # fmt: skip
            tolerance = 1e-9 * max(self.weight, pressure.max(), np.abs(shear).max())
            if error <= tolerance:
                break
            # Reversed slip sticks first, otherwise it would jump between its two bounds.
            new_state[(new_state == SLIDE) & (state == SLIDE) & (shear * slide < 0)] = STICK
            if (new_state != state).any():
                factor = None
            state, slide = new_state, shear
        return q + d, error <= tolerance, count

    def factor(self, blocks, gap_rows, slip_rows, pair, state):
        """Assemble the matrix and factorise it."""
        n = len(blocks)
        closed, stuck = pair[state != OPEN], pair[state == STICK]
        normal, shear = gap_rows[state != OPEN], slip_rows[state == STICK]
        springs = np.einsum("cki,clj->cklij", self.normal * normal, normal)
        shear_terms = np.einsum("cki,clj->cklij", self.shear * shear, shear)
        diagonal = np.arange(n)
        row = np.concatenate([diagonal, closed.repeat(2, 1).ravel(), stuck.repeat(2, 1).ravel()])
        column = np.concatenate([diagonal, np.tile(closed, 2).ravel(), np.tile(stuck, 2).ravel()])
        values = np.concatenate([blocks, springs.reshape(-1, 6, 6), shear_terms.reshape(-1, 6, 6)])
        rows = 6 * row[:, None, None] + np.arange(6)[:, None] + np.zeros(6, dtype=int)
        columns = 6 * column[:, None, None] + np.arange(6) + np.zeros((6, 1), dtype=int)
        entries = values.ravel(), (rows.ravel(), columns.ravel())
        matrix = coo_matrix(entries, shape=(6 * n, 6 * n)).tocsc()
        options = {"SymmetricMode": True}
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)


def polygon_integrals(positions, shape):
    """Return areas, centroids and second moments (xx, yy, xy) about them of all polygons."""
    blocks = len(shape.first) - 1
    at = positions[shape.first[:-1]][shape.owner]
    a, b = positions - at, positions[shape.next] - at
    cross = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]

    def total(values):
        return np.bincount(shape.owner, values, blocks)

    area = total(cross) / 2
    centre = np.column_stack([total(cross * (a + b)[:, k]) for k in (0, 1)]) / (6 * area[:, None])
    xx, yy = (total(cross * (a[:, k] ** 2 + a[:, k] * b[:, k] + b[:, k] ** 2)) / 12 for k in (0, 1))
    xy = total(cross * (a[:, 0] * (2 * a[:, 1] + b[:, 1]) + b[:, 0] * (2 * b[:, 1] + a[:, 1]))) / 24
    x, y = centre.T
    moments = np.column_stack([xx - area * x**2, yy - area * y**2, xy - area * x * y])
    return area, centre + positions[shape.first[:-1]], moments


def mass_matrices(mass, moments):
    """Return the mass matrices, shape (blocks, 6, 6)."""
    xx, yy, xy = moments.T
    zero = np.zeros_like(xx)
    lower = [
        [xx + yy, -xy, xy, (xx - yy) / 2],
        [-xy, xx, zero, xy / 2],
        [xy, zero, yy, xy / 2],
        [(xx - yy) / 2, xy / 2, xy / 2, (xx + yy) / 4],
    ]
    matrices = np.zeros((len(mass), 6, 6))
    matrices[:, 0, 0] = matrices[:, 1, 1] = mass
    matrices[:, 2:, 2:] = np.array(lower).transpose(2, 0, 1)
    return matrices


def compare(run, reference_step: PlainStep, acceleration) -> dict:
    """Run steps with both programs; return median times and iterations, and the largest difference.

    Differences of places are relative to the largest displacement (or a free fall), in steps whose
    plain iteration converged.  `acceleration(steps)` is that of the base after `steps` steps.
    """
    own_times, times, iterations, differences = [], [], [], []
    for _ in range(STEPS):
        q, v, before = run.coordinates, run.rates, run.contacts
        begun = time.perf_counter()
        run.advance()
        own_times.append(time.perf_counter() - begun)
        contacts = start_of_step(run, before, run.contacts)
        begun = time.perf_counter()
        new, converged, count = reference_step.take(q, v, contacts, acceleration(run.steps))
        times.append(time.perf_counter() - begun)
        iterations.append(count)
        move = max(given.GRAVITY * reference_step.step**2, np.abs(run.coordinates - q)[:, :2].max())
        if converged:
            differences.append(np.abs(new - run.coordinates)[:, :2].max() / move)
    return {"own": statistics.median(own_times), "plain": statistics.median(times),
            "plain_iterations": statistics.median(iterations),
            "difference": max(differences, default=None)}  # fmt: skip


def start_of_step(run, before: dict, after: dict):
    """Return the contacts at the start of a step, with states and stretches of the previous step.

    A contact without a predecessor of the same vertex and edge has that of the nearest contact
    between its two blocks.
    """
    owner = np.repeat(np.arange(len(run.polygons)), [len(polygon) for polygon in run.polygons])
    positions = np.concatenate(run.polygons)
    exact, near_contacts = {}, {}
    for i, (v, e) in enumerate(zip(before["vertex"], before["edge"], strict=True)):
        exact[v, e] = i
        near_contacts.setdefault(frozenset((owner[v], owner[e])), []).append((i, positions[v]))
    old_contacts = []
    for v, e in zip(after["vertex"], after["edge"], strict=True):
        i = exact.get((v, e), -1)
        candidates = near_contacts.get(frozenset((owner[v], owner[e])), [])
        if i < 0 and candidates:
            i, _ = min(candidates, key=lambda candidate: np.hypot(*(candidate[1] - positions[v])))
        old_contacts.append(i)
    old_contacts = np.array(old_contacts)
    is_old = old_contacts >= 0
    state = np.where(is_old, before["state"][old_contacts], OPEN).astype(int)
    stretch = np.where(is_old, before["stretch"][old_contacts], 0.0)
    slide = np.where(is_old, before["shear_force"][old_contacts], 0.0)
    return after["vertex"].astype(int), after["edge"].astype(int), state, stretch, slide
