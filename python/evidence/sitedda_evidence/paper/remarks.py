# SPDX-License-Identifier: GPL-3.0-or-later
"""Remarks of the paper without figure or table; a short run checks each remark."""

from itertools import product

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.signal import welch

from sitedda.engine.checking import modes, transfer
from sitedda.engine.signals import dominant_frequency
from sitedda.facade.run import run
from sitedda.report.style import BLUE, RED, small_axes
from sitedda.site.column import refined_peak

from ..case import Outcome, picture, study
from ..runs import Task, input_file
from . import avdat, shear_wave
from .discrete import DiscreteModel

_YOUNG, _LAYER, _SPEED = 4.788e9, 15.0, 851.3  # E (Pa), width (m), V_s (m/s) of the layers, table I
_SHAKE = (14.21, 28.93)  # frequency (Hz) and amplification printed for SHAKE
_PENALTIES = (1e8, 4e8, 1e9)  # penalties of table V, N/m
_RATIOS = (10, 12, 16, 20)  # wavelength / block size, section 2.2
_STEPS_PER_PERIOD = (20, 100)  # steps per period, section 2.2
_FRONT_STEPS = (1e-4, 1e-5, 1e-6)  # time steps for the wave front, s
_BAND_CENTRES = (3.4, 4.75)  # centres of the two measured bands, Hz
_NOISE = {"time_step": 2e-3, "steps": 30000}
_RIGID = {"normal_stiffness": 1e12, "penetration_tolerance": 1e-10}
_SETTLING = {"duration": 1.5, "penetration_tolerance": 1e-10}
_PRINTED_TIMES = {1e-3: (2.0, 8.0), 1e-2: (0.5, 1.0)}  # Δt (s): range of times of table IV, s
_EXTREME_PENALTIES = (1e8, 1e10)  # smallest and largest penalty of table IV, N/m
_LAYER_RUNS = {"direct": {"solver": "direct"}, "sor": {"solver": "sor"},
               "rigid": {"solver": "direct", "penetration_tolerance": 1e-10}}  # fmt: skip


def tasks(quick: bool = False) -> list[Task]:
    """Return the runs of the study."""
    waves = product("SP", _RATIOS, [0.004 / n for n in _STEPS_PER_PERIOD])
    queue = [Task(("wave", *case), _simulate_wave, {"case": case}, 0.3) for case in waves]
    queue += [Task(("wave", "S", 8, step), _simulate_wave, {"case": ("S", 8, step)}, 4.0)
              for step in _FRONT_STEPS]  # fmt: skip
    queue += [Task(("fine", k), _free_vibration_frequency, {"contact": {"normal_stiffness": k}}, 2)
              for k in _PENALTIES]  # fmt: skip
    queue += [Task(("bending", k), _bending_frequencies, {"normal_stiffness": k}, 4.0)
              for k in _PENALTIES[1:]]  # fmt: skip
    queue += [Task(("noise", f), _noise_peak_frequency, {"frequency": f}) for f in _BAND_CENTRES]
    queue += [Task(("layers", name), _layer_accelerations, {"changes": case}, 2.0)
             for name, case in _LAYER_RUNS.items()]  # fmt: skip
    queue += [Task(("settling", dt, k), avdat.simulate_settling,
                   {"normal_stiffness": k, "time_step": dt} | _SETTLING)
             for dt in _PRINTED_TIMES for k in _EXTREME_PENALTIES]  # fmt: skip
    rigid = {"contact": _RIGID, "duration": 0.4, "band": (5.0, 200.0)}
    return [*queue, Task("rigid", _free_vibration_frequency, rigid, 1.0)]


def _simulate_wave(case: tuple) -> dict:
    """Run figure 8 as S or P wave; return loss and ripple at M1 as fractions of the amplitude."""
    kind, ratio, step = case
    changes = shear_wave.wave_changes(("triangle", ratio, step, 100.0, 0.004))
    if kind == "P":
        young = 2643.0 * (ratio / 0.004) ** 2
        changes |= {"fixed_point[*]": {"motion_x": "", "motion_y": "pulse"},
                    "material": {"young_modulus": young, "poisson_ratio": 0.0},
                    "contact": {"normal_stiffness": 100 * young}}  # fmt: skip
    history = run(input_file("shear_wave.nml"), **changes).history
    wave = history.displacement.sel(point="M1").isel(axis="SP".index(kind)).values / 1e-3
    return {"loss": 1 - wave.max(), "ripple": -wave[: wave.argmax()].min()}


