# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffnesses from measured modes: derivatives, recovery, doubts, files."""

import re
import shlex
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

import sitedda
from sitedda.calibration import Family, calibrate, family_of, measured_modes, odds
from sitedda.calibration.measured import Observations, shapes_of
from sitedda.calibration.posterior import Posterior
from sitedda.checking import matrices
from sitedda.command import main
from sitedda.errors import ConvergenceError, InputError
from sitedda_evidence.validation.calibrated import MEDIANS, drums_on_springs, random_column

NORMAL, SHEAR, BED, YOUNG = MEDIANS
RANGES = {name: (value / 3, value * 3) for name, value in MEDIANS.items()}
TRUTH = {SHEAR: 0.9e9, BED: 3.1e9}
TWO = {name: RANGES[name] for name in TRUTH}


def column(towers=1) -> sitedda.Model:
    return drums_on_springs(0.8, 0.5, 4, towers)


def test_matrices_have_the_modes_of_the_model():
    stiffness, mass, points, names = matrices(column())
    modes = sitedda.modes(column(), 4)
    shapes = modes.shapes.reshape(4, -1).T
    assert np.allclose(shapes.T @ mass @ shapes, np.eye(4), atol=1e-9)
    squares = (2 * np.pi * modes.frequency) ** 2
    assert np.allclose(shapes.T @ stiffness @ shapes, np.diag(squares), rtol=1e-9, atol=1e-6)
    unit = np.zeros(mass.shape[0]).reshape(-1, 6)
    unit[:, 0], unit[:, 2] = 1.0, 0.1  # about the centroid, where the points are
    assert names == ["p0_0", "p0_1", "p0_2", "p0_3"]
    assert np.allclose((points @ unit.ravel()).reshape(-1, 2), [1.0, 0.0])


@pytest.mark.parametrize("towers", [1, 2], ids=["simple roots", "double roots"])
def test_derivatives_of_eigenvalues(towers):
    """They agree within 1e-8 with fourth-order differences; equal towers have each ω² twice."""
    family = family_of(column(towers=towers), MEDIANS)
    theta, count = np.array(list(MEDIANS.values())), 4
    squares, y = family.modes(theta, count)
    slopes, _ = family.slopes(squares, y)
    if towers == 2:
        assert np.allclose(squares[::2], squares[1::2], rtol=1e-11)
    for i in range(len(theta)):
        h = 4e-3 * theta * (np.arange(len(theta)) == i)
        f = [family.modes(theta + s * h, count)[0] for s in (-2, -1, 1, 2)]
        slope = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h[i])
        assert slopes[i] * theta[i] == pytest.approx(slope * theta[i], abs=1e-8 * squares[0])


def test_double_eigenvalues_that_separate():
    """Stiffening one of two towers separates a double ω²; sorted modes have no derivative."""
    family = family_of(column(towers=2), {"boundary[2].stiffness_per_area": 2e9})
    squares, y = family.modes([2e9], 2)
    (slopes,), _ = family.slopes(squares, y)
    assert np.ptp(squares) < 1e-10 * squares[0]
    h = 1e5
    ahead = [family.modes([2e9 + s * h], 2)[0] - squares for s in (1, 2)]
    slope = (4 * ahead[0] - ahead[1]) / (2 * h)
    assert slopes == pytest.approx(slope, rel=1e-5, abs=1e-5 * slopes[1])
    assert slopes[1] > 1e3 * abs(slopes[0])


@pytest.mark.parametrize("columns", [1, 6])  # six have 18 rigid motions
def test_rigid_motions_are_excluded_from_modes(columns):
    model = sitedda.Model("free drums", time_step=1e-3, steps=1)
    model.contact(normal_stiffness=1e9)
    model.material("stone", density=2200, young_modulus=2e9, poisson_ratio=0.2)
    model.joint("bed", friction_angle=35)
    for number in range(columns):
        model.drums(name=f"c{number}", centre=2.0 * number, width=0.8, height=0.5, count=3)
    squares, _ = family_of(model, {"contact.normal_stiffness": 1e9}).modes([1e9], 3)
    assert np.sqrt(squares) / (2 * np.pi) == pytest.approx(sitedda.modes(model, 3).frequency)


