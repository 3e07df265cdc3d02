# SPDX-License-Identifier: GPL-3.0-or-later
"""Largest values of a run over all steps, compared with an independent evaluation."""

import math
import zlib
from base64 import b64decode

import numpy as np
import pytest
import xarray as xr
from model_text import changed, flying_block, group, rectangle, without

import sitedda
from sitedda.scene import Scene
from sitedda.view import view

ROCK = {"name": "rock", "density": 2500.0, "young_modulus": 1e10, "poisson_ratio": 0.2}
SHAKE = [0.0, 3.0, 5.0, 1.0, -4.0, -6.0, -2.0, 2.0, 4.0, 0.0, -3.0, 0.0, 0.0]  # m/s²; ends at rest
EVERY = 0.01  # interval of these samples, s
AREAS = np.array([4.0, 0.4, 0.48, 0.14, 0.27, 0.03])  # areas of the blocks of `pile`, m²
SIZE = 8.0  # size of this model, m
EQUAL = {"rel": 1e-10, "abs": 1e-13}


def pile(steps: int = 120, friction: float = 20.0, **control) -> list:
    """Blocks of several sizes on a floor that is shaken in x."""
    blocks = {
        "floor": rectangle(-3.0, -0.5, 8.0, 0.5),
        "wide": rectangle(0.0, 0.0, 1.0, 0.4),
        "tall": rectangle(0.2, 0.4, 0.4, 1.2),
        "cap": rectangle(0.1, 1.6, 0.7, 0.2),
        "stone": rectangle(2.0, 0.0, 0.3, 0.9),
        "beam": rectangle(2.0, 0.9, 0.3, 0.1),
    }
    support = {"block": "floor", "y": -0.5, "motion_x": "shake"}
    return [
        ("control", {"time_step": 1e-3, "gravity": [0.0, -9.81], **control}
         | ({"steps": steps} if steps else {})),
        ("material", ROCK),
        group("joint", name="j", friction_angle=friction),
        *(group("block", name=name, vertices=at) for name, at in blocks.items()),
        group("motion", name="shake", quantity="acceleration", drift_order=0, time_step=EVERY,
              values=SHAKE),
        ("fixed_point", support | {"x": -3.0}),
        ("fixed_point", support | {"x": 5.0}),
        group("measured_point", name="foot", block="wide", x=0.5, y=0.1),
        group("measured_point", name="head", block="cap", x=0.5, y=1.8),
        group("measured_point", name="side", block="beam", x=2.1, y=1.0),
    ]  # fmt: skip


def shaken(time: float) -> tuple[float, float]:
    """Displacement and velocity of the motion; accelerations are linear between samples."""
    u = v = 0.0
    for k, (a, b) in enumerate(zip(SHAKE, SHAKE[1:], strict=False)):
        s = min(time - k * EVERY, EVERY)
        if s <= 0:
            break
        u += s * v + s**2 * a / 2 + s**3 * (b - a) / EVERY / 6
        v += s * a + s**2 * (b - a) / EVERY / 2
    return u, v


