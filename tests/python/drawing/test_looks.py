# SPDX-License-Identifier: GPL-3.0-or-later
"""Content of pictures: scales by area, rounding, joints, forces, schemes, kind of the run."""

import json
import re

import matplotlib.image
import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from model_text import group, tower
from test_view import shaken_grid

import sitedda
from sitedda.drawing.forces import resultants
from sitedda.drawing.quantities import limits, rounding
from sitedda.facade.page import report_page
from sitedda.numbers import UNITS, axis_label, in_unit
from sitedda.output.energies import budget
from sitedda.pictures import draw
from sitedda.plot import purpose_of, run_picture
from sitedda.report import Picture, to_html
from sitedda.report.layout import legend_above
from sitedda.scene import Scene
from sitedda.stability.reduction import Mechanism, Safety
from sitedda.style import INK, JOINT_MAP, RESTING, SCHEMES, dress, new_figure, save_picture
from sitedda.vtk import write_vtk


@pytest.fixture
def sliver() -> Scene:
    """Sixty blocks of 1 m² that have moved by up to 0.6 mm, and one of 0.01 m² by 883 mm."""
    data = shaken_grid(61, 2)
    q = data.block_coordinates.values
    q[1] = q[0]
    q[1, :, 0] += 1e-5 * np.arange(61)
    q[1, 60, 0] = q[0, 60, 0] + 0.883
    corners = (data.vertices.values[0] - np.repeat(q[0, :, :2], 4, axis=0)).reshape(61, 4, 2)
    corners[60] *= 0.1
    for frame in (0, 1):
        data.vertices.values[frame] = (q[frame, :, None, :2] + corners).reshape(-1, 2)
    return Scene(data)


def words_of(axes) -> str:
    return axes.texts[-1].get_text()


def bars_of(axes) -> list:
    return [child for child in axes.child_axes if hasattr(child, "_colorbar")]


def test_a_scale_contains_all_values_and_resolves_the_usual_ones():
    area = np.ones(200)
    values = np.linspace(0.0, 1.0, 200)
    bounds = limits(values, area)
    assert bounds.high == bounds.usual == 1.0 and bounds.share(0.25) == pytest.approx(0.25)
    values[7] = 40.0
    bounds = limits(values, area)
    assert bounds.high == 40.0 and bounds.usual == pytest.approx(1.0, abs=0.01)
    assert bounds.share(40.0) == 1.0 and bounds.share(bounds.usual) == pytest.approx(0.7)
    assert bounds.share(20.0) < bounds.share(39.0) < 1.0  # none is beyond an end
    area[7] = 5.0  # more than 1 % of the area is no outlier
    assert limits(values, area).usual == 40.0
    signed_bounds = limits([-3.0, 1.0, 2.0], [1.0, 1.0, 1.0], signed=True)
    assert (signed_bounds.low, signed_bounds.high, signed_bounds.usual) == (-3.0, 3.0, 3.0)
    assert limits(np.zeros((2, 3)), np.ones(3)).most == 0.0


def test_rotations_have_a_sense_and_edges_of_many_blocks_are_faint():
    data = shaken_grid(6400, 2)
    data.block_coordinates.values[1, :, 2] = np.linspace(-0.1, 0.1, 6400)
    axes = draw(Scene(data), color="rotation")
    (bar,) = bars_of(axes)
    assert "anticlockwise positive" in bar.get_title(loc="left")
    blocks = next(c for c in axes.collections if len(c.get_facecolor()) > 0)
    assert max(blocks.get_linewidth()) <= 0.2  # points; wider edges would merge


def test_a_mechanism_is_titled_with_its_own_factor():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    mechanism = Mechanism(1.421, np.zeros((1, 3)), ("slides",), ("dam",), True, [corners])
    axes = Safety(1.39, 1.396, (), mechanism).draw()
    assert axes.get_title(loc="left") == "Factor of safety 1.393"
    assert words_of(axes) == "mechanism with strength divided by 1.421"


def test_one_sliver_does_not_dominate_the_colours_and_is_named(sliver):
    axes = draw(sliver, color="displacement")
    assert "largest: block 61 (0.01 m²) 883 mm" in words_of(axes)
    (bar,) = bars_of(axes)
    assert bar.get_title(loc="left") == "displacement (mm)"
    assert bar._colorbar.vmax == pytest.approx(883.0)
    norm = bar._colorbar.norm
    assert norm(883.0) == pytest.approx(1.0) and norm(0.59) == pytest.approx(0.7)