def _free_vibration_frequency(contact: dict, duration: float = 5.0, band=(0.5, 20.0)) -> float:
    """Return the frequency of the free vibration of the column after a push, Hz (Δt = 1e-4 s)."""
    load = {"time": [0, 0, 0.02, 0.02], "force_x": [0.0, 1e3, 1e3, 0.0], "force_y": [0.0] * 4}
    history = run(input_file("avdat.nml"), time_step=1e-4, max_displacement_ratio=1e-3, settle=True,
                  duration=duration, contact=contact, load=load).history  # fmt: skip
    displacement = history.displacement.sel(point="top").isel(axis=0).values
    return float(dominant_frequency(displacement[history.time.values > 0.021], 1e-4, band))


def _bending_frequencies(normal_stiffness: float) -> tuple[float, float]:
    """Return the first frequency with drums as single blocks and as meshed bodies, Hz.

    The rotational stiffness of a joint, K Σ sᵢ xᵢ² with tributary lengths sᵢ of contacts, is the
    same in both models.
    """
    frequencies = []
    for parts in (1, 3):
        x = np.linspace(-0.5, 0.5, parts + 1) * avdat.WIDTH
        section = (avdat.WIDTH / parts) * (np.sum(x**2) - x[0] ** 2)
        stiffness = normal_stiffness * avdat.WIDTH**2 / 2 / section
        model = avdat.column(stiffness, time_step=1e-3, steps=1)
        if parts > 1:
            model.mesh(blocks="drum_*", size=avdat.WIDTH / parts)
        model.boundary(kind="fixed", blocks="base", side="bottom")
        frequencies.append(float(modes(model, 1).frequency[0]))
    return frequencies[0], frequencies[1]


def _noise_peak_frequency(frequency: float) -> float:
    """Return the peak frequency of the ratio of top to base spectrum under noise, Hz."""
    stiffness = 2.12e8 / (avdat.WIDTH / 2) * (frequency / _BAND_CENTRES[0]) ** 2
    model = avdat.column(stiffness, settle=True, **_NOISE)
    values = np.random.default_rng(1).standard_normal(_NOISE["steps"]) * 1e-3
    model.motion("noise", quantity="acceleration", unit="m/s2", time_step=_NOISE["time_step"],
                 values=values.tolist())  # fmt: skip
    model.boundary(kind="fixed", blocks="base", side="bottom", motion_x="noise")
    model.measured_point("top", 0.0, (avdat.DRUMS - 0.5) * avdat.HEIGHT, f"drum_{avdat.DRUMS}")
    model.measured_point("base", 0.0, -0.5, "base")
    acceleration = model.run().history.acceleration.isel(axis=0)
    frequency, density = welch(acceleration.values.T, 1 / _NOISE["time_step"], nperseg=8192)
    band = (frequency > 1) & (frequency < 10)
    ratio = dict(zip(acceleration.point.values, np.sqrt(density[:, band]), strict=True))
    return float(frequency[band][np.argmax(ratio["top"] / ratio["base"])])


def _layer_accelerations(changes: dict) -> np.ndarray:
    """Run the layers of table I for 5 s; return the acceleration of the top layer, m/s²."""
    history = run(input_file("layers_table1.nml"), changes=changes, steps=5000).history
    return history.acceleration.sel(point="middle").isel(axis=0).values


def _exact_peak(normal_stiffness: float):
    """Return the peak of the exact transfer function of table I at a penalty (N/m)."""
    contact = {"normal_stiffness": normal_stiffness}
    model = DiscreteModel.of(input_file("layers_table1.nml"), contact=contact)
    positions = ("middle", "base", "displacement")
    return refined_peak(lambda f: model.transfer_function(f, 1e-3, *positions), (11.0, 15.5), 30)


def _engine_transfer_peak(**changes):
    """Return the peak of the transfer function of the engine for table I with changes."""
    return refined_peak(
        lambda f: transfer(input_file("layers_table1.nml"), f, "middle", changes=changes),
        (13.0, 15.5), 30,
    )  # fmt: skip


