# SPDX-License-Identifier: GPL-3.0-or-later
"""Water flow in joints: closed forms, energy, vapour and air."""

import numpy as np
import pytest
from scipy.optimize import brentq

import sitedda
from sitedda import InputError

APERTURE, STIFFNESS, BULK, VISCOSITY = 2e-4, 1e10, 2.2e9, 1e-3
#: m²/s, of a joint with storage by its stiffness and the compressibility of water
DIFFUSIVITY = APERTURE**3 / (12 * VISCOSITY) / (1 / STIFFNESS + APERTURE / BULK)
SHARE = (1 / STIFFNESS) / (1 / STIFFNESS + APERTURE / BULK)  #: of a load, carried by the water

STIFF = {
    "law": "mohr_coulomb", "normal_stiffness_per_area": STIFFNESS,
    "shear_stiffness_per_area": STIFFNESS,
}  # fmt: skip

CONSTANT = {"aperture": APERTURE, "opening_factor": 0.0}


def started(time_step: float, **control) -> sitedda.Model:
    """Return a model of light, stiff blocks without gravity."""
    model = sitedda.Model("water in joints", time_step=time_step, **control)
    model.material("rock", density=100.0, young_modulus=1e14, poisson_ratio=0.0)
    model.joint("joint", friction_angle=0.0, contact_points=3, **STIFF)
    return model


def box(model, name: str, left, low, right, high, is_fixed=True, **options):
    """Add a rectangle; two of its points are fixed if `is_fixed`."""
    model.block([left, low, right, low, right, high, left, high], name=name, **options)
    for x in (left + 0.1, right - 0.1) if is_fixed else ():
        model.fixed_point(x, (low + high) / 2, name)


def rigid(length: float, *segments: tuple[float, str], **control) -> sitedda.Model:
    """Return two fixed slabs; the lower one may be divided into pieces (width, joint)."""
    model = started(**({"time_step": 0.01, "steps": 2} | control))
    left = 0.0
    for i, (width, joint) in enumerate(segments or ((length, "joint"),)):
        box(model, f"low{i}", left, -1, left + width, 0, joint=joint)
        left += width
    box(model, "top", 0, 0, length, 1)
    return model


def data_of(model: sitedda.Model):
    """Run a model and return its output."""
    run = sitedda.run(model)
    assert run.complete, run.summary
    assert "water table" not in run.summary
    return run.history.load()


def at(data, x: float, y: float = 0.0):
    """Return the pressure over time at a place, Pa."""
    positions = data.flow_node_place.values
    return data.flow_pressure.values[:, np.argmin(abs(positions - (x, y)).sum(1))]


@pytest.mark.parametrize("aperture", [1e-4, 2e-4, 5e-4, 1e-3])
def test_cubic_law(aperture):
    model = rigid(4.0)
    model.flow(aperture=aperture, opening_factor=0.0, state="steady", channel_length=0.7)
    model.flow_boundary(side="left", head=14.0)
    model.flow_boundary(side="right", head=10.0)
    data = data_of(model)
    exact = aperture**3 * 9810 / (12 * VISCOSITY)
    ends = data.flow_node_place.values[data.flow_channel_node.values, 0]
    flux = data.flow_flux.values[-1] * np.sign(ends[:, 1] - ends[:, 0])
    assert flux == pytest.approx(exact, rel=1e-6)
    inflow = data.flow_inflow.values[-1]
    assert abs(inflow.sum()) < 1e-12 * exact and inflow.max() == pytest.approx(exact, rel=1e-6)
    assert at(data, 2.0)[-1] == pytest.approx(12 * 9810, rel=1e-9)


def test_apertures_in_series():
    model = rigid(5.0, (2.0, "fine"), (3.0, "coarse"))
    for name, aperture in (("fine", 1e-4), ("coarse", 2e-4)):
        model.joint(name, friction_angle=0.0)
        steady = {"state": "steady"} if name == "fine" else {}
        model.flow(joints=name, aperture=aperture, opening_factor=0.0, **steady)
    model.flow_boundary(along=[0, -0.1, 0, 0.1], head=15.0)
    model.flow_boundary(along=[5, -0.1, 5, 0.1], head=10.0)
    data = data_of(model)
    hydraulic_aperture = (data.flow_inflow.values[-1].max() * 12 * VISCOSITY / 9810) ** (1 / 3)
    assert hydraulic_aperture == pytest.approx((5 / (2 / 1e-12 + 3 / 8e-12)) ** (1 / 3), rel=1e-6)
    assert hydraulic_aperture == pytest.approx(1.28165e-4, rel=1e-5)


