# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundaries: absorbing half-spaces, incoming motions, equilibrium on dashpots, bad input."""

import numpy as np
import pytest
from lattices import DENSITY, MODULUS, POISSON, ROCK, SPEED, lattice, moved
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import eigvalsh

import sitedda

BARE = {"density": None, "shear_velocity": None, "pressure_velocity": None, "motion_x": None}
RATIO = DENSITY * SPEED / (ROCK["density"] * ROCK["shear_velocity"])


def soil(title: str = "soil", penalty: float = 40.0, **control) -> sitedda.Model:
    control = {"time_step": 1e-3, "analysis": "plane_strain"} | control
    if "duration" not in control:
        control.setdefault("steps", 1)
    model = sitedda.Model(title, **control)
    model.contact(normal_stiffness=penalty * MODULUS)
    model.material("soil", density=DENSITY, young_modulus=MODULUS, poisson_ratio=POISSON)
    model.joint("glue", friction_angle=40.0, cohesion=1e12, tensile_strength=1e12)
    return model


def stack(layers: int, height=20.0, motion=(0.0, 1.0), axis="x", penalty=2e4, **control):
    """Layers on a compliant base, on rollers that permit only shear or only compression."""
    model = soil(penalty=penalty, **control)
    model.layers("layer", width=1.0, thickness=height / layers, count=layers)
    model.motion("rock", list(motion), model.control.time_step, "acceleration", drift_order=0)
    model.boundary("base", "compliant", side="bottom", **{f"motion_{axis}": "rock"}, **ROCK)
    normal_axis = "y" if axis == "x" else "x"
    for side in ("left", "right"):
        model.boundary(side=side, kind="roller", direction=normal_axis)
    model.measured_point("surface", 0.5, height)
    model.measured_point("base", 0.5, 0.0)
    return model


def grid(columns: int = 4, rows: int = 4, **control) -> sitedda.Model:
    """Square blocks of 2 m under gravity, on a compliant base between viscous sides."""
    model = soil(gravity=(0.0, -9.81), settle=True, **control)
    for j in range(rows):
        for i in range(columns):
            x, y = 2.0 * i, 2.0 * j
            model.block([x, y, x + 2, y, x + 2, y + 2, x, y + 2], name=f"b_{i}_{j}")
    model.motion("rock", [0.0, 1.0, -1.0, 0.5, 0.0], 0.01, "acceleration")
    model.boundary("base", "compliant", side="bottom", motion_x="rock", **ROCK)
    for side in ("left", "right"):
        model.boundary(side, "viscous", side=side, direction="normal")
    model.measured_point("corner", 0.0, 2.0 * rows)
    return model


def outcrop_ratio(frequencies, height: float = 20.0):
    """Surface over outcrop of one undamped layer on a half-space."""
    phase = 2 * np.pi * np.asarray(frequencies) * height / SPEED
    return 1 / abs(np.cos(phase) + 1j * RATIO * np.sin(phase))


def test_a_layer_on_a_half_space_amplifies_in_time():
    """Spectral ratio of surface to outcrop for a pulse, within 1 % of the peak."""
    step, frequencies = 2e-3, np.linspace(0.75, 5.0, 18)
    time = np.arange(0.0, 0.5, step)
    motion = np.sin(2 * np.pi * time / 0.5) * np.sin(np.pi * time / 0.5) ** 2
    model = stack(40, motion=motion, integration="midpoint", time_step=step, duration=3.0)
    history = model.run().history
    velocity = history.velocity.sel(point="surface", axis="x").values
    outcrop = np.cumsum((motion[1:] + motion[:-1]) / 2) * step

    def spectrum(values):
        times = step * np.arange(1, len(values) + 1)
        return np.exp(-2j * np.pi * np.outer(frequencies, times)) @ values

    exact = outcrop_ratio(frequencies)
    ratio = abs(spectrum(velocity[1:]) / spectrum(outcrop))
    assert max(abs(ratio - exact)) < 0.01 * max(exact)
    work = history.energy_damping.values[-1] + history.energy_input.values[-1]
    assert max(abs(history.energy_balance.values)) < 1e-6 * work


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_pulse_leaves_through_a_half_space_of_the_same_rock(axis):
    """The base moves once with the upgoing and once with the downgoing pulse, then rests."""
    step, height = 5e-4, 20.0
    time = np.arange(0.0, 0.12, step)
    motion = np.sin(np.pi * time / 0.12) ** 2 * np.sin(4 * np.pi * time / 0.12)
    model = stack(40, height, motion, axis, time_step=step, duration=0.6, integration="midpoint")
    base = model["boundary"][0]
    base(density=DENSITY, shear_velocity=SPEED, pressure_velocity=None)
    history = model.run().history
    velocity = history.velocity.sel(axis=axis).values
    names = history.point.values
    surface, bottom = (velocity[:, names == name].ravel() for name in ("surface", "base"))
    assert max(abs(surface)) == pytest.approx(2 * max(abs(bottom)), rel=0.02)
    assert max(abs(bottom[-200:])) < 0.01 * max(abs(bottom))


