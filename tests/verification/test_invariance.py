# SPDX-License-Identifier: GPL-3.0-or-later
"""The same model mirrored, turned, far away, renumbered or in other units has the same results.

A pile of irregular blocks slides, rocks and hits a shaken base under oblique gravity.  Places are
multiples of 1/64 m, so that translation and rotation are exact; only the rounding of the run,
amplified by its contacts, remains.
"""

import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from model_text import group, namelist

import sitedda

few = settings(max_examples=6, derandomize=True, deadline=None, database=None)
# Tolerance relative to the largest displacement or stress: forces of a step are converged to 1e-9
# of the largest; rounding selects a solution within this, and 150 steps amplify the difference.
AMPLIFIED = 1e-7
STEPS = 150

GROUND = [[-4.0, -1.0], [4.0, -1.0], [4.0, 0.0], [-4.0, 0.0]]
ELL = [[-2.0, 0.0], [0.0, 0.0], [0.0, 0.5], [-1.0, 0.5], [-1.0, 1.5], [-2.0, 1.5]]
SLAB = [[-0.984375, 0.515625], [0.515625, 0.5], [0.5, 1.0], [-0.875, 1.015625]]
WEDGE = [[0.25, 0.015625], [1.25, 0.0], [0.75, 0.453125]]
HELD = [[-3.0, -0.5], [3.0, -0.5], [-3.0, -0.75], [3.0, -0.75]]


@dataclass(frozen=True)
class Pile:
    """A model that can be transformed; in SI units unless `units` was called."""

    blocks: list = field(default_factory=lambda: [np.array(b) for b in (GROUND, ELL, SLAB, WEDGE)])
    numbers: tuple = (0, 1, 2, 3)  # index of each block in the original pile
    starts: tuple = (0, 0, 0, 0)  # index of the first vertex of each block in the original block
    flipped: bool = False  # vertices are in reversed order
    held: np.ndarray = field(default_factory=lambda: np.array(HELD))
    loaded: np.ndarray = field(default_factory=lambda: np.array([-1.5, 1.0]))
    load: np.ndarray = field(default_factory=lambda: np.array([4000.0, -2000.0]))
    gravity: np.ndarray = field(default_factory=lambda: np.array([2.0, -9.81]))
    shaking: np.ndarray = field(default_factory=lambda: np.array([1.0, 0.0]))
    speed: np.ndarray = field(default_factory=lambda: np.array([0.25, -0.5]))  # of wedge and slab
    spin: float = 0.25
    acceleration: float = 4.0
    friction: float = 30.0
    density: float = 2600.0
    young: float = 2.0e9
    penalty: float = 1.0e9
    time_step: float = 1e-3
    second: float = 1.0

    def groups(self) -> list:
        """Return the groups of the input."""
        solid = {"density": self.density, "young_modulus": self.young, "poisson_ratio": 0.2}
        thrown = [*self.speed, self.spin]
        axis = int(np.argmax(np.abs(self.shaking)))
        pulse = self.acceleration * np.sin(np.linspace(0, 4 * np.pi, 41)) * self.shaking[axis]
        names = ("ground", "ell", "slab", "wedge")
        materials = ("still", "still", "thrown", "thrown")
        supported = {"block": "ground", f"motion_{'xy'[axis]}": "pulse"}
        return [
            group("control", time_step=self.time_step, steps=STEPS, gravity=self.gravity,
                  max_displacement_ratio=0.01),
            group("contact", normal_stiffness=self.penalty),
            group("material", name="still", **solid),
            group("material", name="thrown", **solid, initial_velocity=thrown),
            group("joint", name="joint", friction_angle=self.friction),
            group("motion", name="pulse", values=pulse, time_step=0.004 * self.second,
                  quantity="acceleration"),
            *(group("block", name=names[number], material=materials[number],
                    vertices=np.asarray(outline).ravel())
              for number, outline in zip(self.numbers, self.blocks, strict=True)),
            *(group("fixed_point", x=x, y=y, **supported) for x, y in self.held),
            group("load", x=self.loaded[0], y=self.loaded[1], block="ell",
                  time=[0.0, 0.05 * self.second, 0.1 * self.second],
                  force_x=[0.0, self.load[0], 0.0], force_y=[0.0, self.load[1], 0.0]),
            group("output", block_interval=30),
        ]  # fmt: skip

    # --- Transformed models ---

    def turned(self, matrix) -> "Pile":
        """Transform by an orthogonal matrix of zeros and ones; blocks remain counter-clockwise."""
        mirror = np.linalg.det(matrix) < 0
        order = slice(None, None, -1) if mirror else slice(None)
        return replace(
            self,
            blocks=[(outline @ matrix.T)[order] for outline in self.blocks],
            flipped=self.flipped ^ mirror,
            held=self.held @ matrix.T,
            loaded=matrix @ self.loaded,
            load=matrix @ self.load,
            gravity=matrix @ self.gravity,
            shaking=matrix @ self.shaking,
            speed=matrix @ self.speed,
            spin=-self.spin if mirror else self.spin,
        )

    def moved(self, shift) -> "Pile":
        """Translate by a vector."""
        return replace(self, blocks=[outline + shift for outline in self.blocks],
                       held=self.held + shift, loaded=self.loaded + shift)  # fmt: skip

    def renumbered(self, order, first_corners) -> "Pile":
        """Reorder the blocks, and start each at another vertex."""
        return replace(
            self,
            blocks=[np.roll(self.blocks[i], -first_corners[i], axis=0) for i in order],
            numbers=tuple(order),
            starts=tuple(first_corners),
        )

    def units(self, length: float, mass: float, time: float = 1.0) -> "Pile":
        """Convert to units: so many per metre, kilogram and second.

        The thickness is one length unit: a force per thickness has the unit mass / time².
        """
        force, stress = mass / time**2, mass / (length * time**2)
        return replace(
            self,
            blocks=[outline * length for outline in self.blocks],
            held=self.held * length,
            loaded=self.loaded * length,
            load=self.load * force,
            gravity=self.gravity * length / time**2,
            speed=self.speed * length / time,
            spin=self.spin / time,
            acceleration=self.acceleration * length / time**2,
            density=self.density * mass / length**3,
            young=self.young * stress,
            penalty=self.penalty * stress,
            time_step=self.time_step * time,
            second=self.second * time,
        )