def _first_frequency(normal_stiffness: float) -> float:
    """Return the first frequency of the column with closed joints at a penalty (N/m), Hz."""
    return float(avdat.closed_column(normal_stiffness).frequencies[0])


def _non_classical_damping() -> tuple[float, float]:
    """Return damping ratios of soft on stiff layers: by energies, and by complex eigenvalues."""
    size, counts = 15, [10, 5]
    stiffness, ratio = np.repeat([1.0, 0.1], counts), np.repeat([0.01, 0.1], counts)
    shear = np.eye(size) - np.eye(size, k=-1)  # strains of layers from displacements of nodes
    assembled, mass = shear.T @ np.diag(stiffness) @ shear, np.diag([1.0] * (size - 1) + [0.5])
    squares, shapes = eigh(assembled, mass)
    omega, shape = np.sqrt(squares[0]), shapes[:, 0]
    damping = shear.T @ np.diag(2 * ratio / omega * stiffness) @ shear
    lower_rows = -np.linalg.solve(mass, np.hstack([assembled, damping]))
    roots = np.linalg.eigvals(np.vstack([np.eye(size, 2 * size, k=size), lower_rows]))
    root = min(roots[roots.imag > 0], key=abs)
    return float(shape @ damping @ shape / (2 * omega)), float(-root.real / abs(root))


def _restitutions(omega: float) -> np.ndarray:
    """Return restitutions of a mass on a penalty spring in DDA, for 20 impact times in a step."""
    restitutions = []
    for start in (np.arange(20) + 0.5) / 20:
        gap, velocity = start, -1.0
        for _ in range(100 + int(20 / omega)):
            step = velocity  # free motion with Δt = 1; the spring acts if it ends below 0
            if gap + step < 0:
                step = (2 * velocity - omega**2 * gap) / (2 + omega**2)
            gap, velocity = gap + step, 2 * step - velocity
            if gap > 0 and velocity > 0:
                break
        restitutions.append(velocity)
    return np.array(restitutions)


@study("Remarks of the paper without figure or table", tasks)
def remarks(runs: dict) -> Outcome:
    """Compose a row for each remark."""
    outcome = Outcome()
    _add_contact_rows(outcome, runs)
    _add_damping_rows(outcome)
    _add_wave_rows(outcome, runs)
    _add_column_rows(outcome, runs)
    outcome.pictures = [picture("remarks_rebound", "Restitution of a penalty contact against Ω ="
                             " Δt √(k/m): mean and range for all impact times within a step.",
                             _draw_restitutions)]  # fmt: skip
    return outcome


def _add_contact_rows(outcome: Outcome, runs: dict) -> None:
    """Compare rigid joints, solvers and the amplification at the best penalty."""
    shear, rigid = _first_frequency(1e14), runs["rigid"]
    direct = runs["layers", "direct"]
    difference, bonded = (float(abs(runs["layers", name] - direct).max() / abs(direct).max())
                     for name in ("sor", "rigid"))  # fmt: skip
    scale = _YOUNG * _LAYER
    crossing = np.exp(brentq(lambda log: _exact_peak(np.exp(log) * scale).amplitude - _SHAKE[1],
                             np.log(15), np.log(80), xtol=1e-3))  # fmt: skip
    low, high, at_crossing = (_exact_peak(ratio * scale) for ratio in (10, 100, crossing))
    engine = _engine_transfer_peak(contact={"normal_stiffness": float(crossing * scale)})
    outcome.compare(
        "first frequency of the column with joints made rigid by augmented Lagrange (Hz)",
        "section 1", "“beyond the scope”", shear, rigid, "with rigid joints only the shear"
        " compliance of the drums remains; the penalty of Tables IV and V is the joint stiffness,"
        " not a numerical parameter", within=0.02)  # fmt: skip
    ratios = []
    for step, printed in _PRINTED_TIMES.items():
        times = [runs["settling", step, k]["settled"] for k in _EXTREME_PENALTIES]
        ratios.append(max(times) / min(times))
        outcome.compare(
            f"settling time with rigid joints, k = 1e8 and 1e10 N/m, Δt = {step:g} s (s)",
            "Table IV", printed, None, (min(times), max(times)), "independent of the penalty",
            2)  # fmt: skip
    outcome.compare(
        "acceleration of the top layer: largest difference / peak, with `penetration_tolerance`",
        "section 1", None, 0.0, bonded, "no difference, because the layers are bonded and the"
        " multiplier acts only on unbonded contacts", 2, within=0.0)  # fmt: skip
    outcome.compare(
        "acceleration of the top layer: largest difference / peak, SOR and direct solver",
        "Table I", None, 0.0, difference, "5 s of Table I; “SOR, factor 1.5”", 2,
        within=1e-4)  # fmt: skip
    outcome.compare(f"amplification at the peak, k = {crossing:.1f} E L, fitted by theory to SHAKE",
        "section 5, k = 21 E L", _SHAKE[1], at_crossing.amplitude, engine.amplitude,
        f"from 10 to 100 E L, f increases from {low.frequency:.2f} to {high.frequency:.2f} Hz and"
        f" A decreases from {low.amplitude:.2f} to {high.amplitude:.2f}; the optimum at"
        f" {at_crossing.frequency:.2f} Hz is the crossing of two curves", 3,
        within=1e-3)  # fmt: skip
    outcome.require("Settling times with rigid joints differ by less than 20 % between penalties",
        max(ratios) < 1.2, "ratios " + ", ".join(f"{ratio:.2f}" for ratio in ratios))  # fmt: skip