def seen(count=4, noise=0.0, shapes=False) -> pd.DataFrame:
    """Return modes of the column with its true stiffnesses, as if they were measured."""
    modes, random = sitedda.modes(column(), count, changes=TRUTH), np.random.default_rng(0)
    *_, points, names = matrices(column())
    frequency = modes.frequency * np.exp(noise * random.standard_normal(count))
    table = {"frequency": frequency, "deviation": max(noise, 0.002) * modes.frequency}
    if shapes:
        at = [f"{name}.{axis}" for name in names for axis in "xy"]
        table |= dict(zip(at, points @ modes.shapes.reshape(count, -1).T, strict=True))
    return pd.DataFrame(table)


def test_recovers_stiffnesses():
    calibration, true = calibrate(column(), seen(), TWO, discrepancy=0.0), list(TRUTH.values())
    assert calibration.unknowns.best.tolist() == pytest.approx(true, rel=0.02)
    assert np.all((calibration.unknowns.low < true) & (calibration.unknowns.high > true))
    assert np.all(abs(calibration.fit.misfit) < 1) and calibration.reduction_error < 1e-5
    assert len(calibration.doubts) == 1 and "friction" in calibration.doubts[0]
    assert calibration.samples.shape == (1000, 2)


@pytest.fixture
def arch():
    """Return an arch whose closed contacts depend on the stiffness of its ground."""
    model = sitedda.Model("arch", time_step=1e-3, steps=1, gravity=[0, -9.81])
    model.contact(normal_stiffness=5e9)
    model.material("stone", density=2300, young_modulus=8e9, poisson_ratio=0.2)
    model.joint("dry", friction_angle=40)
    model.arch(name="v", radius=5.0, thickness=0.9, voussoirs=7)
    for name, left in (("a", -8.0), ("b", 4.0)):
        model.block([left, -1, left + 4, -1, left + 4, 0, left, 0], name=name)
        model.boundary(name=name, kind="springs", blocks=name, side="bottom",
                       stiffness_per_area=1e9)  # fmt: skip
    return model


def calibrate_arch(model):
    truth = {"contact.normal_stiffness": 4e9, "boundary[a].stiffness_per_area": 7e8}
    frequency = sitedda.modes(model, 3, changes=truth).frequency
    modes = {"frequency": frequency, "deviation": 0.002 * frequency}
    ranges = {n: (k / 2, 10 * k) for n, k in truth.items()}  # other contacts close at the centre
    return calibrate(model, modes, ranges, discrepancy=0.0), list(truth.values())


def test_contacts_that_gravity_closes(arch):
    calibration, truth = calibrate_arch(arch)
    assert calibration.unknowns.best.tolist() == pytest.approx(truth, rel=0.02)
    assert not any("gravity closes" in doubt for doubt in calibration.doubts)


def test_contacts_at_the_limit_of_friction_do_not_disturb(root):
    """Many joints of a facade have no force and hardly any friction; they stick all the same."""
    facade = root / "inputs/facade.nml"
    frequency = sitedda.modes(facade, 2).frequency
    modes = {"frequency": frequency, "deviation": 0.01 * frequency}
    calibration = calibrate(facade, modes, {"contact.normal_stiffness": (5e7, 8e8)})
    assert not any("gravity closes" in doubt for doubt in calibration.doubts)
    assert calibration.unknowns.best.iloc[0] == pytest.approx(2e8, rel=1e-3)


def test_derivatives_where_a_model_is_unstable():
    """On soft joints ω² of the first mode is negative under the weight."""
    family = Family(np.diag([-1.0, 50.0]), [np.eye(2)], np.zeros((2, 2)))
    observations = Observations(measured_modes({"frequency": [1.0], "deviation": [0.1]}), [])
    posterior = Posterior(family, observations, np.zeros(1), np.ones(1), 0.0)
    assert np.all(np.isfinite(posterior.jacobian(np.array([-1.0]))))