@pytest.mark.parametrize("apertures", [(1e-4, 0.05), (1e-6, 0.1), (1e-7, 0.05), (1e-9, 0.05)])
@pytest.mark.parametrize("fine_is_inside", [False, True])
def test_series_of_very_different_apertures(apertures, fine_is_inside):
    """The flow is that of the series, up to a ratio of conductances of 1e23, and it balances."""
    inner, outer = ("fine", "coarse") if fine_is_inside else ("coarse", "fine")
    model = rigid(7.0, (2.0, outer), (3.0, inner), (2.0, outer))
    for name, aperture in zip(("fine", "coarse"), apertures, strict=True):
        model.joint(name, friction_angle=0.0)
        steady = {"state": "steady"} if name == "fine" else {}
        model.flow(joints=name, aperture=aperture, opening_factor=0.0, **steady)
    model.flow_boundary(side="left", head=15.0)
    model.flow_boundary(side="right", head=10.0)
    data = data_of(model)
    of = dict(zip(("fine", "coarse"), apertures, strict=True))
    exact = 9810 * 5 / (12 * VISCOSITY) / (4 / of[outer] ** 3 + 3 / of[inner] ** 3)
    inflow = data.flow_inflow.values[-1]
    assert (inflow.max(), inflow.min()) == pytest.approx((exact, -exact), rel=1e-6)
    assert abs(inflow.sum()) < 1e-8 * exact


def test_parallel_joints_with_different_apertures_and_bypass():
    """A coarse loop hangs on fine joints: its heads differ by 1e-15, and flow still balances."""
    model = started(0.01, steps=2)
    for name, aperture in (("joint", 1e-7), ("wide", 0.05)):
        if name == "wide":
            model.joint(name, friction_angle=0.0)
        steady = {"state": "steady"} if name == "joint" else {}
        model.flow(joints=name, aperture=aperture, opening_factor=0.0, **steady)
    for i in range(3):
        box(model, f"low{i}", 2 * i, -1, 2 * i + 2, 0, joint="wide" if i == 1 else "joint")
    box(model, "left", 0, 0, 2, 1)
    box(model, "middle", 2, 0, 4, 1, joint="wide")
    box(model, "right", 4, 0, 6, 1)
    box(model, "top", 0, 1, 6, 2, joint="wide")
    model.flow_boundary(along=[0, -0.1, 0, 0.1], head=5.0)
    model.flow_boundary(along=[6, -0.1, 6, 0.1], head=3.0)
    data = data_of(model)
    exact = 9810 * 2 / (12 * VISCOSITY) / (2 * 2 / 1e-7**3)
    inflow, flux = data.flow_inflow.values[-1], data.flow_flux.values[-1]
    assert (inflow.max(), inflow.min()) == pytest.approx((exact, -exact), rel=1e-6)
    surplus = inflow.copy()
    np.subtract.at(surplus, data.flow_channel_node.values[:, 0], flux)
    np.add.at(surplus, data.flow_channel_node.values[:, 1], flux)
    assert abs(surplus).max() < 1e-9 * exact


@pytest.mark.parametrize("layers", [1, 4])
def test_undrained_share_of_a_load(layers):
    """The ratio is that of Skempton, also in each joint of a column."""
    model = started(1e-3)
    for i in range(layers + 1):
        box(model, f"b{i}", 0, i, 2, i + 1, is_fixed=i == 0)
    model.traction(side="top", normal=1e5)
    model.flow(aperture=APERTURE, state_at_rest="undrained")
    model.stage("loaded", kind="static")
    model.stage("after", duration=1e-3)
    data = data_of(model)
    assert data.flow_pressure.values[-1] == pytest.approx(1e5 * SHARE, rel=1e-6)


def pressed(moves: bool) -> sitedda.Model:
    """Three blocks meet at a wet node; a distant stone may fall in the static stage."""
    model = started(1e-3, gravity=(0, -10))
    box(model, "base", -1, -1, 12, 0)
    for left in (0, 2):
        box(model, f"b{left}", left, 0, left + 2, 1, is_fixed=False)
    if moves:
        box(model, "stone", 8, 0.2, 9, 1.2, is_fixed=False)
    model.load(1.5, 0.5, "b0", name="push", time=[0, 1], force_x=[0, 0], force_y=[-1e5] * 2)
    model.flow(aperture=APERTURE)
    model.stage("rest", kind="static")
    model.stage("pressed", duration=0.02, loads="push")
    return model


def test_water_couples_blocks_after_contacts_were_searched_at_rest():
    resting_data, moved_data = (data_of(pressed(moves)) for moves in (False, True))
    assert moved_data.flow_pressure.values[-1] == pytest.approx(
        resting_data.flow_pressure.values[-1], rel=1e-3
    )
    assert abs(resting_data.flow_pressure.values).max() > 1e4


def columns(count: int, length: float, **control) -> sitedda.Model:
    """Stiff columns side by side on a fixed slab: one-dimensional consolidation of a joint."""
    model = started(**({"integration": "backward_euler", "dynamic_factor": 0.0} | control))
    model.joint("smooth", friction_angle=0.0)
    box(model, "slab", 0, -1, length, 0)
    width = length / count
    for i in range(count):
        box(model, f"c{i}", i * width, 0, (i + 1) * width, 1, is_fixed=False, joint="smooth")
    return model


def series(time: float, position: float) -> float:
    """Terzaghi's isochrone: pressure over the initial one at a time factor; no flow at 1."""
    eigenvalues = (2 * np.arange(400) + 1) * np.pi / 2
    return float(
        np.sum(2 / eigenvalues * np.sin(eigenvalues * position) * np.exp(-(eigenvalues**2) * time))
    )