class Observer:
    """Maxima computed from a `Simulation` between steps, relative to a given base."""

    def __init__(self, run, chi: float, is_shaken: bool):
        self.run, self.chi, self.moves = run, chi, is_shaken
        self.found = {}
        self.time, self.u, self.v = 0.0, np.zeros(2), np.zeros(2)
        self.first, self.rates = run.coordinates, run.rates
        polygons = run.polygons
        self.owner = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
        firsts = np.cumsum([0, *(len(p) for p in polygons)])
        self.next = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in
                                    zip(firsts, firsts[1:], strict=False)])  # fmt: skip
        corners = np.concatenate(polygons)
        size = np.ptp(corners, axis=0).max()
        self.area = AREAS
        contacts = run.contacts
        is_touching = contacts["gap"] <= 1e-5 * size
        self.pairs = np.stack([contacts["vertex"], contacts["edge"]], 1)[is_touching].astype(int)
        edges, normal_legs = self.legs(corners)
        self.share = (normal_legs * edges).sum(1) / (edges * edges).sum(1)
        self.gap = np.maximum(0.0, cross(normal_legs, edges) / np.linalg.norm(edges, axis=1))
        self.points = run.point_motions
        self.see(first=True)

    def legs(self, corners):
        v, e = self.pairs.T
        return corners[self.next[e]] - corners[e], corners[v] - corners[e]

    def take(self, name, values, owners) -> None:
        values = np.asarray(values, dtype=float)
        if len(values) and values.max() > self.found.get(name, (-1.0,))[0]:
            peak = int(values.argmax())
            self.found[name] = (values[peak], self.run.time, tuple(np.atleast_1d(owners[peak])))

    def step(self) -> None:
        """Advance by one step and update the maxima."""
        self.run.advance(1)
        self.see()

    def follow(self, dt: float) -> np.ndarray:
        """Return the acceleration of the base; store its displacement and velocity."""
        if not self.moves or dt == 0:
            return np.zeros(2)
        u, v = (np.array([x, 0.0]) for x in shaken(self.run.time))
        if self.chi > 0.5:
            v = (u - self.u) / (self.chi * dt) - (1 / self.chi - 1) * self.v
        a, self.u, self.v = (v - self.v) / dt, u, v
        return a

    def see(self, first: bool = False) -> None:
        run = self.run
        dt, self.time = run.time - self.time, run.time
        base = self.follow(dt)
        q, v, blocks = run.coordinates, run.rates, np.arange(len(self.area))
        size = lambda x: np.linalg.norm(x, axis=1)  # noqa: E731
        self.take("tilt", abs(q[:, 2] - self.first[:, 2]), blocks)
        self.take("displacement", size(q[:, :2] - self.first[:, :2] - self.u), blocks)
        self.take("velocity", size(v[:, :2] - self.v), blocks)
        a = 0 * v if first else (v - self.rates) / dt
        self.take("acceleration", size(a[:, :2] - base), blocks)
        self.rates = v
        strain = [np.linalg.eigvalsh([[e[0], e[2] / 2], [e[2] / 2, e[1]]]) for e in q[:, 3:]]
        self.take("strain", abs(np.array(strain)).max(1), blocks)
        self.see_contacts()
        u, w, acceleration = run.point_motions
        points = np.arange(len(u))
        self.take("point_displacement", size(u - self.u), points)
        self.take("point_velocity", size(w - self.v), points)
        self.take("point_acceleration", size((0 if first else 1) * acceleration - base), points)
        self.take("point_drift", [abs(u[1, 0] - u[0, 0]) / 1.7], [(1, 0)])

    def see_contacts(self) -> None:
        contacts, corners = self.run.contacts, np.concatenate(self.run.polygons)
        v, e = contacts["vertex"].astype(int), contacts["edge"].astype(int)
        blocks = np.stack([self.owner[v], self.owner[e]], 1)
        depth = np.maximum(0.0, -contacts["gap"])
        self.take("penetration", depth, blocks)
        self.take("penetration_ratio", depth / np.sqrt(self.area[blocks].min(1)), blocks)
        forces = np.hypot(contacts["normal_force"], contacts["shear_force"])
        self.take("contact_force", forces, blocks)
        is_pressed = dict(zip(v[contacts["normal_force"] > 0], e[contacts["normal_force"] > 0],
                           strict=True))  # fmt: skip
        edge_vectors, normal_legs = self.legs(corners)
        normal_legs = normal_legs - self.share[:, None] * edge_vectors
        edge_vectors = edge_vectors / np.linalg.norm(edge_vectors, axis=1)[:, None]
        opening = np.maximum(0.0, cross(normal_legs, edge_vectors) - self.gap)
        opening[[is_pressed.get(a) == b for a, b in self.pairs]] = 0.0
        owners = self.owner[self.pairs]
        self.take("slip", abs((normal_legs * edge_vectors).sum(1)), owners)
        self.take("opening", opening, owners)

    def agree(self, maxima) -> None:
        """Check values, times and names against those of the engine."""
        names = self.run.block_names
        for name, maximum in maxima.items():
            if name not in self.found:
                assert math.isnan(maximum.value), name
                continue
            value, time, owners = self.found[name]
            if name in ("slip", "opening") and value < 1e-7 * SIZE:
                assert value - 1e-7 * SIZE <= maximum.value <= value * (1 + 1e-9), name
                continue
            assert maximum.value == pytest.approx(value, **EQUAL), name
            if value > 1e-9:  # else it is rounding
                assert maximum.time == pytest.approx(time, abs=1e-12), name
                positions = self.run.point_names if name.startswith("point") else names
                assert maximum.blocks + maximum.points == tuple(positions[i] for i in owners), name