def test_the_assumption_of_closed_contacts_is_reported(arch, monkeypatch):
    """Each change of a stiffness opens contacts; the note reports the effect of open contacts."""

    def only_closed(model, at, contacts, changes):
        if contacts != "closed":
            raise InputError("the stiffness is not linear")
        return family_of(model, at, contacts, changes)

    monkeypatch.setattr(sys.modules[calibrate.__module__], "family_of", only_closed)
    calibration, truth = calibrate_arch(arch)
    (doubt,) = (doubt for doubt in calibration.doubts if "gravity closes" in doubt)
    assert "all touching contacts are assumed closed" in doubt
    changed = float(re.search(r"up to ([0-9.]+) %", doubt)[1])
    best = calibration.unknowns.best.to_dict()
    opened, closed = (sitedda.modes(arch, 3, contacts=which, changes=best).frequency
                      for which in ("auto", "closed"))  # fmt: skip
    assert changed == pytest.approx(100 * abs(opened / closed - 1).max(), rel=0.05)
    assert calibration.unknowns.best.tolist() != pytest.approx(truth, rel=0.02)


def test_shapes_identify_modes():
    """Shapes identify modes in another order, one of which is missing."""
    modes = seen(5, shapes=True).iloc[[3, 0, 1]]
    calibration = calibrate(column(), modes, TWO, discrepancy=0.0)
    assert calibration.fit.number.tolist() == [4, 1, 2]
    assert calibration.fit.mac.tolist() == pytest.approx([1.0] * 3, abs=1e-3)
    assert calibration.unknowns.best.tolist() == pytest.approx(list(TRUTH.values()), rel=0.02)


def test_probability_of_errors_and_shapes():
    """Eq. 1 agrees with the densities of scipy, with an unknown discrepancy of 2 % exp(0.4)."""
    family, modes = family_of(column(), MEDIANS), measured_modes(seen(3, 0.02, shapes=True))
    family = family.reduced(family.modes(np.array(list(MEDIANS.values())), 8)[1])
    mean, z = np.log([*MEDIANS.values(), 0.02]), np.array([0.1, -0.2, 0.3, 0.05, 0.4])
    *_, names = matrices(column())
    posterior = Posterior(family, Observations(modes, names), mean, np.ones(5), None)
    squares, y = family.modes(np.exp(mean + z)[:4], 5)
    expected, delta = norm.logpdf(z).sum(), 0.02 * np.exp(0.4)
    solved = posterior.solve_modes(z[None])[2][0]
    solutions = zip(modes.itertuples(), shapes_of(modes).to_numpy(), solved, strict=True)
    for mode, like, k in solutions:
        off = np.log(2 * np.pi * mode.frequency) - np.log(squares[k]) / 2
        expected += norm.logpdf(off, scale=np.hypot(mode.deviation / mode.frequency, delta))
        own = family.points @ y[:, k]
        remainder = 1 - (like @ own) ** 2 / (like @ like) / (own @ own)
        scale = np.hypot(mode.shape_deviation, delta)
        expected += norm.logpdf(np.sqrt(remainder), scale=scale) + 6 * norm.logpdf(0, scale=scale)
    assert posterior.log(z[None])[0] == pytest.approx(expected, abs=1e-6)
    h = 1e-5 * np.eye(5)
    slopes = (posterior.residuals(z + h) - posterior.residuals(z - h)).T / 2e-5
    assert posterior.jacobian(z) == pytest.approx(slopes, abs=1e-6 * abs(slopes).max())
    flipped = replace(posterior, family=replace(family, points=-family.points))
    assert np.allclose(posterior.residuals(z[None]), flipped.residuals(z[None]), atol=1e-9)


def test_doubts_about_fit_and_unknowns_are_reported():
    modes = seen(noise=0.02)
    first = modes.frequency[0]
    bad_modes = {"frequency": [first, 1.5 * first], "deviation": 0.01 * first}
    calibration = calibrate(column(), bad_modes, {SHEAR: RANGES[SHEAR]})
    assert any("cannot be fitted" in doubt for doubt in calibration.doubts)
    blind = {SHEAR: RANGES[SHEAR], YOUNG: (1e12, 1e14)}
    calibration = calibrate(column(), modes[:1], blind)
    assert any("do not determine" in text or "combination" in text for text in calibration.doubts)
    sharp = calibrate(column(), seen(2), {n: (k / 10, k * 10) for n, k in MEDIANS.items()},
                      discrepancy=0.0)  # fmt: skip
    assert any("ranges may be too narrow" in doubt for doubt in sharp.doubts)
    right = calibrate(column(), modes, TWO)
    poor = calibrate(column(), modes, {SHEAR: (1e7, 1e8), BED: RANGES[BED]})
    assert odds({"right": right, "poor": poor})["right"] > 0.99


