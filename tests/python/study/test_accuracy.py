# SPDX-License-Identifier: GPL-3.0-or-later
"""Results with error bars: their computation, and exact values within them."""

import importlib.util
import json
import math
import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sitedda
from sitedda.base.numbers import number, with_bar
from sitedda.error_bars import stored_accuracy
from sitedda.error_bars.bars import bar_of_steps, penalty_error
from sitedda.error_bars.figures import YIELD, Accuracy
from sitedda.error_bars.horizon import _mark_undecided, horizon
from sitedda.error_bars.linear import is_linear
from sitedda.error_bars.measure import _estimate_figures
from sitedda.error_bars.variants import Facts, facts_of
from sitedda.output import load
from sitedda.report import to_html
from sitedda.study.page import report_page
from sitedda.study.quantities import measure, quantities_of
from sitedda_evidence.validation.error_bars import PUSH, SLIDE, G

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("order", [1, 2])
def test_changes_of_the_scheme_give_the_limit(order):
    a, b, c = (5.0 + 0.8 * h**order for h in (0.1, 0.05, 0.025))
    bar = bar_of_steps(a, b, c, order)
    assert bar.order == pytest.approx(order, abs=1e-9)
    assert bar.extrapolated == pytest.approx(5.0, rel=1e-12)
    assert abs(c - 5.0) < bar.half
    assert bar.half == pytest.approx(max(3.0 * abs(b - c), 1e-3 * abs(a)), rel=1e-12)


@pytest.mark.parametrize(
    ("steps", "converges", "half"),
    [
        ((1.1, 1.0, 1.0001), True, 3.0 * 0.1 / 4.0),  # a last change that is small by chance
        ((1.0, 1.02, 0.97), False, 0.15),
        ((1.0, 2.0, 9.0), False, math.nan),
        # A bar of 0.1 % from changes of 0.03 % was off by 0.4 %: late flutter of contact springs.
        ((1.0, 1.0001, 1.0004), False, 1e-3 * 1.0004),
        ((2.0, 2.0, 2.0), True, 2e-3),
        ((1.0, 1.1, math.nan), False, math.nan),  # a run that failed
    ],
)
def test_irregular_changes_give_wider_bars(steps, converges, half):
    bar = bar_of_steps(*steps, 1)
    assert bar.converges is converges
    assert bar.half == pytest.approx(half, nan_ok=True)
    assert math.isnan(bar.extrapolated) or steps == (2.0, 2.0, 2.0)


@pytest.mark.parametrize(
    ("name", "runs", "doubt", "bar"),
    [
        ("largest_velocity_m_s", (0.1904, 0.19042, 0.19046, 0.1903),
         "does not converge: 0.1904, 0.1904, 0.1905 at Δt, Δt/2, Δt/4", 1.904600e-4 + 2e-4),
        # Only smaller time steps reveal this.
        ("largest_opening_m", (0.0, 0.0, 0.1),
         "does not converge: 0, 0, 0.1 at Δt, Δt/2, Δt/4", math.nan),
        ("largest_contact_force_n_m", (1.0, 2.0, 4.0),
         "grows as 1/Δt, an impact: 1, 2, 4 at Δt, Δt/2, Δt/4", math.nan),
        ("largest_tilt_rad", (1.0, 2.0, 4.0),
         "does not converge: 1, 2, 4 at Δt, Δt/2, Δt/4", math.nan),
        ("contacts_slipped", (3.0, 3.0, math.nan),
         "no error bar: some runs do not have this result", math.nan),
        # A residual of 1e-8 m that 4 k_n divides by four is not a movement of the model.
        ("residual_displacement_m", (1.0e-8, 1.1e-8, 1.3e-8, 0.25e-8),
         "only the compression of contact springs", 3 * 0.2e-8 + 1.5e-8),
        ("largest_slip_m", (1.0, 1.015, 1.025, 0.95),
         "the error bar is due to the penalty stiffness", 3 * 0.01 + 0.1),
    ],
)  # fmt: skip
def test_results_of_runs_have_bars_and_doubts(name, runs, doubt, bar):
    penalty = 1e9 if len(runs) == 4 else 0.0
    figure = _estimate_figures(Facts({}, 1, penalty), [{name: value} for value in runs])[name]
    assert figure.doubt == doubt
    assert figure.bar == pytest.approx(bar, rel=1e-6, nan_ok=True)
    assert figure.finest == pytest.approx(runs[2], nan_ok=True)