def test_consolidation_of_a_joint():
    length, count, steps, factor = 10.0, 40, 160, 0.2
    duration = factor * length**2 / DIFFUSIVITY
    model = columns(count, length, time_step=duration / steps, steps=steps)
    model.traction(side="top", normal=1e5)
    model.flow(joints="joint", state="transient", pressure=1e5, **CONSTANT)
    model.flow_boundary(along=[0, -0.1, 0, 0.1], pressure=0.0)
    data = data_of(model)
    exact = [series(factor, x / length) for x in np.linspace(0, length, count + 1)]
    pressures = [at(data, x)[-1] / 1e5 for x in np.linspace(0, length, count + 1)]
    assert pressures == pytest.approx(exact, abs=1e-3)
    degree = 1 - np.mean([series(factor, x) for x in np.linspace(0, 1, 2001)])
    assert 1 - np.trapezoid(pressures, dx=1 / count) == pytest.approx(degree, abs=1e-3)


def stored_in_water(length: float, **control) -> sitedda.Model:
    """Rigid slabs with a bulk modulus that yields DIFFUSIVITY."""
    model = rigid(length, integration="backward_euler", **control)
    bulk = DIFFUSIVITY * 12 * VISCOSITY / APERTURE**2
    model.flow(state="transient", channel_length=length / 160, bulk_modulus=bulk, **CONSTANT)
    return model


def test_harmonic_head():
    """Amplitude e^(-x/δ), phase lag x/δ, δ = sqrt(2c/ω) = 1.4561 m at 1 Hz."""
    depth = np.sqrt(2 * DIFFUSIVITY / (2 * np.pi))
    assert depth == pytest.approx(1.4561, abs=1e-4)
    error = []
    for steps in (200, 400):
        model = stored_in_water(12.0, time_step=1 / steps, steps=5 * steps)
        time = np.arange(0, 5, 1 / 400)
        model.flow_boundary(side="left", time=time, pressure=1e4 * np.sin(2 * np.pi * time))
        data = data_of(model)
        position = min(data.flow_node_place.values[:, 0], key=lambda x: abs(x - 3.0))
        wave = at(data, 3.0)[-steps:] / 1e4
        time = data.time.values[-steps:]  # after this time the transient is smooth
        phase = 2 * np.pi * time
        parts = np.stack([np.sin(phase), np.cos(phase), 1 + 0 * time, time, time**2], axis=1)
        sine, cosine = np.linalg.lstsq(parts, wave, rcond=None)[0][:2]
        amplitude = cosine - 1j * sine
        exact = -1j * np.exp(-(1 + 1j) * position / depth)
        error.append(amplitude / exact - 1)
    assert abs(error[1]) < 0.03 and abs(error[0] / error[1]) == pytest.approx(2, abs=0.2)
    assert abs(2 * error[1] - error[0]) < 1e-3  # first order in Δt


def test_filling_front():
    """Filled length sqrt(a² Δp t/6μ): 0.8165 m after 1 s, 1.6330 m after 4 s."""
    model = rigid(2.0, time_step=0.01, steps=400)
    model.flow(state="transient", channel_length=0.02, saturation=0.0, **CONSTANT)
    model.flow_boundary(side="left", pressure=1e5)
    data = data_of(model)
    is_inner = abs(data.flow_node_place.values[:, 0] - 1.0) < 0.999
    filled = data.flow_saturation.values @ np.where(is_inner, 0.02, 0.01)
    for time, exact in ((1.0, 0.8165), (4.0, 1.6330)):
        i = np.argmin(abs(data.time.values - time))
        assert filled[i] == pytest.approx(exact, abs=1e-4)
    assert data.flow_pressure.values.min() > -1e-6
    inflow = 0.01 * data.flow_inflow.values[1:].sum()  # the mouth is full initially
    assert inflow == pytest.approx(filled[-1] * APERTURE - 0.01 * APERTURE, rel=1e-4)