def test_probability_where_modes_cross():
    """Where modes cross, ln p has kinks and no local curvature: the evidence uses prior draws."""
    model, modes, priors, _ = random_column(124, (1, 4), (2, 5))
    calibration = calibrate(model, modes, priors, discrepancy=0.0)
    mean, spread = np.log(list(priors.values())).mean(1), np.log(3) / 1.6449
    family = family_of(model, dict(zip(priors, np.exp(mean), strict=True)))
    observations = Observations(measured_modes(modes), [])
    posterior = Posterior(family, observations, mean, np.full(4, spread), 0.0)
    z = np.random.default_rng(0).standard_normal((20000, 4))
    prior = -np.sum(z**2, axis=1) / 2 - 2 * np.log(2 * np.pi)
    weights = np.exp(posterior.log(z) - prior)
    error = weights.std() / weights.mean() / np.sqrt(len(z))
    assert calibration.evidence == pytest.approx(np.log(weights.mean()), abs=4 * error)
    assert error < 0.2
    far = [(np.full(4, 1e4), np.eye(4))]  # stiffnesses overflow there
    assert np.all(np.isfinite(posterior.draw_weighted(far, 0)[1]))
    with pytest.raises(ConvergenceError, match="cannot be integrated"):
        posterior.draw_weighted([(np.zeros(4), np.diag([1, 1, 1, 1e-12]))], 0)


@pytest.mark.parametrize(
    ("unknowns", "message"),
    [
        ({}, "at least one unknown"),
        ([NORMAL], "at least one unknown"),
        ({NORMAL: (2e9, 1e9)}, r"0 < low < high"),
        ({"joint[bed].friction_angle": (20, 40)}, "changes no stiffness"),
        ({"material[stone].density": (2000, 3000)}, "changes masses"),
        ({"contact.normal_stiffness": (1e8, 1e9)}, "changes no stiffness"),
        ({"joint[bed].normal_stifness_per_area": (1e8, 1e9)}, "normal_stifness"),
        ({NORMAL: RANGES[NORMAL], "material[stone].poisson_ratio": (0.05, 0.2)}, "not linear"),
    ],
)
def test_refuses_unknowns(unknowns, message):
    with pytest.raises(InputError, match=message):
        calibrate(column(), {"frequency": [3.0], "deviation": 0.1}, unknowns)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frequency\n", "modes.csv: give a heading"),
        ("frequency;deviation\n3,0;0,1\n", "line 1: 'frequency;deviation' has no commas"),
        ("f\0\n1\0\n", "UTF-8"),
        ("frequency,deviation,deviation\n3,1,2\n", "line 1: heading 'deviation' is repeated"),
        ("frequency,width\n3,1\n", "column 'width' is not known"),
        ("frequency,deviation\n3,0.1\n-1,0.1\n", "line 3: frequency = -1"),
        ("# sensors\nfrequency\n3\n", "line 3: deviation is missing"),
        ("low,high\n3,2\n", "low = 3 must be below"),
        ("frequency,deviation\n3\n", "line 2: 1 values under 2"),
        ("frequency,deviation\n3,0.1\n4,b\n", "line 3: deviation = 'b' is not a number"),
        ("frequency,low,high\n3,2,4\n", "line 2: `low` and `high` are given"),
        ("frequency,deviation\n0,0.1\n", "line 2: frequency = 0"),
        ("frequency,deviation\n3,0\n", "line 2: deviation = 0"),
        ("frequency,deviation,p0_0.x\n3,1,inf\n", "line 2: p0_0.x = inf"),
        ("frequency,deviation,shape_deviation\n3,1,-1\n", "line 2: shape_deviation = -1"),
        ("frequency,deviation\n70,1\n20,1\n", "line 3: frequency = 20 of mode 2 is below the 70"),
        ("frequency,deviation,mode\n70,1,1\n20,1,\n", "line 3: frequency = 20 of mode 2"),
        ("frequency,deviation,mode\n20,1,\n20,1,1\n", "line 3: two measured .* mode 1"),
        ("frequency,deviation,mode\n20,1,50\n", "line 2: mode 50 .* only 24 modes"),
        ("frequency,deviation,p0_0.x,p0_1.x\n20,1,0,0\n", "line 2: the shape is zero"),
        ("frequency,deviation,p0_0.x,top.x\n20,1,2,1\n", "line 2: .* top.x, but the measured"),
    ],
)
def test_refuses_tables(tmp_path, text, message):
    (tmp_path / "modes.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        calibrate(column(), tmp_path / "modes.csv", {SHEAR: RANGES[SHEAR]})


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (None, "there is no measured mode"),
        ({"frequency": [20.0, 70.0], "deviation": [0.1]}, "not a table"),
        ({"frequency": ["f"], "deviation": [0.1]}, "mode 1: frequency = f"),
        ([3.0, 4.0], "column 0 is not known"),
        (
            pd.DataFrame([[20.0, 1.0, 2.0]], columns=["frequency", "deviation", "deviation"]),
            "column 'deviation' is repeated",
        ),
    ],
)
def test_refuses_tables_of_python(table, message):
    with pytest.raises(InputError, match=message):
        measured_modes(table)