def cross(normals, directions):
    """Distance of points to the right of a direction, times the length of the direction."""
    return directions[:, 1] * normals[:, 0] - directions[:, 0] * normals[:, 1]


@pytest.mark.parametrize(
    ("control", "chi"),
    [
        ({}, 0.5),
        ({"integration": "theta", "theta": 0.7}, 0.7),
        ({"integration": "midpoint", "time_step_control": "adaptive"}, 0.5),
    ],
)
def test_maxima_are_those_of_all_steps(write_input, control, chi):
    with sitedda.Simulation(write_input(pile(**control))) as run:
        observer = Observer(run, chi, is_shaken=True)
        while not run.done:
            observer.step()
        assert run.maxima["slip"].value > 1e-3 and run.maxima["opening"].value > 1e-4
        observer.agree(run.maxima)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_the_same_with_impacts_and_from_rest(write_input, restitution):
    groups = changed(pile(settle=True), "joint", restitution=restitution)
    with sitedda.Simulation(write_input(groups)) as run:
        observer = Observer(run, 0.5, is_shaken=True)
        while not run.done:
            observer.step()
        observer.agree(run.maxima)
        assert run.maxima["displacement"].time > 0


def test_an_output_contains_maxima_history_and_residuals(write_input, tmp_path):
    """Sampling does not change the maxima."""
    groups = [*pile(200), group("output", file="pile.nc", history_interval=37)]
    run = sitedda.run(write_input(groups), tmp_path / "pile.nc")
    dense = sitedda.run(write_input(changed(groups, "output", history_interval=1)))
    maxima = {n: maximum for n, maximum in run.maxima.items() if not math.isnan(maximum.value)}
    assert list(set(run.maxima) - set(maxima)) == ["plastic_strain"]  # nothing yields
    assert maxima == {name: dense.maxima[name] for name in maxima}
    history = run.history.largest_so_far
    assert history.dims == ("time", "maximum")
    at = np.searchsorted(dense.history.time, run.history.time)
    np.testing.assert_array_equal(history, dense.history.largest_so_far[at])
    assert np.all(np.diff(history.sel(maximum=list(maxima)), axis=0) >= 0)
    np.testing.assert_array_equal(history[-1], run.history.largest)
    for name, maximum in maxima.items():
        assert maximum.residual <= maximum.value
        assert maximum.time <= run.history.time[-1]
        assert maximum.unit == str(run.history.maximum_unit.sel(maximum=name).values)
    values = run.verdict.values
    assert values["largest_tilt_rad"] == run.maxima["tilt"].value
    assert values["residual_tilt_rad"] == run.maxima["tilt"].residual
    assert values["largest_point_drift"] == run.maxima["point_drift"].value
    tilt = np.deg2rad(1) * np.rad2deg(run.maxima["tilt"].residual)
    last = run.history.isel(frame=-1).block_coordinates.sel(coordinate="rotation")
    assert tilt == pytest.approx(float(abs(last).max()), rel=1e-12)


def test_negligible_final_values_are_shown_as_zero(write_input):
    verdict = sitedda.run(write_input(pile())).verdict
    line = verdict.figures[0]
    assert line.largest == "largest_displacement_m"
    printed_text = verdict.rows()[1][2]
    verdict.values[line.end] = 0.9e-5 * verdict.values[line.largest]
    assert not printed_text.startswith("0 ") and verdict.rows()[1][2] == f"0 {line.unit}"
    verdict.values[line.end] = 1.1e-5 * verdict.values[line.largest]
    assert verdict.rows()[1][2] != f"0 {line.unit}"


# --- Reference of displacements --------------------------------------------------------------


def carried(**control) -> list:
    """A block on a floor with high friction; both follow the motion."""
    return without(pile(friction=80.0, settle=True, **control), "measured_point")