def test_results_after_the_horizon_are_random_samples():
    runs = [{"largest_slip_m": value} for value in (1.0, 1.1, 0.8)]
    figure = _estimate_figures(Facts({}, 1, 0.0), runs)["largest_slip_m"]
    assert _mark_undecided(figure, 2.0, 3.0) is figure
    undecided = _mark_undecided(figure, 3.5, 3.0)
    assert undecided.doubt.startswith("beyond the horizon of 3 s, a random sample: 1, 1.1, 0.8")
    assert undecided.bar == figure.bar
    runs[2]["largest_slip_m"] = 1.12
    limit = _estimate_figures(Facts({}, 1, 0.0), runs)["largest_slip_m"]
    decided_figure = replace(limit, decided=2.5)
    assert _mark_undecided(decided_figure, 2.0, 1.0) is decided_figure
    doubt = _mark_undecided(decided_figure, 3.0, 1.0).doubt
    assert doubt == "beyond the horizon of 2.5 s, a random sample"
    yielding_figure = replace(decided_figure, doubt=YIELD)
    assert _mark_undecided(yielding_figure, 2.0, 3.0) is yielding_figure
    assert _mark_undecided(yielding_figure, 3.5, 3.0).doubt.startswith("beyond the horizon of 3 s")
    penalty_figure = _mark_undecided(decided_figure, 3.0, 1.0)
    doubts_of_both = Accuracy({"a": undecided, "b": penalty_figure}).doubts()
    assert doubts_of_both == [("bars", "beyond the horizon (first: 2.5 s), random samples: a, b")]


@pytest.mark.parametrize("damping, message", [("", "only numerical damping"),
                                            (", damping = 1e5", "depend on the time")])  # fmt: skip
def test_missing_convergence_has_a_cause(write_input, damping, message):
    file = write_input(SLIDE.replace("restitution = 0", f"tensile_strength = 0{damping}"))
    values = {1.5e-2: 1.0, 7.5e-3: 1.1, 3.75e-3: 0.8}

    def alternating_result(run) -> float:
        return values[round(run.history.time_step.values[-1], 6)]

    figures = sitedda.accuracy(file, alternating_result, changes={"time_step": 1.5e-2}, workers=1)
    assert message in figures.cause
    assert figures.cause in str(figures)
    assert figures.cause in figures.doubts()[-1][1]


@pytest.mark.parametrize("fraction", [0.03, -0.2])
def test_error_due_to_the_penalty(fraction):
    error = abs(fraction)
    assert penalty_error(2.0 + fraction, 2.0 + fraction / 2.0) == pytest.approx(error, rel=1e-12)
    assert penalty_error(2.0 + fraction, 2.0 + fraction / 4.0) == pytest.approx(1.5 * error)


@pytest.mark.parametrize(
    "value, bar, message",
    [
        (0.13239, 0.00052, "0.13239 ± 0.00052"),
        (615.2, 94.0, "615 ± 94"),
        (123456.0, 1200.0, "123500 ± 1200"),
        (2.5e-7, 1.3e-8, "(2.50 ± 0.13)e-7"),
        (0.0, 0.0, "0 ± 0"),
        (3.14159, math.nan, "3.142 (no error bar)"),
        (-0.04218, 0.00018, "-0.04218 ± 0.00018"),
    ],
)
def test_numbers_have_the_digits_of_their_bar(value, bar, message):
    assert with_bar(value, bar) == message


@pytest.mark.parametrize(
    "value, message",
    [(0.0, "0"), (0.123456, "0.1235"), (12.5, "12.5"), (123456.0, "123456"), (-2e-7, "-2e-7"),
     (1.23456e12, "1.235e12"), (math.inf, "inf")],
)  # fmt: skip
def test_numbers_have_four_digits(value, message):
    assert number(value) == message