def rocking(
    time_step: float, duration: float = 0.25, force: float = 1.5e5, all_samples=False, **flow
) -> sitedda.Model:
    """A heavy block on a wet joint that is pushed at its top."""
    model = sitedda.Model("rocking", time_step=time_step, gravity=(0, -9.81))
    model.material("rock", density=2500.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("joint", friction_angle=35.0, **STIFF)
    box(model, "base", -2, -1, 6, 0)
    box(model, "dam", 0, 0, 4, 6, is_fixed=False)
    time = np.linspace(0, duration, 201)
    model.load(2, 5, "dam", time=time, force_x=force * np.sin(2 * np.pi * time / duration))
    model.measured_point("top", x=2, y=5.9, block="dam")
    model.measured_point("toe", x=3.9, y=0.1, block="dam")
    if all_samples:
        model.output(history_seconds=1e-3)
    model.flow(**({"aperture": 1e-3, "channel_length": 1.0} | flow))
    model.flow_boundary(along=[0, -0.1, 0, 0.1], head=3.0)
    model.flow_boundary(along=[4, -0.1, 4, 0.1], pressure=0.0)
    model.stage("rest", kind="static")
    model.stage("shaken", duration=duration)
    return model


@pytest.mark.parametrize("state", ["steady", "transient"])
def test_a_rocking_dam_converges_with_the_time_step(state):
    """Motion and pressure are equal with a tenth of the step, which has an error below 0.1 %."""
    coarse, fine = (data_of(rocking(step, state=state, all_samples=True)) for step in (2e-5, 2e-6))
    for name in ("displacement", "flow_pressure"):
        error = abs(fine[name].values - coarse[name].values).max() / abs(fine[name].values).max()
        assert error < 0.01, name


@pytest.mark.parametrize("integration", ["dda", "midpoint", "theta", "backward_euler"])
@pytest.mark.parametrize("time_step", [1e-5, 1e-3, 1e-1])
def test_energy_balance_of_each_step_and_scheme(integration, time_step):
    model = rocking(time_step, duration=40 * time_step, state="transient")
    model.control(integration=integration)
    data = data_of(model)
    terms = ("input", "flow", "water", "kinetic", "contact", "gravity")
    scale = max(abs(data[f"energy_{name}"].values).max() for name in terms)
    assert abs(data.energy_balance.values).max() < 1e-9 * scale
    assert (np.diff(data.energy_flow.values) >= -1e-12 * scale).all()


@pytest.mark.parametrize("is_static", [True, False])
@pytest.mark.parametrize("inflow", [1e-6, 5e-6, 2e-5])
def test_a_given_inflow_lifts_a_block_to_its_steady_state(inflow, is_static):
    """q/2 = a³ p/(24 μ) with a = a₀ − (σ − p/2)/k: pressure p in the middle, 0 at both ends.

    The pressure falls with the cube of the aperture that it widens, more than one to one.
    """
    stiffness, load = 1e9, 1.5e5
    model = started(1e-2, integration="backward_euler")
    joint = model["joint"][0]
    joint(normal_stiffness_per_area=stiffness, shear_stiffness_per_area=stiffness,
          friction_angle=30.0)  # fmt: skip
    model.material("heavy", density=2500.0, young_modulus=1e14, poisson_ratio=0.0)
    box(model, "low", 0, -1, 4, 0)
    box(model, "high", 0, 0, 4, 1, is_fixed=False, material="heavy")
    model.traction(side="top", normal=load)
    model.flow(aperture=APERTURE, residual_aperture=1e-6, state="steady", channel_length=2.0)
    for x in (0, 4):
        model.flow_boundary(along=[x, -0.1, x, 0.1], pressure=0.0)
    model.flow_boundary(along=[2, -0.1, 2, 0.1], inflow=inflow)
    if is_static:
        model.stage("rest", kind="static")
    model.stage("after", duration=1e-2 if is_static else 4.0)

    def surplus(pressure):
        aperture = APERTURE - (load - pressure / 2) / stiffness
        return aperture**3 * pressure / (24 * VISCOSITY) - inflow / 2

    exact = brentq(surplus, 0.0, 1e9, xtol=1e-3)
    assert at(data_of(model), 2.0)[-1] == pytest.approx(exact, rel=3e-3)


def test_vapour_forms_and_collapses():
    """A block on springs is pulled up quasi-statically and released; vapour keeps p_v."""
    model = started(1e-3, steps=400, dynamic_factor=0.0)
    box(model, "base", 0, -1, 2, 0)
    box(model, "top", 0, 0, 2, 1, is_fixed=False)
    model.boundary(kind="springs", side="top", stiffness_per_area=1e9)
    time = np.linspace(0, 0.4, 81)
    tension = 6e5 * np.sin(np.pi * time / 0.4) ** 2 - 1e5
    for x in (0.5, 1.5):
        model.load(x, 0.5, "top", time=time, force_x=0 * time, force_y=tension / 2)
    model.flow(aperture=APERTURE, state="undrained", pressure=2e4)
    data = data_of(model)
    pressure, saturation = data.flow_pressure.values, data.flow_saturation.values
    assert pressure.min() == pytest.approx(-1e5, rel=1e-12)
    uplift = (5e5 - 2e5) / 2e9  # pull less the suction of vapour, over the springs
    water_elongation = 2e5 / 2 / BULK * APERTURE  # elongation of the water
    assert saturation.min() == pytest.approx(APERTURE / (APERTURE + uplift),
                                             rel=5e-3), (water_elongation)  # fmt: skip
    assert (saturation[-1] == 1).all() and (saturation[pressure > -1e5 + 1] == 1).all()
    assert pressure.max() < 1.2e5  # at most push plus initial pressure


def test_the_coupled_step_is_stable_where_staggered_steps_diverge():
    """A sudden load on a light block on enclosed water, ωΔt = 330: at most twice the settlement."""
    step, load, mass = 1e-3, 1e5, 200.0
    spring = 2 * (BULK / APERTURE + STIFFNESS)  # of water and joint over 2 m
    model = started(step, steps=200, integration="midpoint")
    box(model, "base", 0, -1, 2, 0)
    box(model, "top", 0, 0, 2, 1, is_fixed=False)
    for x in (0.2, 1.8):
        model.load(x, 0.5, "top", time=[0, 1], force_x=[0, 0], force_y=[-load / 2] * 2)
    model.flow(aperture=APERTURE)
    data = data_of(model)
    assert 0.9 * load / 2 < data.flow_pressure.values.max() < 2.01 * load / 2
    sag = velocity = largest = 0.0
    for _ in range(20):  # pressure of the previous opening, then motion
        velocity += step * (load - spring * sag) / mass
        sag += step * velocity
        largest = max(largest, abs(sag))
    assert largest > 1e6 * load / spring


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ("&flow_boundary side = 'top', head = 1 /", "no node of a joint with water"),
        ("&flow_boundary side = 'left' /", "head"),
        ("&flow_boundary head = 1 /", "give `side` or `along`"),
        ("&flow aperture = 1e-4 /", "another group &flow"),
        ("&water surface = 0, 0, 4, 0 /", "acts_on = 'faces'"),
    ],
)
def test_invalid_input_of_flow_is_refused(changes, message):
    model = rigid(4.0)
    model.flow(aperture=1e-4)
    with pytest.raises(InputError, match=message):
        sitedda.Simulation(sitedda.Model.from_namelist(model.to_namelist() + changes + "\n"))


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ("&flow_boundary side = 'right', inflow = 1e-5 /", "needs a head or pressure at another"),
        (
            "&flow_boundary side = 'left', head = 5 /\n&flow_boundary side = 'left', head = 9 /",
            r"&flow_boundary .line 1\d.: the node at \(0, 0\) has the pressure 88290 Pa, but 49050",
        ),
        (
            "&flow_boundary side = 'left', head = 5, 6, time = 0, 1 /\n"
            "&flow_boundary side = 'left', head = 5, 5, time = 0, 1 /",
            "pressure 49050 Pa, but 58860",
        ),
        (
            "&flow_boundary side = 'left', head = 5 /\n&traction side = 'left', level = 4 /",
            "&traction .*pressure 39240 Pa, but 49050",
        ),
        (
            "&flow_boundary side = 'left', head = 5 /\n&flow_boundary side = 'left', inflow = 1 /",
            "an inflow at .* cannot be prescribed",
        ),
        ("&traction side = 'left', level = 4, unit_weight = 13000 /", "13000 differs from 9810"),
        ("&flow_boundary side = 'left', pressure = -5e6 /", "below the least pressure"),
    ],
)
def test_contradictions_of_water_are_refused(groups, message):
    model = rigid(4.0)
    model.flow(aperture=1e-4, state="steady")
    with pytest.raises(InputError, match=message):
        sitedda.Simulation(sitedda.Model.from_namelist(model.to_namelist() + groups + "\n"))