def test_displacements_exclude_the_motion_of_the_base(write_input):
    """The floor moves by millimetres; relative to it, blocks move only by the joint elasticity."""
    omitted = ("tall", "cap", "stone", "beam")
    groups = [group for group in carried() if group[1].get("name") not in omitted]
    assert max(abs(shaken(0.001 * k)[0]) for k in range(121)) > 2e-3
    run = sitedda.run(write_input(groups))
    assert run.maxima["displacement"].value < 1e-5
    assert 0 < run.verdict.values["displacement_from_drawn_m"] < 1e-4
    assert "relative to the moving supports" in " ".join(str(run.verdict).split())


def test_supports_that_move_differently_give_absolute_values(write_input):
    """The verdict states this; with a base of &amplification, values are relative again."""
    groups = changed(pile(), "fixed_point", 1, motion_x=None)
    run = sitedda.run(write_input(groups))
    assert "absolute: supports move differently" in " ".join(str(run.verdict).split())
    name = {"surface": "head", "base": "foot", "lowest": 1.0, "highest": 9.0}
    amplified_run = sitedda.run(write_input([*groups, ("amplification", name)]))
    assert "relative to the point 'foot'" in " ".join(str(amplified_run.verdict).split())
    u = amplified_run.history.displacement
    relative = np.linalg.norm((u - u.sel(point="foot")).values, axis=2).max()
    assert amplified_run.maxima["point_displacement"].value == pytest.approx(relative, **EQUAL)
    a = amplified_run.history.acceleration
    relative = np.linalg.norm((a - a.sel(point="foot")).values, axis=2)[1:].max()
    assert amplified_run.maxima["point_acceleration"].value == pytest.approx(relative, **EQUAL)


@pytest.mark.parametrize("direction", ["x", "xy"])
def test_rollers_along_the_motion_do_not_count_as_supports(write_input, direction):
    """A point fixed only in y does not count for x; a still point fixed in both does."""
    groups = [*pile(), group("fixed_point", block="floor", x=1.0, y=-0.5, direction="y")]
    if direction == "xy":
        groups = changed(groups, "fixed_point", 2, direction=None)
    verdict = " ".join(str(sitedda.run(write_input(groups)).verdict).split())
    assert ("relative to the moving supports" in verdict) == (direction == "x")


def test_on_a_half_space_displacements_are_relative_to_the_outcrop(root, tmp_path):
    """The drift of a record is not a displacement of the model."""
    sitedda.copy_example("ridge", tmp_path)
    run = sitedda.run(tmp_path / "ridge.nml", duration=3.0, output=False)
    history = run.history
    assert history.attrs["maxima_base"] == "relative to the outcrop motion of its base"
    outcrop = 2.0 * history.incoming_displacement.sel(boundary="base").values
    displacement = np.linalg.norm(history.displacement.values - outcrop[:, None], axis=2).max()
    largest = run.verdict.values["largest_point_displacement_m"]
    assert displacement == pytest.approx(largest, rel=1e-3)
    assert displacement < 0.5 * np.linalg.norm(history.displacement.values, axis=2).max()


@pytest.mark.parametrize("name", ["slope", "ridge"])
def test_pictures_and_table_show_the_same_displacements(name, root, tmp_path):
    """Displacements of a scene are relative to the base, like the largest values of the engine."""
    sitedda.copy_example(name, tmp_path)
    run = sitedda.run(tmp_path / f"{name}.nml", duration=1.5, output=False)
    scene = Scene.of(run)
    displacement = np.linalg.norm(scene.displacement(scene.frames - 1), axis=1).max()
    residual = run.verdict.values["residual_displacement_m"]
    assert displacement == pytest.approx(residual, rel=1e-9)
    absolute_scene = Scene.of(run, absolute=True)
    absolute = absolute_scene.displacement(scene.frames - 1)
    assert np.linalg.norm(absolute, axis=1).max() > 2.0 * residual
    assert scene.origin.startswith("relative to the ") and absolute_scene.origin == "absolute"
    assert f"displacements {scene.origin}" in run.draw().texts[-1].get_text().replace("\n", " ")
    assert "displacements absolute" in run.draw(absolute=True).texts[-1].get_text()
    assert _charted(absolute_scene) == pytest.approx(abs(run.history.displacement.values).max(),
                                                     rel=0.02)  # fmt: skip
    displacement = run.history.displacement.values - scene.base_history[:, None]
    assert np.linalg.norm(displacement, axis=2).max() == pytest.approx(
        run.verdict.values["largest_point_displacement_m"], rel=1e-9)  # fmt: skip
    assert 0.0 < _charted(scene) <= abs(displacement).max() * (1 + 1e-6)  # of the first eight
    assert abs(displacement).max() < 0.5 * _charted(absolute_scene)