def test_reads_tables_of_other_programs(tmp_path):
    """With a byte-order mark, line ends of Windows, quotes and an empty cell; a tiny shape."""
    head = "\ufefffrequency,deviation,damping,p0_0.x,'p0_3.x'\r\n".replace("'", '"')
    (tmp_path / "modes.csv").write_text(head + "20,1,,1e-200,2e-200\r\n", "utf-8")
    calibration = calibrate(column(), tmp_path / "modes.csv", TWO)
    assert calibration.fit.mac.iloc[0] > 0.5 and calibration.measured.damping.isna().all()
    table = calibration.measured.drop(columns="p0_0.x")
    assert any("one component" in doubt for doubt in calibrate(column(), table, TWO).doubts)


def test_refuses_repeated_unknowns(tmp_path, capsys):
    column().write(tmp_path / "c.nml")
    twice = ["--unknown", f"{SHEAR}=1e8:1e9"] * 2
    assert main(["calibrate", str(tmp_path / "c.nml"), str(tmp_path / "m.csv"), *twice]) != 0
    assert "a name is repeated" in capsys.readouterr().err


def test_command_and_study(tmp_path, capsys, monkeypatch):
    """The samples of the command are the sample of a study."""
    monkeypatch.chdir(tmp_path)
    column().write("column.nml")
    seen(2, shapes=True).assign(damping=0.02).to_csv("modes.csv", index=False)
    command = ["calibrate", "column.nml", "modes.csv", "--samples", "50",
               "--unknown", f"{SHEAR}=3e8:3e9", "--unknown", f"{BED}=1e9:1e10"]  # fmt: skip
    assert main(command) == 0 and main(command) == 0  # it replaces its own files
    printed = capsys.readouterr().out
    assert "MAC 1.00" in printed and "ln evidence" in printed and "damping 2 %" in printed
    assert (tmp_path / "column_calibration.png").exists()
    (tmp_path / "study.toml").write_text(
        'model = "column.nml"\nresults = ["displacement[p0_3].x.max"]\n'
        "[fixed]\n'control.gravity' = [0.0, -9.81]\n"
        '[sample]\nfile = "column_calibration.csv"\ncount = 3\n'
        "[sample.parameters]\n"
        '"joint[bed].friction_angle" = {distribution = "uniform", low = 20, high = 40}\n'
    )
    assert main(["study", "study.toml", "-q"]) == 0
    import xarray as xr

    with xr.open_dataset("study_study/table.nc") as table:
        assert table.sizes["sample"] == 3 and np.ptp(table.friction_angle.values) > 0
        read = np.loadtxt("column_calibration.csv", delimiter=",", skiprows=2, max_rows=3)
        assert np.array_equal(table.shear_stiffness_per_area, read[:, 0])


def test_the_column_of_the_gallery(root, capsys, tmp_path):
    """Its command finds stiffnesses that meet both frequencies, and one combination of them."""
    text = (root / "docs/gallery.md").read_text()
    command = shlex.split(re.search(r"^sitedda (calibrate .*) -o", text, re.M)[1])
    command[1:3] = [str(root / file) for file in command[1:3]]
    assert main([*command, "-o", str(tmp_path / "modes.png")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    frequencies = [float(f) for f in re.findall(r"measured, (\S+) Hz computed", printed)]
    assert frequencies == pytest.approx([1.27, 6.5], rel=0.005)
    assert "only a combination of boundary[ground]" in printed