def test_equal_and_dry_boundaries_do_not_contradict():
    """Two groups with one head, and an inflow at a node above a head."""
    model = rigid(4.0)
    model.flow(aperture=1e-4, state="steady")
    model.flow_boundary(side="left", head=5.0)
    model.traction(side="left", level=5.0)
    model.flow_boundary(side="right", head=-1.0)
    model.flow_boundary(side="right", inflow=1e-9)
    assert sitedda.run(model).complete


def test_two_fluids_in_connected_joints_are_refused():
    model = started(0.01, steps=2)
    model.joint("upright", friction_angle=0.0)
    box(model, "low", 0, 0, 2, 5)
    box(model, "high", 0, 5, 2, 10, joint="upright")
    box(model, "right", 2, 0, 4, 10)
    model.flow(joints="joint", aperture=3e-4)
    model.flow(joints="upright", aperture=3e-4, unit_weight=2e4)
    with pytest.raises(InputError, match="20000 differs from 9810 of connected joints"):
        sitedda.Simulation(model)


@pytest.mark.parametrize("state", [{"pressure": -5e6}, {"state_at_rest": "transient"}])
def test_impossible_states_of_water_are_refused(state):
    """A pressure below that of vapour; flow in time while time does not advance."""
    model = rigid(4.0)
    model.flow(aperture=1e-4, **state)
    with pytest.raises(InputError, match=next(iter(state))):
        sitedda.Simulation(model)


@pytest.mark.parametrize("fraction", [0.99, 1.01])
def test_a_well_yields_at_most_the_flow_to_it(fraction):
    """Without suction 2 m of head over 4 m drive γ a³/(12 μ)/2.

    A prescribed inflow changes the pressure gradually, in some ten steps.
    """
    model = rigid(4.0, steps=40)
    model.flow(state="steady", **CONSTANT)
    model.flow_boundary(side="left", head=2.0)
    most = APERTURE**3 * 9810 / (12 * VISCOSITY) / 2
    model.flow_boundary(side="right", inflow=-fraction * most)
    if fraction > 1:
        with pytest.raises(InputError, match=r"prescribed at \(4, 0\) exceeds what flows"):
            sitedda.run(model)
    else:
        assert at(data_of(model), 4.0)[-1] == pytest.approx(0.01 * 2 * 9810, rel=1e-6)


def test_an_inflow_without_outlet_after_an_excavation_is_refused():
    model = started(0.01)
    box(model, "low", 0, -1, 4, 0)
    for i in range(2):
        box(model, f"top{i}", 2 * i, 0, 2 * i + 2, 1)
    model.flow(**CONSTANT)
    model.flow_boundary(along=[0, -0.1, 0, 0.1], inflow=1e-6)
    model.flow_boundary(side="right", head=1.0)
    model.stage("before", kind="static")
    model.stage("dug", kind="static", remove="top1")
    with pytest.raises(InputError, match=r"'dug' .* none acts beside \(0, 0\)"):
        sitedda.run(model)