@pytest.mark.parametrize("integration", ["dda", "midpoint", "theta"])
def test_nothing_moves_when_dashpots_replace_supports(integration):
    """Less than 1e-9 of the settlement at the change of stage, and no creep in 60 s."""
    model = grid(integration=integration, time_step=0.02, duration=60.0)
    model["boundary"][0].motion_x = None
    run = model.run()
    sag = DENSITY * 9.81 * 8.0**2 / 2 / (1.2 * MODULUS)
    assert abs(run.history.displacement.values).max() < 1e-9 * sag


def test_incoming_is_half_of_the_outcrop_and_within_is_the_base_itself():
    step = {"time_step": 1e-3, "duration": 0.2}
    motion = np.sin(np.linspace(0, 6 * np.pi, 200))
    runs = {}
    for kind in ("outcrop", "incoming", "within"):
        model = stack(4, motion=motion, **step)
        model["boundary"][0].motion_is = kind
        runs[kind] = model.run().history.velocity.sel(axis="x")
    np.testing.assert_allclose(runs["incoming"], 2 * runs["outcrop"], rtol=1e-6, atol=1e-12)
    base = runs["within"].sel(point="base").values
    driven = cumulative_trapezoid(motion, dx=1e-3, initial=0.0)
    np.testing.assert_allclose(base[:200], driven, atol=1e-3 * abs(driven).max())


def test_checkpoints_and_threads_are_bit_identical(tmp_path, same_everywhere):
    model = grid(time_step=1e-3, steps=200)
    same_everywhere(model.write(tmp_path / "grid.nml"), 77)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kind": None}, "kind is missing"),
        ({"kind": "open"}, "kind = 'open' must be one of"),
        ({"side": None}, "the group selects no edges"),
        ({"side": "north"}, "side = 'north' must be one of"),
        ({"along": [0.0, -5.0, 9.0, -5.0], "side": None}, "no edge of the outline is selected"),
        ({"along": [0.0, -5.0, 9.0], "side": None}, "along: a value is missing"),
        ({"edges": [1.0]}, "blocks is missing: edges needs it"),
        ({"blocks": "b_0_0", "edges": [1.5]}, "is not a whole number"),
        ({"blocks": "nobody"}, "nothing is named 'nobody'"),
        ({"direction": "z"}, "direction = 'z' must be one of"),
        ({"density": -1.0}, "density = -1"),
        ({"shear_velocity": 0.0}, "shear_velocity = 0"),
        ({"pressure_velocity": 700.0}, "must exceed the velocity of S waves"),
        ({"motion_x": "nothing"}, "is not the name of a &motion"),
        ({"kind": "viscous"}, "motion_x belongs to kind = 'fixed'"),
        ({"kind": "fixed"}, "density belongs to kind = 'viscous'"),
        ({"motion_is": "total"}, "motion_is = 'total' must be one of"),
        ({"motion_x": None, "motion_is": "within"}, "motion_is needs motion_x or motion_y"),
        ({"kind": "roller", "direction": "xy", **BARE}, "kind = 'fixed' fixes both"),
        ({"kind": "fixed", "direction": "normal", **BARE, "motion_x": "rock"}, "need direction"),
    ],
)
def test_bad_boundaries_are_refused_with_a_reason(values, message):
    model = grid()
    base = model["boundary"][0]
    for name, value in values.items():
        base._values.pop(name, None)
        if value is not None:
            base._values[name] = value
    with pytest.raises(sitedda.InputError, match=message) as error_info:
        model.check()
    assert str(error_info.value).startswith("Model.boundary(…), ")


def test_weight_on_dashpots_needs_a_static_stage():
    model = grid()
    model.control.settle = None
    with pytest.raises(sitedda.InputError, match="dashpots cannot support weight"):
        model.check()


