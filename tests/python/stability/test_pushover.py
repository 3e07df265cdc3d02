# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushover: command, studies, rejected input."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text
from test_layout import overlaps

from sitedda import InputError
from sitedda.stability import Pushover, performance_point, pushover
from sitedda.study import eurocode8, eurocode8_2024
from sitedda_evidence.validation.pushed import tower


def test_the_command_prints_draws_and_writes_the_curve(tmp_path, main):
    tower().write(tmp_path / "tower.nml")
    process = main.ok("pushover", "tower.nml", "--point", "top", "--steps", "20", "--limits",
                   "--displacement", "0.1", folder=tmp_path)  # fmt: skip
    assert "peak: horizontal load / weight 0.25" in process.stdout
    assert "0.25 without dilation (lowest of 3 starts), 0.25 with dilation" in process.stdout
    assert (tmp_path / "tower_pushover.png").exists()
    head, *rows = (tmp_path / "tower_pushover.csv").read_text().splitlines()
    assert head.startswith("displacement (m),largest (m),factor (1)")
    assert len(rows) > 20


def test_a_bad_spectrum_is_refused_before_the_run(tmp_path, main):
    tower().write(tmp_path / "tower.nml")
    process = main("pushover", "tower.nml", "--point", "top", "--ec8", "2", "Z", folder=tmp_path)
    assert process.returncode == 1 and "'Z'" in process.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["tower.nml"]


def test_a_method_without_a_spectrum_is_refused(tmp_path, main):
    tower().write(tmp_path / "tower.nml")
    process = main("pushover", "tower.nml", "--point", "top", "--method", "n2", folder=tmp_path)
    assert process.returncode == 1 and "--method n2 requires a spectrum" in process.stderr


@pytest.mark.parametrize("value", [-2.0, 0.0, math.nan, math.inf, "strong"])
def test_accelerations_of_spectra_are_positive(value):
    with pytest.raises(InputError, match=f"peak = {value}"):
        eurocode8(value)
    arguments = {"plateau": 1.0, "one_second": 1.0, "factors": (1.0, 1.0)}
    for name in arguments:
        wrong = (1.0, value) if name == "factors" else value
        with pytest.raises(InputError, match=f"{name} = {value}"):
            eurocode8_2024(**arguments | {name: wrong})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"point": "roof"}, "'roof' is not the name of a &measured_point; there are top"),
        ({"load": "wind"}, "load = 'wind'"),
        ({"sense": 0}, "sense = 0"),
        ({"displacement": -1.0}, "displacement"),
        ({"steps": 0}, "steps"),
        ({"changes": {"control.gravity": (0.0, 0.0)}}, "requires gravity"),
    ],
)
def test_invalid_arguments_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        pushover(tower(), **{"point": "top"} | values)


STUDY = """
model = "tower.nml"
parameters = {friction = {changes = "joint[dry].friction_angle", values = [8.0, 40.0]}}
pushover = {point = "top", displacement = 0.05, steps = 20, limits = true}
"""


def test_a_study_runs_a_pushover_of_each_case(tmp_path, main):
    """Sliding at tan 8° or rocking at width over height: the peaks are between the limits."""
    import xarray

    tower().write(tmp_path / "tower.nml")
    (tmp_path / "push.toml").write_text(STUDY)
    main.ok("study", str(tmp_path / "push.toml"), "--quiet")
    table = xarray.load_dataset(tmp_path / "push_study" / "table.nc")
    alone = pushover(tower(), "top", displacement=0.05, steps=20)
    assert table.peak_factor.values[1] == alone.peak
    assert table.peak_factor.values[0] == pytest.approx(math.tan(math.radians(8)), rel=0.02)
    assert (table.peak_factor <= table.limit_upper * 1.02).all()
    assert (table.peak_factor >= table.limit_lower * 0.98).all()