def test_runs_for_error_bars_are_kept(write_input, tmp_path):
    file = write_input(SLIDE)
    figures = sitedda.accuracy(file, folder=tmp_path / "runs")
    assert list(figures.runs) == ["dt", "dt/2", "dt/4", "4 k_n", "twin"]
    assert not any(figures.runs.values())
    assert figures["largest_slip_m"].run == sitedda.run(file).verdict.values["largest_slip_m"]
    assert json.loads(json.dumps(figures.to_dict()))["figures"]["largest_slip_m"]["bar"] > 0
    times = {p: p.stat().st_mtime_ns for p in (tmp_path / "runs" / "cases").rglob("*.json")}
    assert sitedda.accuracy(file, folder=tmp_path / "runs").figures.keys() == figures.figures.keys()
    assert times == {p: p.stat().st_mtime_ns for p in times}


def test_measured_stiffness_is_no_penalty(write_input):
    text = SLIDE.replace("restitution = 0", "normal_stiffness_per_area = 2e11")
    figures = sitedda.accuracy(write_input(text), "largest_slip_m", changes={"time_step": 5e-3})
    assert list(figures.runs) == ["dt", "dt/2", "dt/4", "twin"]
    assert figures["largest_slip_m"].penalty == 0.0


def test_steps_and_stages_are_divided(write_input):
    text = SLIDE.replace("duration = 1.5, ", "").replace(", settle = .true.", "")
    text = text.replace("time_step = 2e-3", "time_step = 1e-2")
    text += "&stage name = 'one', steps = 8 /\n"
    text += "&stage name = 'two', time_step = 5e-3, duration = 0.1 /\n"

    def count(run) -> float:
        return run.history.sizes["time"]

    table = sitedda.accuracy(write_input(text), count, workers=1)
    assert [round(table["count"].run), round(table["count"].finest)] == [8 + 20 + 1, 4 * 28 + 1]


def test_an_existing_run_is_not_repeated(write_input, tmp_path):
    """The output of a run with less friction is used as "this run"."""
    file = write_input(SLIDE.replace("time_step = 2e-3", "time_step = 5e-3"))
    other = sitedda.run(file, tmp_path / "o.nc", changes={"joint.friction_angle": 15.0})
    figures = sitedda.accuracy(file, "largest_slip_m", output=other.output, workers=1)
    figure = figures["largest_slip_m"]
    assert figure.run == other.verdict.values["largest_slip_m"] > 1.1 * figure.finest


def test_runs_print_their_error_bars(write_input, python_program, tmp_path):
    file = write_input(SLIDE.replace("time_step = 2e-3", "time_step = 5e-3"))
    options = ("--quiet", "--set", "joint.friction_angle=25")
    process = python_program.ok("accuracy", file, *options)
    assert "largest_slip_m" in process.stdout
    assert " ± " in process.stdout
    run = sitedda.run(file, changes={"joint.friction_angle": 25.0})
    lines = process.stdout.splitlines()
    line_of_slip = next(line for line in lines if line.startswith("largest_slip_m"))
    assert str(run.accuracy()["largest_slip_m"]) in line_of_slip
    options = ("--accuracy", "-q", "--no-plot", "-o", tmp_path / "o.nc", "--report")
    process = python_program.ok("run", file, *options)
    assert " ± " in process.stdout
    slip = stored_accuracy(load(tmp_path / "o.nc").attrs)["largest_slip_m"]
    line_of_slip = with_bar(1e3 * slip.finest, 1e3 * slip.bar)
    assert re.search(rf"^slip +{re.escape(line_of_slip)} mm", process.stdout, re.M)
    assert str(slip) in (tmp_path / "o.html").read_text()


def test_equal_warnings_of_runs_are_printed_once():
    runs = {"dt": "solver: 3 of 9 steps\nstart: sudden", "dt/2": "solver: 1.5e-3 of 9 steps",
            "b": ""}  # fmt: skip
    warnings_of_runs = ["runs dt, dt/2: solver: 3 of 9 steps", "run dt: start: sudden"]
    figures = Accuracy({}, runs)
    assert str(figures).splitlines()[1:] == warnings_of_runs
    assert [doubt.words for doubt in figures.doubts()] == warnings_of_runs


def test_an_input_error_is_reported_without_a_traceback(write_input, python_program):
    file = write_input(SLIDE.replace("friction_angle", "frictoin_angle"))
    process = python_program("accuracy", str(file), "-q")
    assert process.returncode == 1
    assert "frictoin_angle" in process.stderr
    assert "Traceback" not in process.stderr