def _add_damping_rows(outcome: Outcome) -> None:
    """Compare lumped masses, material damping and non-classical damping."""
    kh = np.pi / 2 / 15
    chain = 2 * np.sin(kh / 2)
    material = {"damping_ratio": 0.022, "reference_frequency": 14.0}
    fine, coarse = (_engine_transfer_peak(time_step=step, integration="midpoint", material=material)
                    for step in (1e-3, 5e-3))  # fmt: skip
    energies, exact = _non_classical_damping()
    outcome.compare("15 lumped masses: relative reduction of the first frequency (%)", "eq. 8",
        None, 100 * kh**2 / 24, 100 * (1 - chain / kh),
        "(kh)²/24; SHAKE solves the wave equation with complex moduli", 3)  # fmt: skip
    outcome.compare("amplification at the peak, table I, 2.2 % material damping, Δt = 1 ms",
        "section 2.1", "“the best way”", None, fine.amplitude,
        f"at {fine.frequency:.3f} Hz, no numerical damping")  # fmt: skip
    outcome.compare("amplification at the peak, table I, 2.2 % material damping, Δt = 5 ms",
        "section 2.1", None, fine.amplitude, coarse.amplitude,
        f"at {coarse.frequency:.3f} Hz; Δt changes the frequency, not the damping ratio",
        within=0.02)  # fmt: skip
    outcome.compare(
        "damping ratio of the first mode, 5 soft layers (10 %) on 10 stiff layers (1 %)",
        "section 2.1", "“non-classical”", exact, energies,
        "theory: complex mode; sitedda: energies of the real mode, as in `modes`")  # fmt: skip


def _add_wave_rows(outcome: Outcome, runs: dict) -> None:
    """Compare losses of S and P waves, ripples of the front, and thin layers."""
    cells = [
        [f"1/{ratio}", *(f"{100 * runs['wave', kind, ratio, 0.004 / n]['loss']:.1f}"
                         for kind in "SP" for n in _STEPS_PER_PERIOD)]
        for ratio in _RATIOS
    ]  # fmt: skip
    heads = [f"{kind}, Δt = T/{n}" for kind in "SP" for n in _STEPS_PER_PERIOD]
    outcome.tabulate(
        "Section 2.2: loss of amplitude of P and S waves (%) at the recommended η and Δt",
        ["η", *heads], cells)  # fmt: skip
    for step in _FRONT_STEPS:
        outcome.compare(f"ripple before the wave front / amplitude, λ/Δx = 8, Δt = {step:g} s (%)",
            "section 2.2", "“pseudo high frequency oscillations”" if step == 1e-6 else None,
            None, 100 * runs["wave", "S", 8, step]["ripple"],
            "dispersion of the blocks; large time steps damp it", 3)  # fmt: skip
    ripples = [runs["wave", "S", 8, step]["ripple"] for step in _FRONT_STEPS]
    outcome.require("The ripple at the smallest time step exceeds that at the largest",
        ripples[0] < ripples[2],
        ", ".join(f"{100 * ripple:.2g} %" for ripple in ripples))  # fmt: skip
    for thickness in (0.5, 1.0, 3.0):
        shear = _YOUNG / 2.5 * _LAYER / (2 * 1.5e12 / 2.5 * thickness)
        outcome.compare(f"first frequency, layers of {thickness:g} m, k = 1500 GN/m (Hz)",
            "section 2.2, k > 100 E", None, float(_SPEED / 60 / np.sqrt(1 + shear)),
            _layered_frequency(thickness),
            "v/(4H √(1 + GW/2k_sΔx)): only k_s × layer thickness matters",
            within=0.01)  # fmt: skip