def upstream_face(state: str, level, time=()) -> sitedda.Model:
    """Joints at 2, 6 and 9 m reach a face under water, and a crack behind it; a drain at 2 m."""
    model = started(0.01, steps=20)
    heights = (0, 2, 6, 9, 12)
    for i in range(4):
        box(model, f"a{i}", 0, heights[i], 3, heights[i + 1])
    box(model, "r0", 3, 0, 5, 2)
    box(model, "r1", 3, 2, 5, 12)
    model.flow(aperture=3e-4, opening_factor=0.0, state=state)
    model.traction(side="left", level=level, **({"time": time} if time else {}))
    model.flow_boundary(side="right", head=2.0)
    return model


@pytest.mark.parametrize("state", ["steady", "transient"])
def test_no_water_enters_from_the_air(state):
    """Only the submerged joint supplies water: head 4 to 2 m over 5 m."""
    data = data_of(upstream_face(state, 4.0))
    conductivity = 3e-4**3 * 9810 / (12 * VISCOSITY)
    inflow = data.flow_inflow.values[-1]
    height = data.flow_node_place.values[:, 1]
    if state == "steady":
        assert inflow.max() == pytest.approx(0.4 * conductivity, rel=1e-6)
        assert inflow.min() == pytest.approx(-0.4 * conductivity, rel=1e-6)
        assert at(data, 3.0, 2.0)[-1] == pytest.approx(0.8 * 9810, rel=1e-6)
    assert (inflow[height > 4] <= 0).all()


def test_a_face_seeps_after_a_drawdown():
    """Steady flow from 11 m at the crack to a face that is dry above 3 m: the joint discharges."""
    model = upstream_face("steady", [11.0, 3.0, 3.0], [0.0, 0.1, 1.0])
    model.flow_boundary(along=[3, 11.9, 3, 12.1], pressure=5e4)
    data = data_of(model)
    inflow, place = data.flow_inflow.values[-1], data.flow_node_place.values
    node = np.argmin(abs(place - (0, 9)).sum(1))
    # From the crack at 12 m, φ = 17.1 m: 3 m down to the joint at 9 m, which leads 3 m to the air.
    assert inflow[node] < 0 and at(data, 0.0, 9.0)[-1] == 0
    assert (inflow[(place[:, 0] == 0) & (place[:, 1] > 3)] <= 0).all()
    assert abs(inflow.sum()) < 1e-12 * inflow.max()


@pytest.mark.parametrize("level", [-50.0, 0.5])
def test_air_does_not_fill_joints(level):
    """A joint that is full to its lowest outlet stays full; nothing flows."""
    model = started(0.01, steps=2)
    box(model, "a", 0, 0, 2, 3)
    box(model, "b", 0, 3, 2, 8)
    box(model, "c", 2, 0, 4, 1)
    box(model, "d", 2, 1, 4, 8)
    model.flow(aperture=3e-4, opening_factor=0.0, state="steady")
    for side in ("left", "right"):
        model.flow_boundary(side=side, head=level)
    data = data_of(model)
    assert abs(data.flow_inflow.values).max() < 1e-12
    head = np.maximum(0.0, 1.0 - data.flow_node_place.values[:, 1])
    assert data.flow_pressure.values[-1] == pytest.approx(9810 * head, abs=1e-6)


def test_a_dry_joint_open_at_its_top_stays_dry():
    model = started(1.0, steps=60, integration="backward_euler")
    box(model, "a", 0, 0, 2, 8)
    box(model, "b", 2, 0, 4, 8)
    model.flow(aperture=3e-4, opening_factor=0.0, state="transient", saturation=0.0,
               channel_length=0.5)  # fmt: skip
    model.flow_boundary(side="top", head=0.0)
    data = data_of(model)
    assert abs(data.flow_inflow.values).max() == 0.0
    assert abs(data.flow_saturation.values[-1]).max() == 0.0


def test_a_joint_drains_only_its_own_water():
    """A full joint dips to a drain; air enters at its open top, and its volume flows out."""
    model = started(0.5, steps=500, integration="backward_euler")
    box(model, "a", 0, 0, 2, 8)
    box(model, "b", 2, 0, 4, 8)
    model.flow(state="transient", channel_length=0.25, cavitation_pressure=0.0, **CONSTANT)
    model.flow_boundary(side="top", head=-1.0)
    model.flow_boundary(along=[1.9, 0, 2.1, 0], pressure=0.0)
    data = data_of(model)
    drained = -0.5 * np.cumsum(data.flow_inflow.values[1:].sum(1))
    volume = 8 * APERTURE
    stored = data.flow_saturation.values @ np.where(
        abs(data.flow_node_place.values[:, 1] - 4) < 3.99, 0.25, 0.125) * APERTURE  # fmt: skip
    assert (data.flow_inflow.values[:, data.flow_node_place.values[:, 1] == 8] <= 0).all()
    assert drained + stored[1:] == pytest.approx(volume, rel=0.02)
    assert drained[-1] > 0.5 * volume