def answer(pile: Pile) -> tuple[np.ndarray, np.ndarray]:
    """Return displacements of vertices and stresses in the numbering of the original pile.

    Shapes (frames, vertices, 2) and (frames, blocks, 2, 2).
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "pile.nml"
        file.write_text(namelist(pile.groups()))
        history = sitedda.run(file).history
    assert int(history.iterations.max()) > 1  # contacts open, close or slide
    vertices, owner = history.vertices.values, history.vertex_block.values
    displacements = vertices - vertices[0]
    parts, tensors = [None] * 4, [None] * 4
    for b, number in enumerate(pile.numbers):
        displacements_of_block = displacements[:, owner == b]
        displacements_of_block = (
            displacements_of_block[:, ::-1] if pile.flipped else displacements_of_block
        )
        parts[number] = np.roll(displacements_of_block, pile.starts[number], axis=1)
        sx, sy, txy = np.moveaxis(history.block_stress.values[:, b], -1, 0)
        tensors[number] = np.stack([np.stack([sx, txy], -1), np.stack([txy, sy], -1)], -2)
    return np.concatenate(parts, axis=1), np.stack(tensors, axis=1)


def assert_same(computed, expected, tolerance=AMPLIFIED):
    for quantity, one, other in zip(("moves", "stresses"), computed, expected, strict=True):
        worst = np.max(np.abs(one - other)) / np.max(np.abs(other))
        print(f"{quantity} differ by {worst:.1e}")
        assert worst <= tolerance, f"{quantity} differ by {worst:.1e} of the largest"


piles = st.builds(
    Pile,
    friction=st.sampled_from([5.0, 20.0, 30.0, 45.0]),
    acceleration=st.floats(1.0, 8.0),
    gravity=st.builds(lambda x, y: np.array([x, y]), st.floats(-3.0, 3.0), st.floats(-12.0, -8.0)),
)


def test_the_pile_slides_and_hits_the_base():
    displacements, stresses = answer(Pile())
    assert np.abs(displacements[-1]).max() > 0.01
    assert np.ptp(displacements[-1, 4:10, 0]) > 0 and np.abs(stresses).max() > 0


MIRRORS = {
    "left and right": np.array([[-1.0, 0.0], [0.0, 1.0]]),
    "up and down": np.array([[1.0, 0.0], [0.0, -1.0]]),
    "x and y": np.array([[0.0, 1.0], [1.0, 0.0]]),
}
TURNS = {
    "90": np.array([[0.0, -1.0], [1.0, 0.0]]),
    "180": np.array([[-1.0, 0.0], [0.0, -1.0]]),
    "270": np.array([[0.0, 1.0], [-1.0, 0.0]]),
}


@pytest.mark.parametrize("matrix", [*MIRRORS.values(), *TURNS.values()], ids=[*MIRRORS, *TURNS])
@settings(few, max_examples=3)
@given(pile=piles)
def test_a_mirrored_or_turned_pile_has_the_same_results(matrix, pile):
    displacements, stresses = answer(pile.turned(matrix))
    original_axes = displacements @ matrix, matrix.T @ stresses @ matrix
    assert_same(original_axes, answer(pile))


@few
@example(pile=Pile(), shift=(1_000_000, -1_000_000))
@given(pile=piles, shift=st.tuples(*[st.integers(-1_000_000, 1_000_000)] * 2))
def test_a_distant_pile_has_the_same_results(pile, shift):
    # places of 1e6 m in the output have an accuracy of 1e-10 m
    displacements, stresses = answer(pile.moved(np.array(shift, dtype=float)))
    expected = answer(pile)
    scale = np.max(np.abs(expected[0]))
    assert np.max(np.abs(displacements - expected[0])) <= AMPLIFIED * scale + 1e-9
    assert_same((expected[0], stresses), expected)


@few
@given(
    pile=piles,
    order=st.permutations(range(4)),
    first_corners=st.tuples(
        st.integers(0, 3), st.integers(0, 5), st.integers(0, 3), st.integers(0, 2)
    ),
)
def test_a_renumbered_pile_has_the_same_results(pile, order, first_corners):
    assert_same(answer(pile.renumbered(order, first_corners)), answer(pile))


UNITS = {
    "mm, t, s": (1e3, 1e-3, 1.0),
    "mm, kg, ms": (1e3, 1.0, 1e3),
    "ft, slug, s": (1 / 0.3048, 1 / 14.593903, 1.0),
    "cm, g, s": (1e2, 1e3, 1.0),
}


@pytest.mark.parametrize("unit", UNITS.values(), ids=UNITS)
@settings(few, max_examples=2)
@given(pile=piles)
def test_a_pile_in_other_units_has_the_same_results(unit, pile):
    length, mass, time = unit
    displacements, stresses = answer(pile.units(*unit))
    assert_same((displacements / length, stresses * length * time**2 / mass), answer(pile))
