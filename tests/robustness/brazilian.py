# SPDX-License-Identifier: GPL-3.0-or-later
"""Strength of discs of welded cells that are split between platens, for meshes of several seeds.

    python tests/robustness/brazilian.py [--meshes 20] [--first 1] [--size 0.005] [--zone 0.1]

A disc of D = 0.1 m has flat ends of 15°, and faces with l = EG/T² = `zone` D.  The reference has
the same disc, law and load, but a straight crack: only faces on the loaded diameter break, where
its cells have a third of the size.  Its strength is above that of a brittle disc under point loads,
which has the tension T at its centre under ½ π D T: flat ends spread the load, and a softening
crack still bears load.  The script prints forces over ½ π D T and over the reference.
"""

import numpy as np
import shapely
from options import parse_options

import sitedda
from sitedda.meshing.body import Part, mesh_body

DIAMETER, YOUNG, STRENGTH = 0.1, 30e9, 4e6
FLAT = np.radians(15.0)
TOP = 0.5 * DIAMETER * np.cos(FLAT / 2)  # m, half the distance of the flat ends
UNIT = 0.5 * np.pi * DIAMETER * STRENGTH  # N/m
STEP, SPEED, RISE = 1e-6, 0.1, 2e-4  # s, m/s, s


def outline(side: str) -> np.ndarray:
    """The disc, or half of it, by corners 7.5° apart except for the flats, shape (n, 2), m."""
    angle = np.radians(np.arange(-82.5, 83.0, 7.5))
    right = 0.5 * DIAMETER * np.column_stack([np.cos(angle), np.sin(angle)])
    left = right[::-1] * [-1, 1]
    ends = np.array([[0.0, TOP], [0.0, -TOP]])
    if side == "whole":
        return np.concatenate([right, left])
    return np.concatenate([right, ends] if side == "right" else [left, ends[::-1]])


def disc(sides, cells, size, zone, seed=0) -> sitedda.Model:
    """A disc between two platens that approach; two `sides` can break only along their boundary."""
    model = sitedda.Model()
    model.control(time_step=STEP, steps=4000, gravity=[0.0, 0.0], integration="theta",
                  analysis="plane_stress")  # fmt: skip
    model.contact(normal_stiffness=1e12)
    model.material("steel", density=7800.0, young_modulus=200e9, poisson_ratio=0.3)
    model.joint("platen", friction_angle=5.0)
    energy = zone * DIAMETER * STRENGTH**2 / YOUNG
    bond = model.joint(
        "bond", law="cohesive", friction_angle=30.0, tensile_strength=STRENGTH,
        cohesion=3 * STRENGTH, fracture_energy=energy,
        normal_stiffness_per_area=400 * STRENGTH**2 / energy,
    )  # fmt: skip
    for side in sides:
        model.material(side, density=2600.0, young_modulus=YOUNG, poisson_ratio=0.2)
    if len(sides) == 2:
        bond.between = list(sides)
    else:
        model["material"][-1].fracture = "bond"
    time = 2e-5 * np.arange(201)
    motion = SPEED * np.where(time < RISE, time**2 / (2 * RISE), time - RISE / 2)
    model.motion("down", (-motion).tolist(), 2e-5, "displacement")
    for name, sign, motions in (("bottom", -1, {}), ("top", 1, {"motion_y": "down"})):
        low, high = sorted([sign * TOP, sign * (TOP + 0.02)])
        model.block(name=name, vertices=[-0.02, low, 0.02, low, 0.02, high, -0.02, high],
                    material="steel", joint="platen")  # fmt: skip
        for x in (-0.02, 0.02):
            model.fixed_point(x=x, y=sign * (TOP + 0.02), block=name, **motions)
    fine_lines = [shapely.LineString([(0, -TOP), (0, TOP)])] if len(sides) == 2 else []
    outlines = [outline(side) for side in sides]
    parts = [Part(one, ["platen"] * len(one), size) for one in outlines]
    cut = mesh_body(parts, cells, fine_lines, size / 3 if fine_lines else None, seed)
    for polygon, part in zip(cut.polygons, cut.parts, strict=True):
        model.block(vertices=np.ravel(polygon).tolist(), body="disc", material=sides[part],
                    joint="platen")  # fmt: skip
    return model


def largest_force(model, every=10, most_steps=1400) -> float:
    """Return the largest force of a platen, N/m, before a drop to 0.9 of it or until the dissipated
    energy is 0.9 of the fracture energy of a diameter."""
    largest, energy_limit = 0.0, 0.9 * model["joint"][1].fracture_energy * DIAMETER
    with sitedda.Simulation(model) as run:
        for _ in range(most_steps // every):
            run.advance(every)
            contacts = run.contacts
            on_top = (contacts["edge"] // 4 == 1) | (contacts["vertex"] // 4 == 1)
            force = contacts["normal_force"][on_top].sum()
            largest = max(largest, force)
            has_failed = largest > 0.8 * UNIT and force < 0.9 * largest
            if has_failed or run.energies["fracture"] > energy_limit:
                return float(largest)
    raise RuntimeError(f"{most_steps} steps are too few to split the disc")


def straight(size, zone) -> float:
    """Return the largest force of the disc with a straight crack, N/m."""
    return largest_force(disc(["left", "right"], "quadrilateral", size, zone))


def meshed(size, zone, seed) -> float:
    """Return the largest force of a disc of polygons whose faces may all break, N/m."""
    return largest_force(disc(["whole"], "voronoi", size, zone, seed))


def main():
    options = parse_options(__doc__, meshes=20, first=1, size=0.005, zone=0.1)
    exact = straight(options.size, options.zone)
    ratio = f"{exact / UNIT:.3f} of the force of a brittle disc"
    print(f"reference, straight crack: {ratio}", flush=True)
    forces = []
    for seed in range(options.first, options.first + options.meshes):
        forces.append(meshed(options.size, options.zone, seed))
        ratio = forces[-1] / UNIT
        print(f"seed {seed}: {ratio:.3f}, {forces[-1] / exact:.3f} of the reference", flush=True)
    forces = np.array(forces) / exact
    print(f"mean {forces.mean():.3f}, standard deviation {forces.std(ddof=1):.3f}, "
          f"{forces.min():.3f} to {forces.max():.3f} of the reference")  # fmt: skip


if __name__ == "__main__":
    main()