def test_every_bar_has_three_ticks_and_no_power_of_ten_over_it(run):
    for look in ({"contacts": "slip"}, {"color": "rotation"}, {"color": "velocity", "time": 0.1},
                 {"color": "displacement_x"}, {"color": "tension"}):  # fmt: skip
        axes = draw(run, **look)
        axes.figure.canvas.draw()
        for bar in bars_of(axes):
            low, high = bar.get_ylim()
            ticks = [t for t in bar.get_yticks() if low <= t <= high]
            assert len(ticks) >= 3, look
            assert bar.yaxis.get_offset_text().get_text() == ""


def test_rounding_errors_have_neither_colours_nor_a_bar(write_input):
    """A stack at rest: velocities are rounding errors, and no joint has opened."""
    groups = [(n, {k: v for k, v in g.items() if not k.startswith("motion")})
              for n, g in tower(steps=40, gravity=[0.0, -9.81], settle=True)
              if n != "motion"]  # fmt: skip
    run = sitedda.run(write_input(groups))
    assert "at rest" in str(run.verdict)
    axes = run.draw(color="velocity", contacts="opening")
    assert bars_of(axes) == []
    assert "at rest: velocity below" in words_of(axes) and "no opening of joints" in words_of(axes)
    blocks = [c for c in axes.collections if len(c.get_facecolor()) > 0][0]
    assert {to_hex(c) for c in blocks.get_facecolor()} == {RESTING}
    figure = run_picture(run.history)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["The model", "Forces at the end"]


def test_the_rounding_limit_depends_on_the_load(run):
    scene = Scene.of(run)
    displacement = run.history.attrs["largest_displacement_m"]
    assert rounding(scene)["m"] == pytest.approx(1e-9 * displacement)


def test_joints_that_move_more_are_wider_and_stronger_and_never_dark(run):
    axes = draw(run, color="material", contacts="slip")
    joints = next(c for c in axes.collections
                  if isinstance(c, LineCollection) and c.get_array() is not None)  # fmt: skip
    order = np.argsort(joints.get_array())
    assert (np.diff(np.array(joints.get_linewidths())[order]) >= 0).all()
    light = JOINT_MAP(np.linspace(0, 1, 20))[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light) < 0).all() and light[-1] > 0.1


def test_slip_arrows_have_the_sense_of_the_slip(run):
    """The table is thrown to the right, so the right block slips to the left."""
    scene, last = Scene.of(run), Scene.of(run).frames - 1
    faces, displacement = scene.interfaces, scene.displacement(last)
    for k in np.flatnonzero(scene.joint_movement(last)[0] > 0.01):
        along = faces.end[k] - faces.start[k]
        relative = displacement[faces.second[k]] - displacement[faces.first[k]]
        assert scene.joint_sense(last)[k] == np.sign(along @ relative)


def test_contact_forces_are_dark_lines_and_arrows_have_a_scale(run):
    scene, last = Scene.of(run), Scene.of(run).frames - 1
    *_, presses = resultants(scene, last, scene.vertices(last))
    assert presses.all() and len(presses) == 2
    axes = draw(run, contacts="chain", color="material")
    lines = [c for c in axes.collections if isinstance(c, LineCollection)][-1]
    assert {to_hex(c) for c in lines.get_colors()} == {INK}
    axes = draw(run, contacts="force", color="material", arrows="displacement")
    texts = [t.get_text() for t in axes.findobj(lambda artist: hasattr(artist, "get_text"))]
    assert any(re.match(r"contact force: [125]0* [kM]N/m", t) for t in texts)
    assert any(re.match(r"displacement: [125]0* mm", t) for t in texts)


def test_movement_since_a_stage_excludes_earlier_movement(write_input):
    from test_pictures import excavated

    run = sitedda.run(write_input(excavated()))
    scene = Scene.of(run)
    from sitedda.drawing.quantities import quantity

    since, last = scene.frame_at(None, "dig"), scene.frames - 1
    displacement = scene.displacement(last) - scene.displacement(since)
    assert quantity(scene, "displacement_y", last, since) == pytest.approx(displacement[:, 1])
    axes = draw(run, color="displacement_y", since="dig")
    assert axes.get_xlabel() == "x (m)"
    with pytest.raises(sitedda.InputError, match="stage .* has no frame"):
        draw(run, since="never")


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_figure_has_the_colours_of_its_scheme(run, scheme):
    figure = dress(run_picture(run.history), scheme)
    figure.canvas.draw()
    colours = SCHEMES[scheme]
    assert to_hex(figure.get_facecolor()) == colours["paper"]
    for axes in figure.axes:
        assert not axes.spines["top"].get_visible()
        assert to_hex(axes.xaxis.label.get_color()) == colours["ink"]
        assert to_hex(axes.spines["bottom"].get_edgecolor()) == colours["faint"]
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3].mean(axis=2)
    assert bool(np.median(picture) > 128) is (scheme != "dark")