def _charted(scene: Scene) -> float:
    """The largest displacement in the charts of the view, m."""
    page, largest = view(scene), 0.0
    for chart in page.meta["charts"]:
        for line in chart["lines"] if chart["unit"] == "m" else ():
            stored = zlib.decompress(b64decode(page.streams[line["stream"]]))
            largest = max(largest, abs(np.frombuffer(stored, "<f4")[line["samples"] :]).max())
    return largest


def test_fixed_supports_are_not_mentioned(write_input):
    groups = without(pile(20), "motion")
    for count in (0, 1):
        groups = changed(groups, "fixed_point", count, motion_x=None)
    run = sitedda.run(write_input(groups))
    assert "relative" not in str(run.verdict) and "absolute" not in str(run.verdict)
    assert run.history.attrs["maxima_base"] == "relative to the supports, which do not move"


def test_a_changed_motion_continues_from_the_present_base(write_input):
    """If the motion is scaled to 0, the base stops; its displacement so far remains."""
    groups = carried()
    with sitedda.Simulation(write_input(groups)) as run:
        run.advance(60)
        before = run.maxima
        run.change({"motion.scale": 1e-12})
        run.advance(60)
        floor = run.coordinates[0, 0]
        assert run.maxima["displacement"].residual < before["displacement"].value + 0.1
        assert abs(floor - 1.0) > 1e-3  # the base has moved and does not return
        assert run.maxima["displacement"].residual < 0.5 * abs(floor - 1.0) + 1e-3
        assert run.base_displacement[0] == pytest.approx(floor - 1.0, abs=1e-5)


# --- Closed forms ---------------------------------------------------------------------------------


def test_free_fall(write_input):
    """Velocity g t, displacement g t²/2: exact with the midpoint rule."""
    steps, g = 200, 9.81
    fall = flying_block(steps, integration="midpoint", gravity=[0.0, -g])
    run = sitedda.run(write_input(fall))
    t = steps * 1e-3
    assert run.maxima["velocity"].value == pytest.approx(g * t, rel=1e-12)
    assert run.maxima["displacement"].value == pytest.approx(g * t**2 / 2, rel=1e-12)
    assert run.maxima["acceleration"].value == pytest.approx(g, rel=1e-9)
    assert run.maxima["point_velocity"].value == pytest.approx(g * t, rel=1e-12)
    assert math.isnan(run.maxima["slip"].value) and math.isnan(run.maxima["point_drift"].value)
    assert "largest_slip_m" not in run.verdict.values


def test_a_block_that_slides(write_input):
    """Slip (g_x − μ g_y) t²/2 as maximum and residual, without opening."""
    acceleration, weight, friction = 6.0, 9.81, math.tan(math.radians(20.0))
    blocks = [group("block", name="floor", vertices=rectangle(-2.0, -0.5, 8.0, 0.5)),
              group("block", name="box", vertices=rectangle(0.0, 0.0, 1.0, 0.2))]  # fmt: skip
    fixed_points = [group("fixed_point", block="floor", x=x, y=-0.5) for x in (-2.0, 6.0)]
    groups = [
        group("control", time_step=1e-3, steps=500, gravity=[acceleration, -weight]),
        ("material", ROCK),
        group("joint", name="j", friction_angle=20.0),
        *blocks,
        *fixed_points,
    ]
    run = sitedda.run(write_input(groups))
    slip = (acceleration - friction * weight) * 0.5**2 / 2
    assert run.maxima["slip"].value == pytest.approx(slip, rel=2e-3)
    assert run.maxima["slip"].residual == run.maxima["slip"].value
    assert run.maxima["slip"].blocks == ("box", "floor")
    assert run.maxima["opening"].value < 1e-5
    force = run.maxima["contact_force"]
    assert force.value > 0.5 * 2500 * 0.2 * weight


