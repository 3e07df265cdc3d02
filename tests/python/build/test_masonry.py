# SPDX-License-Identifier: GPL-3.0-or-later
"""Masonry from a few numbers: shapes, and contacts between stones."""

import numpy as np
import pytest
import shapely

from sitedda import InputError
from sitedda.cutting.rings import Rings
from sitedda.masonry import Arch, Colonnade, Lintel, MultiLeafWall, Pier, RetainingWall


def polygons(structure):
    return [stone.polygon for stone in structure.blocks()]


def area(structure):
    return Rings.of(polygons(structure)).areas().sum()


def check_stones(structure):
    """Stones are simple, counter-clockwise, do not overlap, and have different names."""
    blocks = structure.blocks()
    shapes = np.array([shapely.Polygon(stone.polygon) for stone in blocks])
    assert shapely.is_valid(shapes).all() and (Rings.of(polygons(structure)).areas() > 0).all()
    one, other = shapely.STRtree(shapes).query(shapes, predicate="overlaps")
    common = shapely.area(shapely.intersection(shapes[one], shapes[other]))
    assert (common < 1e-12 * shapely.area(shapes).mean()).all()
    assert len({stone.name for stone in blocks}) == len(blocks)


STRUCTURES = [
    Arch(radius=5.0, thickness=0.6, voussoirs=27),
    Arch(radius=5.0, thickness=0.6, voussoirs=8, abutment=1.0, centre=(3.0, 100.0)),
    Arch(span=8.0, rise=2.0, thickness=0.5, voussoirs=15, abutment=1.5),
    Arch(span=6.0, rise=5.0, thickness=0.5, voussoirs=22, abutment=1.0),
    Pier(width=2.0, top_width=1.5, height=4.0, courses=8, stones=3),
    Lintel(left=1.0, bottom=3.0, span=1.5, height=0.4, bearing=0.3),
    Colonnade(
        columns=4, drums=6, spacing=3, width=1, top_width=0.8, height=5, capital_width=1.2,
        capital_height=0.4, beam_height=0.7,
    ),
    RetainingWall(base_width=2.5, top_width=1.0, height=5, courses=9, stones=3, face="right"),
    MultiLeafWall(height=3, leaf=0.3, core=0.5, courses=9, core_courses=2, core_stones=2, ties=3),
]  # fmt: skip


@pytest.mark.parametrize("structure", STRUCTURES, ids=lambda one: type(one).__name__)
def test_stones_do_not_overlap(structure):
    check_stones(structure)


def test_stones_have_the_total_area_of_the_structure():
    half = Arch(radius=5.0, thickness=0.6, voussoirs=27)
    ring = 27 * np.sin(np.pi / 27) * 5.0 * 0.6  # trapezoids between the radial lines
    assert area(half) == pytest.approx(ring, rel=1e-12)
    assert area(STRUCTURES[4]) == pytest.approx(1.75 * 4)
    assert area(STRUCTURES[5]) == pytest.approx(2.1 * 0.4)
    assert area(STRUCTURES[6]) == pytest.approx(4 * (0.9 * 5 + 1.2 * 0.4) + (9 + 1.2) * 0.7)
    assert area(STRUCTURES[7]) == pytest.approx(1.75 * 5)
    assert area(STRUCTURES[8]) == pytest.approx(1.1 * 3)


@pytest.mark.parametrize("structure", STRUCTURES[:4])
def test_joints_of_an_arch_are_square_to_it_and_as_long_as_it_is_thick(structure):
    voussoirs = polygons(structure)[: structure.voussoirs]
    for stone, after in zip(voussoirs, voussoirs[1:], strict=False):
        assert (stone[[3, 2]] == after[[0, 1]]).all()  # the same joint, to the last bit
    joints = np.array([stone[1] - stone[0] for stone in voussoirs])
    crown = structure.voussoirs // 2 if structure.is_pointed else -1
    lengths = np.delete(np.hypot(*joints.T), [crown] if crown > 0 else [])
    assert lengths == pytest.approx(structure.thickness, rel=1e-9)
    middles = np.array([0.25 * stone.sum(axis=0) for stone in voussoirs]) - structure.centre
    assert middles[::-1] * (-1, 1) == pytest.approx(middles, abs=1e-12)
    top = 0.5 * (voussoirs[crown][0] + voussoirs[crown][1]) if crown > 0 else None
    if top is not None:
        assert top[1] == pytest.approx(structure.rise, rel=1e-2) and abs(top[0]) < 1e-12
    low = 0.5 * (voussoirs[0][0] + voussoirs[0][1]) - structure.centre
    assert low == pytest.approx([structure.span / 2, 0], abs=1e-12)


BAD = {
    "two ways": (
        lambda: Arch(radius=1, span=2, rise=1, thickness=0.1, voussoirs=5), "either radius",
    ),
    "no size": (lambda: Arch(thickness=0.1, voussoirs=5), "give radius"),
    "odd pointed": (lambda: Arch(span=2, rise=2, thickness=0.1, voussoirs=5), "must be even"),
    "too thick": (lambda: Arch(radius=1, thickness=2.5, voussoirs=5), "twice the radius"),
    "one voussoir": (lambda: Arch(radius=1, thickness=0.1, voussoirs=1), "voussoirs = 1"),
    "nan": (lambda: Pier(width=np.nan, height=1), "width = nan"),
    "too many": (lambda: Pier(width=1, height=1, courses=10**5, stones=10**5), "exceed the limit"),
    "huge count": (lambda: Colonnade(columns=10**9, spacing=2, width=1, height=3), "columns"),
    "capital": (
        lambda: Colonnade(spacing=2, width=1, height=3, capital_width=1.5), "both capital_width",
    ),
    "columns touch": (lambda: Colonnade(spacing=1, width=1, height=3), "columns would touch"),
    "face": (
        lambda: RetainingWall(base_width=2, top_width=1, height=3, face="up"), "face = 'up'",
    ),
    "name": (lambda: Pier(name="", width=1, height=1), "name = ''"),
    "place": (lambda: Pier(centre=np.inf, width=1, height=1), "centre = inf"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_numbers_are_refused_with_a_reason(name):
    make, message = BAD[name]
    with pytest.raises(InputError) as error:
        make()
    assert message in str(error.value)