@pytest.fixture(scope="module")
def error_bars():
    """Load the study of random cases."""
    path = ROOT / "tests" / "robustness" / "error_bars.py"
    spec = importlib.util.spec_from_file_location("error_bars_study", path)
    study = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(study)
    return study


def test_random_pairs_lie_within_their_bars(capsys, error_bars):
    assert error_bars.main(["--pairs", "4", "--seed", "3"]) == 0, capsys.readouterr().out


@pytest.mark.filterwarnings("ignore::sitedda.PeakWarning")
def test_a_random_linear_column_lies_within_its_bars(capsys, error_bars):
    assert error_bars.main(["--columns", "1"]) == 0, capsys.readouterr().out


@pytest.mark.filterwarnings("ignore::sitedda.PeakWarning")
def test_bars_of_a_linear_run_are_those_of_runs(write_input, error_bars):
    """The transfer function gives the limit of runs with Δt/2, Δt/4 and 4 k_n."""
    file = write_input(error_bars.column(random.Random(1003))[0])
    names = [f"{name}[surface]" for name in ("pgv_m_s", "pga_resolved_m_s2", "sa_resolved_m_s2")]
    run = sitedda.run(file)
    assert run.history.attrs["contacts_changed"] == "no"
    figures = run.accuracy()
    assert figures.runs == {}
    traction = "&traction side = 'top', normal = 1e3 /\n"
    loaded = write_input(f"{file.read_text()}{traction}", "loaded.nml")
    assert is_linear(run.history, facts_of(file, {}))
    assert not is_linear(run.history, facts_of(loaded, {}))
    runs = sitedda.accuracy(file, names, workers=2)
    for name in names:
        one, other = figures[name], runs[name]
        assert one.run == pytest.approx(other.run, rel=1e-12)
        limit = other.finest if math.isnan(other.extrapolated) else other.extrapolated
        assert one.finest == pytest.approx(limit, rel=1e-2)
        assert one.bar < 0.25 * other.bar  # with a transfer function, small steps cost no time
    doubt = figures["largest_displacement_m"].doubt
    assert doubt == "no error bar: in a linear run only measured points have error bars"


def test_an_undamped_resonance_does_not_converge():
    file = ROOT / "inputs" / "layered_site.nml"
    figures = sitedda.accuracy(file, changes={"control.steps": 12000})
    doubt = figures["amplification"].doubt
    assert doubt.startswith("does not converge: 466.2, 932.5, 1865 at Δt/16, Δt/32, Δt/64")
    assert "only numerical damping" in figures.cause


def test_a_history_is_predictable_until_it_diverges():
    time = np.linspace(0.0, 10.0, 1001)
    run = np.minimum(time, 4.0)
    twin = run + 1e-9 * np.exp(4.0 * time)
    divergence_time = np.log(0.01 * 4.0 / 1e-9) / 4.0
    assert horizon(time, run, twin) == pytest.approx(divergence_time, abs=0.011)
    assert horizon(time, run, run + 0.009) == math.inf
    nothing = np.full(1001, math.nan)
    assert horizon(time, nothing, nothing) == math.inf


def test_a_displaced_block_keeps_its_bonds(write_input):
    text = SLIDE.replace("restitution = 0", "cohesion = 1e6, tensile_strength = 1e6")
    file = write_input(text.replace("base_motion_x = 'push'", "base_motion_x = ''"))
    positions = []
    for displacement in (0.0, 1e-7):
        changes = {"control.displaced_block": "block",
                   "control.displaced_by": (2 * displacement, displacement)}  # fmt: skip
        with sitedda.Simulation(file, changes=changes) as run:
            positions.append(run.coordinates[1])
            run.advance(1)
            assert run.contacts["bonded"].all()
            assert not run.warning
    offset = positions[1] - positions[0]
    size = math.sqrt(2.0)
    assert offset[:2] == pytest.approx([2e-7 * size, 1e-7 * size], rel=1e-6)
    assert not offset[2:].any()