def test_a_resumed_run_is_bit_identical(tmp_path):
    """The run is resumed during flow, with vapour."""
    model = rocking(1e-3, force=3e5, state="transient")
    reference = data_of(model)
    with sitedda.Simulation(model, tmp_path / "half.nc") as run:
        run.advance(120)
    resumed_run = sitedda.resume(model, tmp_path / "half.nc").history
    for name in ("displacement", "flow_pressure", "flow_saturation", "flow_flux", "energy_flow"):
        assert (resumed_run[name].values == reference[name].values).all(), name


def test_joints_of_removed_blocks_carry_no_water():
    """Excavated joints do not carry water; the other joints do."""
    model = started(1e-3, gravity=(0, -9.81))
    for i in range(3):
        box(model, f"b{i}", 0, i, 2, i + 1, is_fixed=i == 0)
    model.flow(aperture=APERTURE, state_at_rest="undrained")
    model.stage("all", kind="static")
    model.stage("dug", kind="static", remove="b2")
    model.stage("after", duration=2e-3)
    data = data_of(model)
    assert len(data.flow_channel) == 2
    assert at(data, 0, 1)[-1] == pytest.approx(100 * 9.81 * SHARE, rel=1e-6)
    assert (at(data, 0, 2)[1:] == at(data, 0, 2)[1]).all()


def test_safety_of_a_dam_over_seeping_water():
    """(W - U) tan φ / H, with the uplift U of steady flow below it."""
    model = sitedda.Model("dam", time_step=1e-3, gravity=(0, -9.81), analysis="plane_strain")
    model.contact(normal_stiffness=1e11)
    model.material("concrete", density=2400.0, young_modulus=2.5e10, poisson_ratio=0.2)
    model.joint("base", friction_angle=45.0)
    box(model, "rock", -20, -10, 40, 0)
    model.block([0, 0, 20, 0, 5, 30, 0, 30], name="dam")
    model.flow(aperture=5e-4, opening_factor=0.0)
    model.traction(along=[-20, 0, 0, 0, 0, 30], level=28.0)  # and the head at the heel
    model.flow_boundary(along=[20, -0.1, 20, 0.1], head=0.0)
    model.stage("full", kind="static")
    weight, uplift, thrust = 2400 * 9.81 * 375, 9810 * 28 / 2 * 20, 9810 * 28**2 / 2
    result = sitedda.safety(model)
    assert result.factor == pytest.approx((weight - uplift) / thrust, rel=1e-3)


def test_a_water_level_ends_with_its_traction():
    """No water acts on a face after the last time of its &traction."""
    model = rigid(4.0, steps=4)
    model.flow(state="steady", **CONSTANT)
    model.traction(side="left", level=3.0, time=[0.0, 0.025])
    data = data_of(model)
    is_loaded = data.time.values < 0.025
    pressure = at(data, 0.0)
    assert pressure[is_loaded][1:] == pytest.approx(3 * 9810, rel=1e-12)
    assert len(pressure[~is_loaded]) and (pressure[~is_loaded] == 0.0).all()


def test_a_stage_replaces_the_level_at_a_node():
    """One level is dropped and another is added; both at once contradict each other."""
    model = rigid(4.0, time_step=0.01, steps=None)
    model.flow(state="steady", **CONSTANT)
    model.flow_boundary(side="right", head=0.0)
    for name, level in (("low", 3.0), ("high", 9.0)):
        model.traction(name=name, side="left", level=level)
    model.stage("before", kind="static")
    stage = model.stage("after", kind="static", add="high", drop="low")
    model.stage("run", duration=0.02)
    assert at(data_of(model), 0.0) == pytest.approx(9810 * np.array([3, 9, 9, 9]), rel=1e-9)
    stage(drop=None)
    with pytest.raises(InputError, match="'high'.* 88290 Pa, but 29430 Pa by .*'low'"):
        sitedda.Simulation(model)


def test_water_flows_down_an_open_joint_with_unit_gradient():
    """Both ends are open: the gradient along the dip is 1, the pressure 0."""
    angle = np.radians(-60)
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])

    def at_turn(points):
        return (np.reshape(points, (-1, 2)) @ rotation).ravel().tolist()

    model = started(0.01, steps=2)
    for name, low in (("low", -1), ("top", 0)):
        model.block(at_turn([0, low, 4, low, 4, low + 1, 0, low + 1]), name=name)
        for x in (0.1, 3.9):
            model.fixed_point(*at_turn([x, low + 0.5]), name)
    model.flow(aperture=3e-4, opening_factor=0.0, state="steady", channel_length=0.5)
    for x in (0, 4):
        model.flow_boundary(along=at_turn([x, -0.1, x, 0.1]), pressure=0.0)
    data = data_of(model)
    exact = 3e-4**3 * 9810 / (12 * VISCOSITY) * np.sin(np.radians(60))
    assert abs(data.flow_flux.values[-1]) == pytest.approx(exact, rel=1e-9)
    assert abs(data.flow_pressure.values).max() < 1e-6