@pytest.mark.parametrize("integration", ["dda", "midpoint", "theta"])
@pytest.mark.parametrize("direction", ["x", "y"])
def test_tied_sides_make_level_ground_of_any_width(integration, direction):
    """All columns move alike, to 1e-8 of the peak; with free sides they do not."""
    tied_motion = moved(lattice("tied", direction, integration=integration))
    peak = abs(tied_motion).max()
    assert abs(tied_motion - tied_motion[:, :, :1]).max() < 1e-8 * peak
    if integration == "dda":
        free_motion = moved(lattice("free", direction))
        assert abs(free_motion - free_motion[:, :, :1]).max() > 0.01 * peak


def test_a_mirrored_model_has_the_mirrored_motion():
    motion = moved(lattice("free", columns=4), columns=4)
    mirrored_motion = moved(lattice("free", columns=4, order=-1, acceleration=-1.0), columns=4)
    mirrored_motion = mirrored_motion[:, :, ::-1] * [-1, 1]
    np.testing.assert_allclose(motion, mirrored_motion, atol=1e-10 * abs(motion).max())


def test_energy_of_ties_balances():
    history = lattice("tied", acceleration=1.0).run().history
    work = history.energy_damping.values[-1] + history.energy_input.values[-1]
    assert abs(history.energy_balance.values).max() < 1e-6 * work


def test_ties_of_a_removed_block_are_removed():
    """The block tied to it falls freely: n² Δt² g / 2 in n steps of DDA."""
    model = soil(steps=None, gravity=(0.0, -9.81))
    for name, x in (("left", 0.0), ("right", 2.0)):
        model.block([x, 0.0, x + 2, 0.0, x + 2, 2.0, x, 2.0], name=name)
    for y in (0.5, 1.5):
        model.fixed_point(3.0, y, "right")
    model.boundary(kind="tied")
    model.measured_point("left", 1.0, 1.0)
    model.stage(name="rest", kind="static")
    model.stage(name="fall", remove="right", steps=300)
    history = model.run().history
    fall = history.displacement[-1, 0] - history.displacement[0, 0]
    assert float(fall[1]) == pytest.approx(-9.81 * 0.3**2 / 2, rel=1e-3)
    assert abs(float(fall[0])) < 1e-4
    assert abs(history.energy_balance.values[-1]) < 1e-6 * history.energy_kinetic.values[-1]


def base_of_a_block(angle: float, **motions) -> sitedda.Model:
    """A block on a compliant base, rotated about its corner by an angle in degrees."""
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    corners = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0], [1.5, 0.5]])
    *corners, centre = corners @ [[cos, sin], [-sin, cos]]
    model = soil()
    model.block(np.ravel(corners), name="block")
    model.motion("rock", [0.0, 1.0, 0.0], 0.01, "acceleration")
    model.boundary("base", "compliant", blocks="block", edges=1, **ROCK, **motions)
    model.measured_point("centre", *centre, block="block")
    return model


def test_the_transfer_function_of_an_inclined_base_is_that_of_its_axes():
    frequencies = np.array([1.0, 10.0, 100.0])

    def centre(axis: str, angle: float, **motions):
        model = base_of_a_block(angle, **motions)
        return sitedda.transfer(model, frequencies, "centre", None, axis)

    along_x, along_y = centre("x", 0.0, motion_x="rock"), centre("y", 0.0, motion_y="rock")
    for angle, motions in ((30.0, {"motion_y": "rock"}), (70.0, {"motion_y": "rock"})):
        cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        expected = cos**2 * along_y + sin**2 * along_x
        np.testing.assert_allclose(centre("y", angle, **motions), expected, rtol=1e-9)


def rigid_on_dashpots(width: float, height: float, frequencies) -> np.ndarray:
    """Motion of the top of a rigid block over the outcrop motion of its base; its sides are fixed.

    (−ω²M + iωC) q = iω C_b e_x, C = Σ ∫ Rᵀ (ρV_p n nᵀ + ρV_s t tᵀ) R over the edges, C_b over the
    base: q = (u, v, φ) of the centroid, R the rigid motion of a point.
    """
    normal, along = (ROCK["density"] * ROCK[f"{kind}_velocity"] for kind in ("pressure", "shear"))

    def damping(start, end) -> np.ndarray:
        start, end = np.array(start), np.array(end)
        length = np.hypot(*(end - start))
        t = (end - start) / length
        n, total = np.array([t[1], -t[0]]), np.zeros((3, 3))
        for abscissa in (0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3)):
            x, y = start + abscissa * (end - start)
            motion = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
            for direction, impedance in ((n, normal), (t, along)):
                row = direction @ motion
                total += 0.5 * length * impedance * np.outer(row, row)
        return total

    right, top = 0.5 * width, 0.5 * height
    base = damping((-right, -top), (right, -top))
    sides = damping((right, -top), (right, top)) + damping((-right, top), (-right, -top))
    mass = DENSITY * width * height * np.diag([1.0, 1.0, (width**2 + height**2) / 12])
    omega = 2 * np.pi * np.asarray(frequencies)[:, None, None]
    response = np.linalg.solve(-(omega**2) * mass + 1j * omega * (base + sides), 1j * omega * base)
    return response[:, 0, 0] - top * response[:, 2, 0]