def test_the_picture_is_of_the_kind_of_the_run(root):
    kinds = {"layered_site": "site", "wall": "shake", "slope": "shake", "arch": "forces",
             "wedge": "forces", "toppling": "forces", "retaining_wall": "forces"}  # fmt: skip
    for name, kind in kinds.items():
        with sitedda.Simulation(root / f"inputs/{name}.nml") as simulation:
            scene = Scene.of(simulation)
            scene.data["time"] = "time", [0.0, 1.0]
            assert purpose_of(scene).kind == kind, name


SMALL_TOWER = """&control time_step = 1e-4, gravity = 0, -9.81 /
&material density = 2000, young_modulus = 5e8, poisson_ratio = 0.2 /
&joint friction_angle = 30 /
&layers name = 'table', left = -0.1, bottom = -0.02, width = 0.2, thickness = 0.02 /
&drums width = 0.02, height = 0.01, count = 2 /
&motion name = 'shake', time_step = 5e-3, quantity = 'acceleration', drift_order = 0,
    values = 0, 1, -1, 0, 0, 0 /
&fixed_point x = -0.09, y = -0.01, motion_x = 'shake' /
&fixed_point x = 0.09, y = -0.01, motion_x = 'shake' /
&measured_point name = 'top', x = 0, y = 0.02 /
&stage name = 'rest', kind = 'static' /
&stage name = 'again', kind = 'static' /
&stage name = 'shake', steps = 200 /
"""


def test_two_static_stages_and_high_frequencies_have_a_picture(tmp_path):
    """Both static stages end at time 0; spectra reach a quarter of the sampling rate."""
    (tmp_path / "tower.nml").write_text(SMALL_TOWER)
    run = sitedda.run(tmp_path / "tower.nml", output=False)
    labels = [axes.get_ylabel() for axes in run_picture(run.history).axes]
    assert "Sa, 5% damping, below 2500 Hz (m/s²)" in labels


def test_spectra_of_a_shake_are_those_of_its_figures(run, root):
    """Only below the frequency that blocks resolve, without impacts of contacts."""
    wall = sitedda.run(root / "inputs/wall.nml", duration=1.6, output=False)
    for history in (run.history, wall.history):
        curves = {c.get_label(): c for axes in run_picture(history).axes for c in axes.lines
                  if axes.get_ylabel().startswith("Sa, 5% damping, below ")}  # fmt: skip
        assert curves
        for label, curve in curves.items():
            name, _, axis = label.rpartition(", ")
            largest = history.attrs[f"sa_resolved_m_s2_{axis}[{name}]"]
            assert curve.get_ydata().max() == pytest.approx(largest, rel=1e-6)
    fallen = sitedda.run(root / "inputs/rocking_blocks.nml", output=False).history
    labels = [c.get_label() for axes in run_picture(fallen).axes for c in axes.lines
             if axes.get_ylabel().startswith("Sa")]  # fmt: skip
    assert labels == ["large, x"]  # the impacts of the others are excluded


def test_the_energy_budget_is_closed(run):
    energies = budget(run.history)
    total = energies.given + energies.residual
    assert sum(energies.parts.values()) == pytest.approx(total, rel=1e-9)
    assert all((values >= 0).all() for values in energies.parts.values())
    assert {"kinetic", "loss by slip"} <= set(energies.parts)


def test_an_output_without_positions_has_a_rounding_limit(sliver):
    sliver.data.vertices.values[:] = 0.0
    sliver.groups["motion"] = [{"name": "shake"}]
    assert sliver.size == 0 and all(np.isfinite(limit) for limit in rounding(sliver).values())


def test_units_of_pages_are_those_of_pictures(root):
    text = (root / "python/sitedda/drawing/view/words.js").read_text(encoding="utf-8")
    table = re.search(r"const UNITS = ({.*?\n});", text, re.DOTALL)[1]
    table = table.replace("180e-6 / Math.PI", repr(180e-6 / np.pi)).replace(",\n}", "\n}")
    expected = {unit: [list(step) for step in steps] for unit, steps in UNITS.items()}
    assert json.loads(table) == expected
    assert in_unit(0.004, "m") == (1e-3, "mm") and in_unit(3.0, "s") == (1.0, "s")
    assert in_unit(2e-6, "°")[1] == "µrad" and in_unit(0.5, "°") == (1.0, "°")


def test_names_of_numbers_are_words_with_units():
    names = {"largest_tilt_rad": "largest tilt (rad)", "residual_drift": "residual drift",
             "pga_resolved_m_s2_x[top<&]": "PGA resolved, top<&, x (m/s²)",
             "joint_slip_m[a]": "joint slip, a (m)", "friction": "friction"}  # fmt: skip
    assert {name: axis_label(name) for name in names} == names
    assert axis_label("pga", "m/s^2") == "PGA (m/s²)" and axis_label("scale", "1") == "scale"