def test_a_twin_displaces_no_block_that_stages_remove(write_input):
    """Otherwise the twin would equal the run, and all results would seem predictable."""
    text = SLIDE.replace("duration = 1.5, ", "").replace("settle = .true.,", "")
    text = text.replace("base_motion_x = 'push'", "")
    text += "&block name = 'top', vertices = -1 1 1 1 1 2 -1 2 /\n"
    text += "&stage name = 'rest', kind = 'static' /\n"
    text += "&stage name = 'dig', kind = 'static', remove = 'to*' /\n"
    model = write_input(f"{text}&stage name = 'shake', steps = 5, motions = 'push' /\n")
    assert facts_of(model, {}).remaining == (2, 1)  # block, floor
    with (
        pytest.raises(sitedda.InputError, match="'top', which is removed before"),
        sitedda.Simulation(model, changes={"control.displaced_block": "top"}) as run,
    ):
        run.advance(5)


def test_a_displaced_block_must_exist(write_input):
    with pytest.raises(sitedda.InputError, match="displaced_block = 'blok' is not the name"):
        sitedda.Simulation(write_input(SLIDE), changes={"control.displaced_block": "blok"})


PILE = f"""
&control time_step = 1e-3, duration = 3, gravity = 0, -{G}, base_motion_x = 'shake' /
&material density = 2500, young_modulus = 5e8, poisson_ratio = 0.2 /
&joint friction_angle = 25, restitution = 0.6 /
&block name = 'floor', vertices = -6 -1 6 -1 6 0 -6 0 /
&block name = 'left', vertices = -6 0 -4 0 -4 4 -6 4 /
&block name = 'right', vertices = 4 0 6 0 6 4 4 4 /
&fixed_point x = -6, y = -1, block = 'floor' /
&fixed_point x = 6, y = -1, block = 'floor' /
&fixed_point x = -6, y = 0, block = 'left' /
&fixed_point x = -6, y = 4, block = 'left' /
&fixed_point x = 6, y = 0, block = 'right' /
&fixed_point x = 6, y = 4, block = 'right' /
&motion name = 'shake', quantity = 'acceleration', drift_order = 0, time_step = 0.01,
        values = {" ".join(f"{6 * math.sin(0.15 * i):.4f}" for i in range(300))} /
"""


def pile(seed: int = 5) -> str:
    """Return random blocks that fall between two walls."""
    rng, text = np.random.default_rng(seed), PILE
    for row in range(3):
        for column in range(4):
            x, y = -3.0 + 1.9 * column + 0.2 * row, 0.6 + 1.6 * row
            angle = rng.uniform(0.0, 2.0 * math.pi / 5.0)
            corners = [angle + 2.0 * math.pi * k / 5.0 for k in range(5)]
            sides = rng.uniform(0.4, 0.7, size=2)
            coordinates = " ".join(f"{x + sides[0] * math.cos(c):.6f} {y + 0.6 * math.sin(c):.6f}"
                              for c in corners)  # fmt: skip
            text += f"&block name = 'b{row}{column}', vertices = {coordinates} /\n"
    return text


def histories_of(file, output, block: str):
    """Return histories of results with a displaced block."""
    changes = {"control.displaced_block": block} if block else {}
    sitedda.run(file, output, changes=changes)
    return measure(output, quantities_of("histories"))[1]


def test_displaced_blocks_show_the_same_horizon(write_input, tmp_path):
    file, output = write_input(pile()), tmp_path / "o.nc"
    run, *twins = (histories_of(file, output, block) for block in ("", "b00", "b13", "b21", "b23"))
    times = run["history_energy_kinetic"].coordinates["look"]

    def horizons(name):
        return [horizon(times, run[name].values, twin[name].values) for twin in twins]

    motions = horizons("history_energy_kinetic")
    assert 1.0 < min(motions) and max(motions) < 1.2 * min(motions)
    for name in run:  # not before the motions, in which a shift of 1e-9 grows
        assert min(horizons(name)) > 0.8 * min(motions), name


def test_an_ensemble_gives_bands(write_input):
    file = write_input(pile(4))
    results = ["largest_displacement_m", "residual_displacement_m"]
    changes = {"control.duration": 2.0}
    figures = sitedda.accuracy(file, results, ensemble=3, changes=changes, workers=2)
    largest = figures["largest_displacement_m"]
    assert 1.0 < largest.decided < 1.8
    assert 1.0 < figures["residual_displacement_m"].decided <= 2.0
    assert largest.low < largest.median < largest.high
    band = figures.bands["largest_displacement_m"]
    assert band.median[-1] == pytest.approx(largest.median)
    assert band.high[100] - band.low[100] < 1e-6
    assert "predictable until" in str(figures)
    panels = [axes for axes in figures.draw().axes if axes.get_visible()]
    assert [axes.get_title() for axes in panels] == ["largest displacement (m)"]
    assert "16–84 % of twins" in [text.get_text() for text in panels[0].get_legend().texts]
    assert list(figures.runs)[-3:] == ["twin 1", "twin 2", "twin 3"]