def _layered_frequency(thickness: float) -> float:
    """Return the first frequency of table I with layers of another thickness (m), Hz."""
    count = round(15 / thickness)
    changes = {"layers.layer": {"thickness": thickness, "count": count},
               "measured_point.middle": {"y": 15 - thickness / 2, "block": f"layer_{count}"},
               "measured_point.surface.block": f"layer_{count}"}  # fmt: skip
    return float(modes(input_file("layers_table1.nml"), 1, changes=changes).frequency[0])


def _add_column_rows(outcome: Outcome, runs: dict) -> None:
    """Compare frequencies of the column of Avdat: small steps, bending drums, noise."""
    for k in _PENALTIES:
        outcome.compare(f"dominant frequency at k = {k:.0e} N/m, Δt = 1e-4 s (Hz)", "Table V, “not"
            " shown”", avdat.printed_range(k), _first_frequency(k), runs["fine", k],
            "theory without the weight", within=0.02)  # fmt: skip
    for k in _PENALTIES[1:]:
        plain, meshed = runs["bending", k]
        outcome.compare(f"first frequency with drums that bend, k = {k:.0e} N/m (Hz)", "Table V",
            avdat.printed_range(k), None, meshed,
            f"meshed drums; {plain:.2f} Hz with plane sections", 3)  # fmt: skip
    for frequency, band, name in zip(_BAND_CENTRES, avdat.BANDS, ("first", "second"), strict=True):
        outcome.compare(f"peak of the spectral ratio top / base under noise, {name} band (Hz)",
            "Fig. 19", band, None, runs["noise", frequency],
            "joints of 2.12e8 N/m" if name == "first" else "1.95 times as stiff", 3)  # fmt: skip
    drum = avdat.DENSITY * avdat.GRAVITY * avdat.WIDTH * avdat.HEIGHT
    outcome.compare("friction angle below which 3 kN slides the top drum (°)", "section 3.2",
        "“initial translation”", float(np.degrees(np.arctan(3e3 / drum))), "not run",
        "φ is not printed", 3)  # fmt: skip
    outcome.compare("best penalty of the rocking column / penalty by Shi [26]", "section 4",
        8.3e7 / 1.8e9, None, f"Ω smaller by √({1.8e9 / 8.3e7:.1f}) ="
        f" {np.sqrt(1.8e9 / 8.3e7):.1f}", "restitution depends on Ω = Δt √(k/m) (picture), so"
        " the fit of the penalty fits the loss at impacts")  # fmt: skip
    is_lower = all(runs["bending", k][1] < runs["bending", k][0] for k in _PENALTIES[1:])
    in_bands = all(low <= runs["noise", f] <= high
                 for f, (low, high) in zip(_BAND_CENTRES, avdat.BANDS, strict=True))  # fmt: skip
    outcome.require(
        "Bending of the drums reduces the first frequency", is_lower, "at both penalties"
    )
    outcome.require("Under noise, the peak of each direction is in its measured band", in_bands,
            ", ".join(f"{runs['noise', f]:.2f} Hz" for f in _BAND_CENTRES))  # fmt: skip


def _draw_restitutions(drawing) -> None:
    omega = np.geomspace(0.02, 30, 25)
    values = np.array([_restitutions(value) for value in omega])
    with small_axes(drawing, size=(5.8, 3.2)) as axis:
        axis.fill_between(omega, values.min(1), values.max(1), color=BLUE, alpha=0.25, lw=0)
        axis.semilogx(omega, values.mean(1), color=BLUE, label="mean; shaded: all times of impact")
        small = omega[omega < 1]
        axis.semilogx(small, np.exp(-np.pi * small / 4), "--", color=RED, label="exp(−πΩ/4)")
        axis.set(xlabel="Ω = Δt √(k/m)", ylabel="restitution", ylim=(0, 1.05))
        axis.legend()