def test_a_report_begins_with_the_check_and_has_units_in_its_tables(run):
    text = to_html(report_page(run))
    first = text.index("check of the model")
    assert text.index("<h2>Verdict") < first < text.index("where, when")
    for head in ("density (kg/m³)", "young modulus (Pa)", "friction angle (degrees)"):
        assert head in text
    areas = [2.0 * 1.0 - 0.4, 1.0, 8.0]  # right, and one with a notch
    assert f"1 to {max(areas):g} m²" in text and "vertices" in text
    assert not re.search(r"<td class='n'[^>]*>-", text)  # a true minus
    assert text.count("prefers-color-scheme: dark)' srcset=") == text.count("<img ") == 2
    source = str(run.history.attrs["source"])
    provenance = text[text.index("id='provenance'") :]
    assert provenance.count(source) == 1


def test_a_picture_of_a_page_is_light_again_after_the_dark_one(run):
    picture = Picture(run_picture(run.history), "caption")
    light, dark, light_again = (set(re.findall(rb"#[0-9a-f]{6}", picture.encoded(scheme)[1]))
                          for scheme in ("light", "dark", "light"))  # fmt: skip
    assert light == light_again and SCHEMES["light"]["paper"].encode() in light
    assert SCHEMES["dark"]["paper"].encode() in dark and INK.encode() not in dark


def test_a_fallen_block_is_reported_with_its_area(write_input):
    from test_pictures import excavated

    groups = [pair for pair in excavated() if pair[0] != "stage"]
    groups = [(n, {k: v for k, v in g.items() if k != "motion_x"}) for n, g in groups]
    run = sitedda.run(write_input([*groups, group("block", name="high",
                      vertices=[0.0, 40.0, 1.0, 40.0, 1.0, 40.5, 0.0, 40.5]),
        group("stage", name="fall", steps=800, time_step=2e-3)]))  # fmt: skip
    assert "high (0.5 m²)" in run.verdict.happened


def test_vtk_has_units_joints_and_all_contacts(run, tmp_path):
    from test_pictures import read_polygons

    folder = write_vtk(run, tmp_path).parent
    scene, last = Scene.of(run), Scene.of(run).frames - 1
    blocks = read_polygons(folder / f"blocks_{last:04d}.vtp")
    names = {blocks.GetCellData().GetArrayName(i)
             for i in range(blocks.GetCellData().GetNumberOfArrays())}  # fmt: skip
    assert {"stress xx (Pa)", "strain gamma xy", "rotation (degree)", "velocity (m/s)"} <= names
    displacement = vtk_array(blocks.GetPointData(), "displacement (m)")
    assert (displacement[:, :2] == scene.vertices(last) - scene.vertices(0)).all()
    contacts = read_polygons(folder / f"contacts_{last:04d}.vtp")
    assert contacts.GetNumberOfLines() == len(scene.contacts(last)["vertex"])
    joints = read_polygons(folder / f"joints_{last:04d}.vtp")
    slip, opening = scene.joint_movement(last)
    assert (vtk_array(joints.GetCellData(), "slip (m)") == slip).all()
    assert (vtk_array(joints.GetCellData(), "opening (m)") == opening).all()
    head, *rows = (folder / "points.csv").read_text(encoding="utf-8").splitlines()
    assert head.startswith("time (s),top<& displacement x (m)")
    assert len(rows) == run.history.sizes["time"]


def vtk_array(data, name: str) -> np.ndarray:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(data.GetArray(name))


def test_joints_are_drawn_above_their_water(root):
    """The line of the water once hid slip along a wet joint."""
    axes = draw(root / "inputs/wedge.nml")
    water = [line for line in axes.lines if line.get_label() == "water"]
    assert water and all(2.2 < line.get_zorder() < 3 for line in water)  # outlines, joints


def test_a_single_layout_pass_gives_the_same_picture(tmp_path):
    def made():
        figure, axes = new_figure(1, 2, size=(5.0, 3.0))
        for i, one in enumerate(axes):
            one.plot([0, 1], [0, 10.0**i], label="moved")
            one.set(xlabel="time (s)", ylabel="displacement (m)")
            legend_above(one, 1)
        return figure

    figure, other = made(), dress(made())
    save_picture(figure, tmp_path / "once.png", dpi=130)
    with matplotlib.rc_context({"text.hinting": "none"}):
        other.savefig(tmp_path / "usual.png", dpi=130)
    assert figure.get_layout_engine() is not None
    once, usual = (matplotlib.image.imread(tmp_path / f"{name}.png") for name in ("once", "usual"))
    assert np.array_equal(once, usual)