@pytest.mark.parametrize(("scale", "tilt"), [(0.9, 3.79), (1.0, 5.00), (1.2, 6.80)])
def test_a_rocking_block_without_frames(write_input, scale, tilt):
    """0.5 m × 2 m under two pulses of 3.5 m/s²: no frame contains the largest tilt."""
    support = {"block": "floor", "y": -0.25, "motion_x": "pulses"}
    groups = [
        group("control", time_step=1e-3, duration=2.0, gravity=[0.0, -9.81]),
        ("material", ROCK),
        group("joint", name="j", friction_angle=40.0),
        group("block", name="floor", vertices=rectangle(-2.0, -0.5, 4.0, 0.5)),
        group("block", name="block", vertices=rectangle(-0.25, 0.0, 0.5, 2.0)),
        group("motion", name="pulses", quantity="acceleration", time_step=0.01,
              scale=scale, values=[*20 * [3.5], *20 * [-3.5], *500 * [0.0]]),
        ("fixed_point", support | {"x": -2.0}),
        ("fixed_point", support | {"x": 2.0}),
    ]  # fmt: skip
    run = sitedda.run(write_input(groups))
    assert run.history.sizes["frame"] == 2
    assert math.degrees(run.maxima["tilt"].value) == pytest.approx(tilt, abs=0.02)
    assert run.maxima["tilt"].residual < 0.9 * run.maxima["tilt"].value


# --- Stages ---------------------------------------------------------------------------------------


def excavated(**second) -> list:
    """A block beside others is removed in a static stage, after 20 ms without load."""
    return [
        *without(pile(0), "motion")[:-5],
        *(group("fixed_point", block="floor", x=x, y=-0.5) for x in (-3.0, 5.0)),
        group("measured_point", name="foot", block="wide", x=0.5, y=0.1),
        group("measured_point", name="head", block="cap", x=0.5, y=1.8),
        group("stage", name="rest", kind="static"),
        group("stage", name="calm", duration=0.02),
        group("stage", name="dig", **second),
    ]  # fmt: skip


def test_only_the_equilibrium_of_a_static_stage_counts(write_input):
    """The cap is removed: the blocks below rise; velocities of static steps do not count."""
    calm_run = sitedda.run(write_input(excavated(kind="static")))
    excavated_run = sitedda.run(write_input(excavated(kind="static", remove="cap")))
    last = excavated_run.history.isel(frame=-1).block_coordinates
    first = excavated_run.history.isel(frame=0).block_coordinates
    displacement = np.linalg.norm((last - first).values[:, :2], axis=1)
    names = list(excavated_run.history.block.values)
    displacement[names.index("cap")] = 0.0  # removed
    maxima, calm_maxima = excavated_run.maxima, calm_run.maxima
    assert maxima["displacement"].value == pytest.approx(displacement.max(), rel=1e-9)
    assert maxima["displacement"].blocks == (names[int(displacement.argmax())],)
    assert maxima["displacement"].value > 10 * calm_maxima["displacement"].value
    assert maxima["velocity"] == calm_maxima["velocity"]
    force = calm_maxima["contact_force"].value
    assert maxima["contact_force"].value == pytest.approx(force, rel=1e-6)


def test_points_restart_where_displacements_are_set_to_zero(write_input):
    groups = pile(0, friction=80.0)[:-1]
    second = {"name": "two", "duration": 0.06, "zero_displacements": True}
    groups += [group("stage", name="one", duration=0.06), ("stage", second)]
    history = sitedda.run(write_input(groups)).history
    so_far = history.largest_so_far.sel(maximum=["point_displacement", "displacement"]).values
    zero = int(np.argmax(history.stage.values == 2))
    assert np.all(np.diff(so_far[:, 1]) >= 0)
    assert so_far[zero, 0] < so_far[zero - 1, 0]
    start_time, base = history.time.values[zero - 1], shaken
    u = history.displacement.values[zero:, :, :]
    displacement = np.array([base(t)[0] - base(start_time)[0] for t in history.time.values[zero:]])
    u[:, :, 0] -= displacement[:, None]
    assert so_far[-1, 0] == pytest.approx(np.linalg.norm(u, axis=2).max(), rel=1e-9)


# --- Resumed, and on any number of threads --------------------------------------------------------