@pytest.mark.parametrize(("width", "height"), [(2.0, 1.0), (1.0, 3.0)])
def test_a_rigid_block_with_moving_and_fixed_dashpots(width, height, capfd):
    """No spring supports the block, and the boundaries have different motions."""
    model = soil(integration="midpoint", time_step=1e-6)
    model["material"][0].young_modulus = 1e7 * MODULUS  # ωρV_p/E is 2e-6
    model.block([0.0, 0.0, width, 0.0, width, height, 0.0, height], name="block")
    model.motion("rock", [0.0, 1.0, 0.0], 0.01, "acceleration")
    model.boundary("base", "compliant", side="bottom", motion_x="rock", **ROCK)
    for side in ("left", "right"):
        model.boundary(side, "viscous", side=side, **ROCK)
    model.measured_point("top", 0.5 * width, height)
    frequencies = np.array([0.5, 5.0, 50.0, 200.0])
    response = sitedda.transfer(model, frequencies, "top", None)
    np.testing.assert_allclose(response, rigid_on_dashpots(width, height, frequencies), rtol=1e-5)
    assert "illegal" not in "".join(capfd.readouterr())


def test_a_layer_between_two_half_spaces_transmits_as_in_the_closed_form():
    """1/[(1 + Z₂/Z₁) cos kH + i (Z/Z₁ + Z₂/Z) sin kH] ; Z₁ of the lower, Z₂ of the upper half."""
    height, layers = 20.0, 40
    model = soil(penalty=2e5, integration="midpoint", time_step=1e-5)
    model.layers("layer", width=1.0, thickness=height / layers, count=layers)
    model.motion("rock", [0.0, 1.0, 0.0], 0.01, "acceleration")
    model.boundary("base", "compliant", side="bottom", motion_x="rock", **ROCK)
    upper_rock = {"density": 900.0, "shear_velocity": 150.0, "pressure_velocity": 300.0}
    model.boundary("top", "viscous", side="top", **upper_rock)
    model.boundary(kind="tied")
    model.measured_point("surface", 0.5, height)
    frequencies = np.linspace(0.5, 5.0, 10)
    phase = 2 * np.pi * frequencies * height / SPEED
    soil_impedance, below = DENSITY * SPEED, ROCK["density"] * ROCK["shear_velocity"]
    impedance = upper_rock["density"] * upper_rock["shear_velocity"]
    exact = 1 / (
        (1 + impedance / below) * np.cos(phase)
        + 1j * (soil_impedance / below + impedance / soil_impedance) * np.sin(phase)
    )
    response = sitedda.transfer(model, frequencies, "surface", None)
    assert max(abs(response - exact)) < 1e-3 * max(abs(exact))


BED, WIDTH, HEIGHT = 3e9, 3.0, 2.0  # Pa/m, m


def on_springs(angle: float = 0.0, time_step: float = 1e-4, **options) -> sitedda.Model:
    """An almost rigid block on a bed of springs, rotated about its lower left corner (degrees)."""
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    corners = [[0.0, 0.0], [WIDTH, 0.0], [WIDTH, HEIGHT], [0.0, HEIGHT], [WIDTH / 2, HEIGHT / 2]]
    *corners, centre = np.array(corners) @ [[cos, sin], [-sin, cos]]
    model = soil(gravity=(0.0, 0.0), time_step=time_step, **options)
    model["material"][0].young_modulus = 1e15
    model.block(np.ravel(corners), name="block")
    model.boundary("bed", "springs", blocks="block", edges=1, stiffness_per_area=BED)
    model.measured_point("centre", *centre, block="block")
    return model