def test_water_below_a_body_of_cells():
    model = started(1e-3)
    model.material("cells", density=100.0, young_modulus=1e13, poisson_ratio=0.0)
    box(model, "low", 0, -1, 4, 0)
    model.region("top", [0, 0, 4, 0, 4, 1, 0, 1], material="cells")
    model.mesh(regions="top", size=0.5)
    model.traction(side="top", normal=1e5)
    model.flow(aperture=APERTURE, state_at_rest="undrained")
    model.stage("loaded", kind="static")
    model.stage("after", duration=1e-3)
    assert data_of(model).flow_pressure.values[-1] == pytest.approx(1e5 * SHARE, rel=1e-5)


def test_steady_water_is_hydrostatic_below_its_table():
    """A closed joint has a head at its foot: no flow anywhere, and no pressure above the table."""
    model = started(0.01, steps=2)
    for name, left in (("left", -1), ("right", 0)):
        box(model, name, left, 0, left + 1, 4)
    model.flow(aperture=3e-4, opening_factor=0.0, state="steady", channel_length=0.25)
    model.flow_boundary(side="bottom", head=1.5)
    data = data_of(model)
    head = np.maximum(0.0, 1.5 - data.flow_node_place.values[:, 1])
    assert data.flow_pressure.values[-1] == pytest.approx(9810 * head, abs=1e-6)
    unit_flux = 3e-4**3 / (12 * VISCOSITY) * 9810  # at unit gradient
    assert abs(data.flow_flux.values[-1]).max() < 1e-9 * unit_flux
    assert abs(data.flow_inflow.values[-1]).max() < 1e-9 * unit_flux


def test_steady_flow_fills_joints_only_below_the_water_table():
    model = started(1e-3)
    for i in range(3):
        box(model, f"b{i}", 0, i, 2, i + 1)
    model.flow(aperture=APERTURE, saturation=0.25)
    model.flow_boundary(along=[0, 1, 2, 1], head=3.0)
    model.stage("rest", kind="static")
    model.stage("after", duration=2e-3)
    data = data_of(model)
    position = data.flow_node_place.values[:, 1]
    assert (data.flow_saturation.values[-1][position == 1] == 1).all()
    assert data.flow_saturation.values[-1][position == 2] == pytest.approx(0.25, rel=1e-6)


LAWS = {
    "coulomb": {},
    "barton_bandis": {"jrc": 8.0, "jcs": 8e7, "compressive_strength": 1e8},
    "cohesive": {"tensile_strength": 1e4, "cohesion": 2e4, "fracture_energy": 5.0},
    "plesha": {"asperity_angle": 5.0},
    "continuously_yielding": {"initial_friction_angle": 45.0, "roughness": 1e-3},
    "rate_state": {"direct_effect": 0.01, "state_distance": 1e-4, "reference_velocity": 1e-3,
                   "threshold_velocity": 1e-9},
    "crushing": {"crushing_strength": 2e6},
}  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
def test_water_with_each_joint_law_under_strong_shaking(law):
    """A block rocks and slides: each step converges, and the energy balance is closed."""
    model = rocking(2e-4, force=6e5, state="transient")
    model.traction(along=[0, 0, 0, 6], level=3.0, added_mass=True)
    joint = model["joint"][0]
    law_variables = {"law": law, "friction_angle": 35.0} | LAWS[law]
    if law in ("coulomb", "barton_bandis"):
        law_variables |= {"normal_stiffness_per_area": None, "shear_stiffness_per_area": None}
    joint(**law_variables)
    data = data_of(model)
    terms = ("input", "flow", "water", "kinetic", "contact", "gravity", "friction")
    scale = max(abs(data[f"energy_{name}"].values).max() for name in terms)
    assert abs(data.energy_balance.values).max() < 1e-6 * scale
    assert abs(data.displacement.values).max() > 1e-3
    assert data.flow_pressure.values.min() >= -1e5 * (1 + 1e-9)


def test_a_large_network_is_refused_or_undrained():
    """Too many nodes for a dense coupled solution; undrained nodes are solved separately."""
    model = sitedda.Model("wall", time_step=1e-3, steps=1)
    model.material("rock", density=2500.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("joint", friction_angle=35.0)
    model.layers(name="floor", left=0, bottom=-1, width=81, thickness=1)
    model.wall(left=0, bottom=0, brick_length=1, brick_height=0.5, bricks=80, courses=30)
    model.fixed_point(1, -0.5)
    model.fixed_point(79, -0.5)
    model.flow(aperture=1e-3, state="transient")
    with pytest.raises(InputError, match=r"nodes, and at most 4000 can be solved together"):
        sitedda.run(model)
    model["flow"][0](state="undrained", state_at_rest="undrained")
    assert sitedda.run(model).complete
    model["wall"][0](courses=10)
    model["flow"][0](state="transient")
    with pytest.raises(InputError, match=r"with \d+ connected nodes beside 8\d\d blocks"):
        sitedda.run(model)


def test_many_separate_networks_are_accepted():
    """The limits on nodes and blocks apply to connected nodes."""
    model = sitedda.Model("columns", time_step=1e-3, steps=1)
    model.material("rock", density=2500.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("joint", friction_angle=35.0)
    for number in range(500):
        model.drums(name=f"c{number}_", centre=2.0 * number, width=1, height=1, count=2)
    model.flow(aperture=1e-3, state="transient")
    assert sitedda.run(model).complete