def test_a_resumed_run_has_the_same_maxima(write_input, tmp_path, same_bits):
    groups = pile(0)
    groups += [group("stage", name="rest", kind="static"),
               group("stage", name="one", duration=0.12),
               group("stage", name="again", kind="static"),
               group("stage", name="two", duration=0.05)]  # fmt: skip
    file = write_input(groups)
    reference = sitedda.run(file, tmp_path / "whole.nc")
    for steps in (1, 57, 119, 140):
        with sitedda.Simulation(file, tmp_path / f"{steps}.nc") as run:
            run.advance(steps)
            run.maxima  # noqa: B018  looking changes nothing
        resumed_run = sitedda.resume(file, tmp_path / f"{steps}.nc")
        same_bits(reference.history, resumed_run.history)
        # Texts, because NaN differs from NaN.
        assert repr(resumed_run.maxima) == repr(reference.maxima)


def wide_wall(count: int) -> list:
    """Pairs of equal blocks on a shaken floor: several blocks share each maximum."""
    support = {"block": "floor", "y": -0.5, "motion_x": "shake"}
    blocks = [group("block", name=f"b{i}", vertices=rectangle(2.0 * i, 0.0, 0.5, 1.5))
              for i in range(count)]  # fmt: skip
    floor = rectangle(-3.0, -0.5, 2.0 * count + 6.0, 0.5)
    return [
        group("control", time_step=2e-3, steps=40, gravity=[0.0, -9.81]),
        ("material", ROCK | {"young_modulus": 1e9}),
        group("joint", name="j", friction_angle=30.0),
        group("block", name="floor", vertices=floor),
        *blocks,
        group("motion", name="shake", quantity="acceleration", drift_order=0, time_step=EVERY,
              values=[2 * a for a in SHAKE]),
        ("fixed_point", support | {"x": -3.0}),
        ("fixed_point", support | {"x": 2.0 * count + 3.0}),
    ]  # fmt: skip


def test_threads_change_no_maximum(binary, write_input, tmp_path, same_bits):
    """The number of blocks and contacts exceeds a chunk of a parallel loop."""
    file = write_input(wide_wall(2100))
    files = [tmp_path / f"{threads}.nc" for threads in (1, 2, 3)]
    for threads, output in enumerate(files, 1):
        binary.ok("run", file, "-q", "-o", output, threads=threads)
    with xr.open_dataset(files[0]) as data:
        assert np.all(np.isfinite(data.largest.values[:10]))
    for other in files[1:]:
        same_bits(files[0], other)


# --- Output of programs and studies --------------------------------------------------------------


def test_the_executable_prints_maxima(binary, write_input, tmp_path):
    file = write_input(pile(60))
    process = binary("run", file, "-q", "-o", tmp_path / "n.nc")
    run = sitedda.run(file)
    paragraphs = str(run.verdict).split("\n\n")
    assert len(paragraphs) == 5  # sentence, check, table, warning, counts
    assert paragraphs[1].startswith("doubt  check: ") and "doubt  check: " not in paragraphs[3]
    for row in paragraphs[2].splitlines()[1:]:
        if row.startswith("PGA"):  # from samples, which the executable does not keep
            break
        assert row in process.stdout.splitlines()
    assert all(paragraphs[part] in process.stdout for part in (0, 1, 3, 4))
    assert max(map(len, str(run.verdict).splitlines())) <= 80


def test_a_study_has_largest_and_residual(write_input, tmp_path):
    file = write_input(pile(60))
    names = ["largest_tilt_rad", "residual_tilt_rad", "largest_contact_force_n_m",
             "largest_so_far[tilt].max"]  # fmt: skip
    table = sitedda.study(file, {"joint[*].friction_angle": [10.0, 30.0]}, names,
                          folder=tmp_path / "study", workers=1)  # fmt: skip
    for angle in (10.0, 30.0):
        run = sitedda.run(file, changes={"joint[j].friction_angle": angle})
        row = table.sel(friction_angle=angle)
        assert float(row.largest_tilt_rad) == run.maxima["tilt"].value
        assert float(row.residual_tilt_rad) == run.maxima["tilt"].residual
        assert float(row["largest_so_far[tilt].max"]) == run.maxima["tilt"].value
        assert str(row.warning.values).splitlines()[-1].startswith("start: gravity acted suddenly")