def bed_matrices() -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass matrices of a rigid block on the bed: x and y of the centre, rotation."""
    spring, arm = BED * WIDTH, HEIGHT / 2
    stiffness = spring * np.array([[1.0, 0.0, arm], [0.0, 1.0, 0.0], [arm, 0.0, 0.0]])
    stiffness[2, 2] = spring * (arm**2 + WIDTH**2 / 12)
    mass = DENSITY * WIDTH * HEIGHT
    return stiffness, np.diag([mass, mass, mass * (WIDTH**2 + HEIGHT**2) / 12])


@pytest.mark.parametrize("gravity", [(0.0, -9.81), (3.0, -9.0)])
def test_a_block_settles_on_a_bed_of_springs(gravity):
    """The settlement is W/k; an inclined load also rotates the block."""
    model = on_springs(steps=None)
    model.control.gravity = gravity
    model.stage(name="rest", kind="static")
    history = model.run().history
    stiffness, mass = bed_matrices()
    displacement = np.linalg.solve(stiffness, mass[0, 0] * np.array([*gravity, 0.0]))
    np.testing.assert_allclose(history.displacement[-1, 0], displacement[:2], rtol=3e-5, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_the_frequencies_of_a_block_on_a_bed_are_those_of_its_springs(angle):
    stiffness, mass = bed_matrices()
    exact = np.sqrt(eigvalsh(stiffness, mass)) / (2 * np.pi)
    frequencies = sitedda.modes(on_springs(angle), count=3).frequency
    np.testing.assert_allclose(frequencies, exact, rtol=1e-6)


@pytest.mark.parametrize("integration", ["dda", "midpoint"])
def test_a_block_on_a_bed_that_moves_follows_the_transfer_function(integration):
    """1/(1 − (f/f₀)²) for vertical motion; the energy budget of a run balances."""
    model = on_springs(duration=0.2, integration=integration)
    model.motion("rock", [0.0, 20.0, -20.0, 0.0], 0.05, "acceleration")
    model["boundary"][0].motion_y = "rock"
    own_frequency = np.sqrt(BED * WIDTH / bed_matrices()[1][0, 0]) / (2 * np.pi)
    frequencies = own_frequency * np.array([0.1, 0.7, 3.0])
    if integration == "midpoint":
        response = sitedda.transfer(model, frequencies, "centre", None, "y")
        warped = np.tan(np.pi * frequencies * 1e-4) / (np.pi * 1e-4)  # with steps of 1e-4 s
        exact = 1 / (1 - (warped / own_frequency) ** 2)
        np.testing.assert_allclose(response, exact, rtol=1e-5)
    history = model.run().history
    assert abs(history.energy_input.values[-1]) > 1.0
    balance = abs(history.energy_balance.values).max()
    assert balance < 1e-7 * abs(history.energy_input.values).max()
    assert (np.diff(history.energy_algorithmic.values) >= 0).all()


def test_a_run_on_a_bed_that_moves_has_the_same_bits_everywhere(tmp_path, same_everywhere):
    model = on_springs(steps=200)
    model.motion("rock", [0.0, 20.0, -20.0, 0.0], 0.005, "acceleration")
    model["boundary"][0].motion_y = "rock"
    reference = same_everywhere(model.write(tmp_path / "bed.nml"), 111)
    assert abs(reference.energy_input.values[-1]) > 0


@pytest.mark.parametrize(
    ("kind", "side", "values", "message"),
    [
        ("tied", "left", {}, "kind = 'tied' excludes side"),
        ("tied", None, {"direction": "x"}, "excludes direction"),
        ("tied", None, {"density": 2000.0}, "density belongs to kind"),
        ("tied", None, {"blocks": "b_0_0"}, "excludes blocks"),
        ("tied", None, {"motion_is": "within"}, "motion_is belongs to kind = 'compliant'"),
        ("springs", "right", {}, "stiffness_per_area is missing"),
        ("fixed", "right", {"stiffness_per_area": BED}, "stiffness_per_area"),
        ("springs", "right", {"stiffness_per_area": BED, "density": 2000.0}, "density belongs"),
        ("springs", "right", {"stiffness_per_area": 0.0}, "stiffness_per_area = 0"),
        ("free_field", None, {}, "needs side = 'left' or side = 'right'"),
        ("free_field", "bottom", {}, "needs side = 'left' or side = 'right'"),
        ("free_field", "left", {"along": [0.0, 0.0, 0.0, 3.0]}, "kind = 'free_field' excludes al"),
        ("free_field", "left", {"motion_x": "rock"}, "motion_x belongs to kind"),
        ("free_field", "left", {"direction": "x"}, "excludes direction"),
        ("free_field", "left", {"density": -1.0}, "density = -1"),
    ],
)
def test_bad_values_of_a_kind_are_refused_with_a_reason(kind, side, values, message):
    model = lattice("free", columns=3)
    model.boundary(kind=kind, side=side, **values)
    with pytest.raises(sitedda.InputError, match=message):
        model.check()