def test_the_page_of_the_facade_begins_with_its_verdict(tmp_path, main, root):
    """A short form of the shipped study; each of its files has at most 30 lines."""
    model, study = (root / "inputs" / name for name in ("facade.nml", "studies/facade.toml"))
    lines = [line for file in (model, study) for line in file.read_text().splitlines()]
    assert sum(bool(line.strip()) and line[0] not in "!#" for line in lines) <= 30
    short = study.read_text().replace("../", f"{root}/inputs/").replace("= 8.0", "= 4.5")
    short = short.replace("[2.5, 3.5, 4.5, 5.5]", "[0.5, 2.5]").replace("count = 12", "count = 2")
    (tmp_path / "facade.toml").write_text(short)
    main.ok("study", "facade.toml", "--report", "--quiet", folder=tmp_path)
    page = (tmp_path / "facade_study" / "report.html").read_text()
    text = " ".join(re.sub(r"<(style|script).*?</\1>|<[^>]+>", " ", page, flags=re.S).split())
    assert "No curve: no case failed" in text[:250] and "At pga 2.5 m/s²" in text[:250]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('point = "top", ', "", r"\[pushover\] point is missing"),
        ("limits = true", 'load = "up"', "load = 'up'"),
        ("steps = 20", "steps = 0", "steps"),
        ("model =", 'task = "safety"\nmodel =', "remove the keys `task` and `results`"),
        ("model =", "solve = {}\nmodel =", "are two tasks"),
        ("limits", "limit", "did you mean 'limits'"),
    ],
)
def test_bad_tables_of_a_pushover_are_refused(tmp_path, old, new, message):
    from sitedda.study.settings import read_settings

    tower().write(tmp_path / "tower.nml")
    file = tmp_path / "push.toml"
    file.write_text(STUDY.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        read_settings(file)


def ideal(curve, sense=1) -> Pushover:
    """Pushover of one block: rows of displacement (m) of the measured point and load / weight."""
    displacement, factor = np.array(curve, dtype=float).T
    none = np.zeros(len(displacement))
    change = displacement[-1] - displacement[int(np.argmax(factor))] or displacement[-1]
    displacements = np.array([[sense * change, 0.0, 0.0]])
    return Pushover("horizontal", sense, "top", displacement, displacement, factor, none, none, 2e3,
                    ("one",), ("slides",), displacements, ("slides",), [np.zeros((3, 2))], "",
                    np.array([2e3]), 10.0)  # fmt: skip


@pytest.mark.parametrize("sense", [1, -1])
def test_an_ideally_plastic_oscillator(sense):
    """T* = 2π √(d_y/a_y); equal displacements above T_C, and larger by q below: closed forms."""
    for yielding, peak in ((0.05, 2.0), (0.005, 4.0)):
        curve = ideal([(0, 0), (0.5 * yielding, 0.1), (yielding, 0.2), (0.4, 0.2)], sense)
        point = performance_point(curve, eurocode8(peak, "A"))
        period = 2 * math.pi * math.sqrt(yielding / 2.0)
        elastic = float(eurocode8(peak, "A")(period))
        demand = elastic * (period / (2 * math.pi)) ** 2
        if period < 0.4:
            q = elastic / 2.0
            demand = demand / q * (1 + (q - 1) * 0.4 / period)
        assert point.period == pytest.approx(period, rel=1e-3)
        assert point.demand == pytest.approx(demand, rel=2e-3)
        assert point.at_point == pytest.approx(demand, rel=2e-3)
        assert point.capacity == 0.4 and point.stands and point.margin > 1
        table = np.linspace(0.01, 5, 5000)
        second_point = performance_point(curve, (table, eurocode8(peak, "A")(table)))
        assert second_point.demand == pytest.approx(point.demand, rel=1e-2)
    assert not performance_point(curve, eurocode8(400.0, "D")).stands


def test_participation_of_masses_that_move_unequally():
    """Masses 1 and 3, φ = 1 and ½: Γ = 2.5/1.75; the resistance is λ g."""
    base_curve = ideal([(0, 0), (0.05, 0.2), (0.4, 0.2)])
    changed_curve = replace(base_curve, mass=4.0, masses=np.array([1.0, 3.0]),
                    mechanism=np.array([[0.35, 0, 0], [0.175, 0, 0]]))  # fmt: skip
    point = performance_point(changed_curve, eurocode8(1.0))
    assert point.at_point / point.demand == pytest.approx(2.5 / 1.75, rel=1e-9)
    assert point.curve[-1] == pytest.approx((0.4 * 1.75 / 2.5, 2.0), rel=1e-9)


@pytest.mark.parametrize("load", ["horizontal", "tilt", "mode"])
def test_the_load_does_not_change_the_resistance_of_a_stack(load):
    """A stack of 0.8 m × 6 m topples as one block: a* = g b/h under each pattern of forces."""
    model, bottom = tower(), 0.0
    model.remove(model["block.tower"])
    for i, height in enumerate((1.0, 2.0, 1.0, 2.0)):
        top = bottom + height
        model.block([0, bottom, 0.8, bottom, 0.8, top, 0, top], name=f"stone {i}")
        bottom = top
    model["joint.dry"](friction_angle=70.0)
    model["measured_point.top"](x=0.4, y=6.0, block="stone 3")
    curve = pushover(model, "top", load=load, displacement=0.85, steps=100)
    point = performance_point(curve, eurocode8(2.0, "C"), method="mechanism")
    assert point.curve[:, 1].max() == pytest.approx(9.81 * 0.8 / 6.0, rel=5e-3)


def test_the_capacity_of_n2_is_between_two_rows_or_before_a_drop():
    """The curve falls by 0.04 in 0.02 m from 0.4 m: 0.8 of the peak at 0.42 m."""
    rise = [(0, 0), (0.05, 0.2), (0.4, 0.2)]
    for row, capacity in (((0.43, 0.14), 0.42), ((0.5, 0.14), 0.4)):
        point = performance_point(ideal([*rise, row]), eurocode8(1.0))
        assert point.capacity == pytest.approx(capacity, rel=1e-9)
        # equal areas: K d_y (d_u − d_y/2) = energy
        (yielding, strength), fall = point.equivalent[1], capacity - 0.4
        energy = 0.5 * 0.05 * 2.0 + 0.35 * 2.0 + fall * 1.8
        assert strength * (capacity - 0.5 * yielding) == pytest.approx(energy, rel=1e-9)


def test_n2_doubts_the_period_of_a_rocking_block():
    """T* of N2 is proportional to 1/√k of the contacts; the secant period is not."""
    periods = {"n2": [], "mechanism": []}
    for stiffness in (1e9, 1e11):
        model = tower()
        model.contact(normal_stiffness=stiffness)
        curve = pushover(model, "top", displacement=0.45, steps=60)
        for method in periods:
            point = performance_point(curve, eurocode8(2.0, "B"), method=method)
            periods[method].append(point.period)
            assert ("normal_stiffness" in point.doubt) is (method == "n2")
            assert ("doubt" in str(point)) is (method == "n2")
    assert periods["n2"][0] > 5 * periods["n2"][1]
    assert periods["mechanism"][0] == pytest.approx(periods["mechanism"][1], rel=0.01)
    assert not performance_point(ideal([(0, 0), (0.05, 0.2), (0.4, 0.1)]), eurocode8(1.0)).doubt


def test_a_rocking_block_agrees_with_the_italian_code(tmp_path, main):
    """d₀ = b/2 of the centroid, a_s = g tan(α − θ_s), T_s = 2π √(d_s/a_s) with d_s = 0.16 d₀."""
    model, (width, height) = tower(), (0.5, 2.0)
    curve = pushover(model, "top", displacement=0.45, steps=150)
    point = performance_point(curve, eurocode8(2.0, "B"), method="mechanism")
    at, radius = 0.16 * 0.5 * width, 0.5 * math.hypot(width, height)
    strength = 9.81 * math.tan(math.asin(0.5 * width / radius - at / radius))
    assert point.period == pytest.approx(2 * math.pi * math.sqrt(at / strength), rel=5e-3)
    assert point.capacity == pytest.approx(0.4 * 0.5 * width, rel=1e-2)  # finite rotation
    demand = float(eurocode8(2.0, "B")(point.period)) * (point.period / (2 * math.pi)) ** 2
    assert point.demand == pytest.approx(demand, rel=1e-9)
    model.write(tmp_path / "tower.nml")
    process = main.ok("pushover", "tower.nml", "--point", "top", "--displacement", "0.45",
                      "--steps", "60", "--ec8", "2", "B", "--method", "mechanism",
                      folder=tmp_path)  # fmt: skip
    assert "performance: fails (mechanism): demand" in process.stdout or "stands" in process.stdout
    assert (tmp_path / "tower_pushover_performance.png").exists()


@pytest.mark.parametrize(
    ("spectrum", "method", "message"),
    [
        (eurocode8(1.0), "ads", "method = 'ads'"),
        (([1.0, 0.5], [1, 1]), "n2", "ascending periods"),
        (([0.1], [1]), "n2", "ascending periods"),
        (eurocode8(1.0), "mechanism", "increase the displacement"),
    ],
)
def test_invalid_spectra_and_methods_are_refused(spectrum, method, message):
    with pytest.raises(InputError, match=message):
        performance_point(ideal([(0, 0), (0.05, 0.2), (0.4, 0.2)]), spectrum, method=method)


@pytest.mark.parametrize("last", [0.1, 0.098, 0.102])
def test_a_plateau_is_not_a_rocking_mechanism(last):
    """Resistance that falls to a half and remains there does not vanish."""
    curve = ideal([(0, 0), (0.01, 0.2), (0.05, 0.1), (0.31, 0.1), (0.4, last)])
    with pytest.raises(InputError, match="increase the displacement, or use 'n2'"):
        performance_point(curve, eurocode8(1.0), method="mechanism")


def test_a_block_that_moves_farther_than_the_point_is_named():
    model = tower()
    model.measured_point("still", 0.0, -0.5, "floor")
    curve = pushover(model, "still", displacement=0.02, steps=10)
    assert "has moved by" in curve.ending and "while 'still' moved by" in curve.ending
    assert curve.ending.split()[0] in curve.names
    figure = curve.draw()
    texts = " ".join(text.get_text() for text in figure.findobj(Text))
    assert overlaps(figure) == [] and curve.ending in " ".join(texts.split())


def test_a_point_outside_the_mechanism_is_refused():
    curve = replace(ideal([(0, 0), (0.05, 0.2), (0.4, 0.2)]), largest=np.array([0.0, 1.0, 9.0]))
    with pytest.raises(InputError, match="moves by less than 0.1"):
        performance_point(curve, eurocode8(1.0))