def test_bands_are_stored_and_shown(write_input, python_program, tmp_path):
    file, output = write_input(SLIDE), tmp_path / "o.nc"
    python_program.ok("run", str(file), "--ensemble", "2", "-q", "--no-plot", "--report", "-o",
                      str(output), "--set", "duration=0.5")  # fmt: skip
    stored_figures = stored_accuracy(load(output).attrs)
    band = stored_figures.bands["largest_slip_m"]
    assert band.time[-1] == pytest.approx(0.5, abs=0.01) and len(band.time) <= 200
    assert (band.low <= band.high).all() and band.median[-1] > 0.01
    printed_text = str(stored_figures["largest_slip_m"])
    python_program.ok("view", str(output), "--no-open", "-o", str(tmp_path / "v.html"))
    for page in ("o.html", "v.html"):
        text = (tmp_path / page).read_text()
        assert printed_text in text and "Results of twins over time" in text


def test_a_study_with_error_bars_contains_horizons(write_input):
    """Random blocks diverge from their twins at about 1.6 s."""
    table = sitedda.study(write_input(pile(4)), {"control.duration": [0.8, 1.8]}, task="accuracy",
                          workers=1)  # fmt: skip
    assert (table.status == "complete").all(), table.message.values
    assert (table.blocks_lost == 0).all() and (table.largest_tilt_rad_bar > 0).any()
    assert table.end_s.values == pytest.approx([0.8, 1.8], rel=1e-3)
    undecided = table.largest_displacement_m_decided_s < table.end_s
    assert undecided.values.tolist() == [False, True]
    warning_texts = [str(warning) for warning in table.warning.values]
    assert "beyond the horizon" not in warning_texts[0] and "beyond the horizon" in warning_texts[1]
    page = to_html(report_page(table))
    displacement, bar = (float(table[f"largest_displacement_m{end}"][1]) for end in ("", "_bar"))
    assert with_bar(displacement, bar) in page


def test_rounding_errors_are_not_reported(write_input):
    resting_input = SLIDE.replace("base_motion_x = 'push'", "base_motion_x = ''")
    run = sitedda.run(write_input(resting_input.replace("1.5,", "0.05,")))
    assert run.verdict.happened.startswith("The model is at rest")
    names = {line.name for line in run.verdict.figures}
    assert not {"displacement", "tilt", "velocity", "point displacement"} & names
    assert 0.0 <= run.verdict.values["largest_displacement_m"] < 2e-8


def test_a_small_motion_of_a_linear_model_is_reported(write_input):
    """Displacements of 1e-12 of the model size are caused by a motion of 1e-10 m."""
    small_input = SLIDE.replace(f"30*{PUSH}", "1e-9 " * 30).replace("1.5,", "0.3,")
    run = sitedda.run(write_input(small_input.replace("0, -9.81", "0, 0")))
    displacement = run.verdict.values["largest_displacement_m"]
    assert 1e-14 < displacement < 1e-9
    assert run.verdict.happened.startswith("Blocks moved by up to ")


def test_studies_contain_the_warnings_of_their_runs(write_input):
    soft_input = SLIDE.replace("young_modulus = 5e9", "young_modulus = 1e6")
    table = sitedda.study(write_input(soft_input), {"contact.normal_stiffness": [4e7, 1e5]},
                          fixed={"control.duration": 0.02}, workers=1)  # fmt: skip
    warning_texts = [str(warning) for warning in table.warning.values]
    assert all(line.startswith("check: ") for line in warning_texts[0].splitlines())
    size = r"check: element size: \d+ blocks, λ/.* at .* Hz, limit λ/12"
    assert re.search(size, warning_texts[0])
    assert "penetration: a vertex of block 2 'block' penetrates" in warning_texts[1]
