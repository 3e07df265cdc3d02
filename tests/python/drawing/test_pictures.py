# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures, movies, VTK files, the verdict and reports of a run, without a browser."""

import re
import xml.etree.ElementTree as xml
from functools import partial

import numpy as np
import pytest
from environment import captured
from matplotlib.text import Text
from model_text import ROCK, changed, flying_block, group, rectangle, tower
from PIL import Image
from scipy.signal import butter, lsim, sosfilt
from test_view import EVIL, TITLE, sliding_blocks

import sitedda
from sitedda.base.errors import RestWarning
from sitedda.drawing.point_names import PointNames
from sitedda.drawing.quantities import limits
from sitedda.movie import ffmpeg, write_movie
from sitedda.numbers import in_unit
from sitedda.pictures import draw, neighbour_forces
from sitedda.plot import run_picture
from sitedda.report import Page, Paragraph, Table, to_html
from sitedda.report.html import json_for_script
from sitedda.scene import Scene
from sitedda.signals import GRAVITY, arias_intensity
from sitedda.style import BOLT, new_figure
from sitedda.verdict import PERIODS, acceleration_spectrum, describe_damping
from sitedda.vtk import write_vtk

# --- The scene ------------------------------------------------------------------------------------


def test_names_and_materials_of_generated_blocks_are_those_of_the_engine(write_input):
    groups = tower()
    bricks = {"left": 40.0, "brick_length": 2.0, "brick_height": 1.0, "bricks": 2, "courses": 3}
    groups[4:4] = [
        group("block", name="a/&b", vertices=rectangle(80, 0, 1, 1)),
        group("drums", centre=60.0, width=2.0, height=1.0, count=2),
        group("wall", name="w'!x", **bricks),
    ]
    file = write_input(groups)
    with sitedda.Simulation(file) as simulation:
        names = simulation.block_names
        scene = Scene.of(simulation)
    assert scene.before and scene.names == names
    wall = names.index("w'!x_1")
    assert names[wall : wall + 7] == [f"w'!x_{i}" for i in range(1, 8)]
    assert {"a/&b", "drum_2", "base_1"} < set(names)
    assert Scene.of(sitedda.run(file)).names == names


def test_shear_forces_balance_a_block_on_a_slope(write_input):
    """On a slope of 20°, the force of the slope on the block equals minus its weight."""
    cos, sin = np.cos(np.radians(20)), np.sin(np.radians(20))
    corners = np.reshape(rectangle(4, 0, 1, 1), (-1, 2))
    rotated = (corners @ [[cos, sin], [-sin, cos]]).ravel().tolist()
    ground = [0.0, -2.0, 10 * cos, -2.0, 10 * cos, 10 * sin, 0.0, 0.0]
    groups = [
        group("control", time_step=1e-3, steps=300, gravity=[0.0, -9.81], dynamic_factor=0.9),
        group("contact", normal_stiffness=1e9),
        group("material", density=2000.0, young_modulus=1e9, poisson_ratio=0.2),
        group("joint", friction_angle=40.0),
        group("block", name="ground", vertices=ground),
        group("block", name="brick", vertices=rotated),
        *(group("fixed_point", x=x, y=-1.0, block="ground") for x in (1.0, 9.0)),
    ]  # fmt: skip
    scene = Scene.of(sitedda.run(write_input(groups)))
    frame = scene.frames - 1
    _, force = neighbour_forces(scene, frame, scene.vertices(frame))
    assert force.shape == (1, 2)
    assert np.linalg.norm(force[0]) == pytest.approx(2000 * 9.81, rel=1e-3)
    assert abs(force[0, 0]) < 1e-3 * abs(force[0, 1])


def test_points_of_blocks_move_like_their_vertices(run):
    scene = Scene.of(run)
    for frame in (0, scene.frames - 1):
        carried = scene.carried(scene.owner, scene.vertices(0), frame)
        assert abs(carried - scene.vertices(frame)).max() < 1e-12


def test_the_weaker_joint_of_two_edges_is_drawn(write_input):
    groups = [
        group("control", time_step=1e-3, steps=1),
        group("material", density=2000.0, young_modulus=1e9, poisson_ratio=0.2),
        *(group("joint", name=n, friction_angle=a) for n, a in (("rough", 40), ("flat", 10))),
        group("block", name="low", joint="rough", vertices=rectangle(0, 0, 2, 1)),
        group("block", name="high", joint="rough", vertices=rectangle(0, 1, 2, 1),
              edge_joints=["flat", "", "rough"]),
        group("block", name="side", joint="rough", vertices=rectangle(2, 0, 2, 2)),
    ]  # fmt: skip
    scene = Scene.of(write_input(groups))
    faces = scene.interfaces
    pairs = zip(faces.first, faces.second, scene.interface_joints, strict=True)
    assert {frozenset((a, b)): scene.joint_names[k] for a, b, k in pairs} == {
        frozenset((0, 1)): "flat", frozenset((0, 2)): "rough", frozenset((1, 2)): "rough"
    }  # fmt: skip


def test_slivers_of_a_scene_are_found(write_input):
    groups = [*tower(), group("block", name="thin", vertices=[50, 0, 51, 0, 51, 1e-3])]
    scene = Scene.of(write_input(groups))
    assert [scene.names[b] for b in scene.slivers()] == ["thin"]


# --- Pictures -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "look",
    [
        {"color": "material", "contacts": "slip"},
        {"color": "compression", "contacts": "force"},
        {"color": "rotation", "contacts": "opening", "deformation": 5.0},
        {"color": "velocity", "time": 0.1},
    ],
)
def test_a_run_is_drawn_in_every_look(run, look, tmp_path):
    axes = run.draw(**look)
    axes.figure.savefig(tmp_path / "picture.png", dpi=50)
    assert np.asarray(Image.open(tmp_path / "picture.png"))[..., :3].std() > 10
    if "time" in look:
        scene = Scene.of(run)
        frame = scene.frame_at(0.1)
        assert scene.time[frame] == pytest.approx(0.1)
        outlines = [path.vertices[:-1] for path in axes.collections[-1].get_paths()]
        assert all(map(np.allclose, outlines, scene.polygons(frame)))


def test_an_unknown_look_is_refused(run):
    with pytest.raises(ValueError, match="color must be one of"):
        run.draw(color="blue")
    with pytest.raises(ValueError, match="contacts must be one of"):
        draw(run, contacts="all")


def test_a_site_picture_states_the_damping_of_the_model(write_input):
    file = write_input([*tower(layers=2, steps=400), group("amplification", lowest=1, highest=99)])
    history = sitedda.run(file).history
    figure = run_picture(history)
    texts = [text.get_text() for text in figure.texts]
    assert any("damping ratio of the scheme" in t and "of the materials: none" in t for t in texts)
    figure.canvas.draw()
    for legend in filter(None, (axes.get_legend() for axes in figure.axes)):
        box, axes = legend.get_window_extent(), legend.axes.get_window_extent()
        assert box.y0 >= axes.y1 - 1 or box.y1 <= axes.y0 + 1


def test_names_of_points_overlap_neither_each_other_nor_points():
    positions = [(0, 0), (15, 15), (30, 30), (60, 30), (62, 30), (64, 30)]
    names = ["toe", "6", "crest", "8", "8 b", "a longer name"]
    figure, axes = new_figure(size=(9, 3))
    axes.set(xlim=(-230, 410), ylim=(-30, 50))
    labels = PointNames(axes, names, positions, positions)
    figure.canvas.draw()
    boxes = [Text.get_window_extent(name) for name in labels.names]  # without its line
    assert [name.get_text() for name in labels.names] == names
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:i]), names[i]
        assert not any(box.contains(*at) for at in axes.transData.transform(positions)), names[i]


def test_the_usual_range_over_frames_covers_the_last_frame():
    values = np.full((60, 100), 0.1)
    values[-1, :20] = np.linspace(1.0, 2.0, 20)  # a third of a per cent of all values
    assert limits(values, np.ones(100)).usual == limits(values[-1], np.ones(100)).usual == 2.0
    values[0, :20] = 5.0
    assert limits(values, np.ones(100)).high == 5.0
    assert 1.9 < limits(values, np.ones(100)).usual < 2.0  # one block of the last frame is beyond


def test_blocks_have_one_scale_in_all_panels_of_a_picture(bolted):
    figure = run_picture(bolted.history)
    figure.canvas.draw()
    blocks = [axes for axes in figure.axes if axes.get_ylabel() == "y (m)"]
    assert len(blocks) == 3
    scales = [axes.transData.get_matrix()[0, 0] for axes in blocks]
    assert np.allclose(scales, scales[0], rtol=1e-3)


# --- Movies ---------------------------------------------------------------------------------------


def test_a_gif_moves(run, tmp_path):
    file = write_movie(run, tmp_path / "x.gif", fps=5, seconds=1)
    with Image.open(file) as movie:
        assert movie.n_frames >= 4
        first = np.asarray(movie.convert("RGB")).astype(int)
        movie.seek(movie.n_frames - 1)
        assert abs(np.asarray(movie.convert("RGB")) - first).max() > 50


def test_an_mp4_has_the_requested_number_of_pictures(run, tmp_path):
    file = write_movie(run, tmp_path / "x.mp4", fps=5, seconds=1)
    process = captured([ffmpeg(), "-i", file, "-f", "null", "-"])
    assert "Video: h264" in process.stderr and "frame=    5" in process.stderr


def test_a_movie_needs_frames_and_a_known_ending(run, tmp_path, write_input):
    with pytest.raises(sitedda.InputError, match="mp4 or .gif"):
        write_movie(run, tmp_path / "x.avi")
    with pytest.raises(sitedda.InputError, match="block_interval"):
        write_movie(write_input(tower()), tmp_path / "x.gif")


# --- VTK ------------------------------------------------------------------------------------------


def read_polygons(file):
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def test_vtk_files_contain_the_values_of_the_output(run, tmp_path):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    scene = Scene.of(run)
    collection = write_vtk(run, tmp_path / "vtk")
    entries = list(xml.parse(collection).getroot().iter("DataSet"))
    assert [float(e.get("timestep")) for e in entries] == scene.time.tolist()
    history = run.history
    for frame in (0, scene.frames - 1):
        data = read_polygons(collection.parent / entries[frame].get("file"))
        assert data.GetNumberOfPolys() == scene.blocks
        points = vtk_to_numpy(data.GetPoints().GetData())
        assert (points[:, :2] == scene.vertices(frame)).all() and not points[:, 2].any()
        cells = {
            data.GetCellData().GetArrayName(i): vtk_to_numpy(data.GetCellData().GetArray(i))
            for i in range(data.GetCellData().GetNumberOfArrays())
        }
        stress = [cells[f"stress {axes} (Pa)"] for axes in ("xx", "yy", "xy")]
        assert (np.stack(stress, axis=1) == history.block_stress.values[frame]).all()
        assert (cells["velocity (m/s)"][:, :2] == history.block_rates.values[frame, :, :2]).all()
        displacement = Scene.of(run, absolute=True).displacement(frame)
        assert (cells["displacement of the centroid (m)"][:, :2] == displacement).all()
        areas = [polygon_area(data.GetCell(b)) for b in range(scene.blocks)]
        assert areas == pytest.approx(scene.areas(frame).tolist(), rel=1e-12)
        file = entries[frame].get("file").replace("blocks", "contacts")
        contacts = read_polygons(collection.parent / file)
        forces = vtk_to_numpy(contacts.GetCellData().GetArray("normal force (N/m)"))
        assert (forces == scene.contacts(frame)["normal_force"]).all()
    names = read_polygons(collection.parent / entries[0].get("file")).GetFieldData()
    names = names.GetAbstractArray("block names")
    assert [names.GetValue(i) for i in range(scene.blocks)] == scene.names
    assert not (collection.parent / "bolts.pvd").exists()


def test_vtk_files_contain_bolts(bolted, tmp_path):
    """Lines through all points, with the forces and states of the output."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    folder = write_vtk(bolted, tmp_path).parent
    last = [e.get("file") for e in xml.parse(folder / "bolts.pvd").getroot().iter("DataSet")][-1]
    data = read_polygons(folder / last)
    assert [data.GetCell(i).GetNumberOfPoints() for i in range(4)] == [2, 2, 2, 3]
    history = bolted.history.isel(time=-1)
    force, state = (vtk_to_numpy(data.GetCellData().GetArray(n)) for n in ("force (N/m)", "state"))
    assert force.tolist() == history.bolt_force.values.tolist()
    assert state.tolist() == history.bolt_state.values.tolist() == [4, 1, 1, 1]


def test_pictures_show_bolts_with_their_force(bolted):
    """The legend contains the largest force; a broken bolt is dotted; zero has the unit N/m."""
    axes = draw(bolted).axes
    assert in_unit(0.0, "N/m") == (1.0, "N/m")
    force = float(bolted.history.bolt_force[-1].max())
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert f"bolt, largest force\n{force / 1e3:.3g} kN/m" in legend
    styles = [line.get_linestyle() for line in axes.lines if line.get_color() == BOLT]
    assert sorted(styles) == ["-", "-", "-", ":"]


def test_static_steps_do_not_count_as_damping(bolted):
    description = describe_damping(bolted.history, 1.0)
    assert description.startswith("damping ratio of the scheme 0.16 % at 1 Hz (Δt = 1 ms)")


def polygon_area(cell) -> float:
    points = np.array([cell.GetPoints().GetPoint(i)[:2] for i in range(cell.GetNumberOfPoints())])
    x, y = points.T - points[0][:, None]
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


# --- Words ----------------------------------------------------------------------------------------


def test_the_verdict_reports_movement_and_slip(run):
    scene, values = Scene.of(run), run.verdict.values

    def largest_displacement(frame: int) -> float:
        """Largest displacement relative to the table, which moves with its supports."""
        displacement = scene.displacement(frame)
        return np.linalg.norm(displacement - displacement[0], axis=1).max()

    def largest_rotation(frame: int) -> float:
        return abs(scene.coordinates(frame)[:, 2] - scene.coordinates(0)[:, 2]).max()

    last = scene.frames - 1
    assert values["residual_displacement_m"] == pytest.approx(largest_displacement(last), rel=1e-3)
    assert values["residual_tilt_rad"] == pytest.approx(largest_rotation(last))
    peak = max(largest_displacement(frame) for frame in range(scene.frames))
    assert 0.999 * peak <= values["largest_displacement_m"] <= 1.1 * peak
    assert values["largest_tilt_rad"] >= max(map(largest_rotation, range(scene.frames)))
    text = str(run.verdict)
    assert "PGA" in text and "Arias" in text and text.startswith("Blocks moved by up to ")


def test_the_output_contains_the_intensities_of_points(run):
    """PGA, PGV, Arias intensity and Sa of engine and package agree, each along its axis."""
    attributes = run.history.attrs
    for name in run.history.point.values:
        motion = run.history.sel(point=name)
        step, below = float(motion.time[1]), attributes[f"resolved_frequency_hz[{name}]"]
        low_pass = butter(4, below, fs=1.0 / step, output="sos")
        intensities = []
        for axis in range(2):
            acceleration = motion.acceleration.values[:, axis]
            low = sosfilt(low_pass, acceleration)
            spectrum = acceleration_spectrum(acceleration, step)
            intensities.append({
                "pga_m_s2": abs(acceleration).max(),
                "pga_resolved_m_s2": abs(low).max(),
                "arias_resolved_m_s": arias_intensity(low, step),
                "sa_resolved_m_s2": acceleration_spectrum(low, step).max(),
                "pga_below_50_hz_m_s2": low_passed_peak(motion.time, acceleration),
                "pgv_m_s": abs(motion.velocity.values[:, axis]).max(),
                "arias_m_s": arias_intensity(acceleration, step),
                "sa_m_s2": spectrum.max(),
                "sa_period_s": PERIODS[spectrum.argmax()],
            })  # fmt: skip
        shaken = max(intensities, key=lambda intensity: intensity["sa_m_s2"])
        for measure in intensities[0]:
            pair = [intensity[measure] for intensity in intensities]
            is_filtered = "resolved" in measure or "50_hz" in measure
            close = partial(pytest.approx, rel=2e-3 if is_filtered else 1e-9, abs=1e-12)
            largest = shaken[measure] if "period" in measure else max(pair)
            assert attributes[f"{measure}[{name}]"] == close(largest), measure
            if f"{measure}_x[{name}]" in attributes:
                attribute_pair = [attributes[f"{measure}_{letter}[{name}]"] for letter in "xy"]
                assert attribute_pair == [close(value) for value in pair], measure


@pytest.mark.parametrize("interval", [1, 2])
def test_points_resolve_waves_of_eight_blocks_and_a_quarter_of_the_sampling(write_input, interval):
    wave = np.sqrt(ROCK["young_modulus"] / (2 + 2 * ROCK["poisson_ratio"]) / ROCK["density"]) / 8.0
    groups = changed(sliding_blocks(20), "output", history_interval=interval)
    attributes = sitedda.run(write_input(groups), output=False).history.attrs
    expected = {1: wave, 2: 500.0 / 2 / 4}[interval]
    assert attributes["resolved_frequency_hz[top<&]"] == pytest.approx(expected, rel=1e-12)


def low_passed_peak(time, acceleration) -> float:
    """Largest value after a Butterworth low-pass of second order at 50 Hz."""
    fine = np.linspace(float(time[0]), float(time[-1]), 8 * len(time))
    low_pass = butter(2, 2 * np.pi * 50.0, analog=True)
    return abs(lsim(low_pass, np.interp(fine, time, acceleration), fine)[1]).max()


def test_a_peak_above_50_hz_is_a_separate_result(write_input, tmp_path):
    """A force on a block for one millisecond, and for thirty."""
    peaks = {}
    for ms in (1, 30):
        groups = changed(flying_block(100), "measured_point", name="top")
        groups = changed(groups, "control", time_step=5e-4)
        times = [0.0, 0.005, 0.005 + ms / 2e3, 0.005 + ms / 1e3, 9.0]
        load = {"x": 1.0, "y": 0.5, "time": times, "force_x": [0.0, 0.0, 5e6, 0.0, 0.0]}
        load["force_y"] = [0.0] * len(times)
        run = sitedda.run(write_input([*groups, ("load", load)]), tmp_path / f"{ms}.nc")
        values = run.verdict.values
        peaks[ms] = values["pga_below_50_hz_m_s2[top]"] / values["pga_m_s2[top]"]
    assert peaks[1] < 0.2 and peaks[30] > 0.8


def test_intensities_of_unequal_steps_and_of_names_with_special_characters(write_input):
    """A block under constant force: a = F/m from the first step, for any step lengths."""
    groups = flying_block(50, time_step_control="adaptive", max_displacement_ratio=1e-4)
    groups = changed(groups, "measured_point", name="Größe/α")
    load = {"x": 1.0, "y": 0.5, "time": [0.0, 9.0], "force_y": [5e5, 5e5]}
    history = sitedda.run(write_input([*groups, ("load", load)])).history
    time, acceleration = history.time.values, history.acceleration.values[:, 0, 1]
    assert np.ptp(np.diff(time)) > 0
    arias_intensity = np.pi / (2 * GRAVITY) * np.trapezoid(acceleration**2, time)
    assert history.attrs["arias_m_s[Größe|α]"] == pytest.approx(arias_intensity, rel=1e-12)
    # Under a step of acceleration, a damped oscillator overshoots by less than the step.
    assert acceleration[-1] < history.attrs["sa_m_s2[Größe|α]"] < 2.0 * acceleration[-1]


def test_spectra_after_tiny_steps_are_fast(write_input):
    """Free vibration has its own steps: five seconds would be 5e9 of the time steps."""
    history = sitedda.run(write_input(tower(steps=3, time_step=1e-9)), output=False).history
    assert history.attrs["sa_m_s2[surface]"] > 0


def test_contacts_and_joints_have_the_same_slip_and_opening(run):
    """The engine uses vertices on edges; the scene uses common segments of two edges."""
    scene, values = Scene.of(run), run.verdict.values
    slip, gap = scene.joint_movement(scene.frames - 1)
    assert values["largest_slip_m"] == pytest.approx(slip.max(), rel=1e-3) and slip.max() > 0.05
    assert values["largest_opening_m"] == pytest.approx(max(gap.max(), 0), abs=1e-6)
    assert values["contacts_slipped"] == 2 * np.sum(slip > 1e-5 * scene.size)
    assert values["contacts_opened"] <= values["contacts_slipped"]


def test_the_output_of_the_executable_contains_the_same_words(run, binary, write_input, tmp_path):
    import xarray as xr

    binary("run", write_input(sliding_blocks()), "-q", "-o", tmp_path / "n.nc")
    with xr.open_dataset(tmp_path / "n.nc") as data:
        assert data.attrs["verdict"] == run.history.attrs["verdict"]
        for name in ("figures", "doubts"):
            assert data.attrs[name] == run.history.attrs[name]
        assert data.attrs["verdict"] in run.verdict.happened
        assert data.attrs["largest_displacement_m"] == run.verdict.values["largest_displacement_m"]


def test_blocks_that_leave_are_counted_and_named(write_input):
    groups = [
        group("control", time_step=5e-3, steps=400, gravity=[0.0, -9.81]),
        group("material", density=2000.0, young_modulus=1e8, poisson_ratio=0.2),
        group("joint", friction_angle=30.0),
        group("block", name="held", vertices=rectangle(0, 0, 1, 1)),
        group("block", name="falls", vertices=rectangle(2, 0, 1, 1)),
        *(group("fixed_point", x=x, y=0.5, block="held") for x in (0.2, 0.8)),
        group("output", block_interval=20),
    ]
    run = sitedda.run(write_input(groups))
    assert run.verdict.values["blocks_lost"] == run.verdict.values["blocks_fallen"] == 1
    assert run.verdict.values["first_block_fallen_s"] < run.verdict.values["first_block_lost_s"]
    assert 0 < run.verdict.values["first_block_lost_s"] < 2
    axes = run.draw()
    assert "1 block out of view: falls" in axes.texts[-1].get_text()
    low, high = axes.get_ylim()
    assert low > -2 and high < 2


@pytest.mark.parametrize("shows_both", [False, True])
def test_the_smaller_axis_has_its_unit_and_is_shown_from_a_hundredth_on(write_input, shows_both):
    groups = [(name, one | {"motion_y": "pulse"} if shows_both and name == "fixed_point" else one)
              for name, one in tower()]  # fmt: skip
    locations = [line.place for line in sitedda.run(write_input(groups)).verdict.figures
             if line.name in ("PGA", "PGV")]  # fmt: skip
    assert len(locations) >= 2
    pattern = re.compile(r", [xy] \([xy] [\d.e-]+ m?m/s(²|\^2)?\)")
    for location in locations:
        assert bool(pattern.search(location)) is shows_both, location


# --- Pages ----------------------------------------------------------------------------------------


def test_texts_are_escaped_in_their_context():
    page = Page(TITLE, EVIL)
    page.add(EVIL, Paragraph(EVIL, markup=True), Table([EVIL, "verdict"], [[EVIL, "ok"]], EVIL))
    page.provenance = [("input", EVIL)]
    text = to_html(page)
    assert "<img" not in text and "</script" not in text
    assert text.count("onerror") >= 6
    assert "default-src 'none'" in text and "script-src 'none'" in text
    assert "</" not in json_for_script({"name": EVIL})


def test_numbers_are_aligned_at_the_right_and_prose_is_not():
    page = Page("t")
    rows = [["1.5", "28 crests of a wave"], ["6.2·10^-5 %", "3"]]
    page.add("s", Table(["a", "b"], rows, markup=True))
    text = to_html(page)
    assert "<td class='n' data-head='a'>6.2·10<sup>−5</sup> %</td>" in text
    assert "<td data-head='b'>28 crests of a wave</td>" in text


def test_only_long_tables_scroll():
    for rows, scrolls in ((30, False), (60, True)):
        page = Page("t")
        page.add("s", Table(["a"], [["x"]] * rows))
        assert ("class='wide long'" in to_html(page)) is scrolls


def test_commands_write_the_files_that_they_report(main, run, write_input, tmp_path):
    file = write_input(changed(tower(steps=40), "output", block_interval=5))
    main.ok("run", file, "-o", tmp_path / "t.nc", "-q", folder=tmp_path)
    assert (tmp_path / "t.png").stat().st_size > 20_000
    for arguments, files in (
        (("draw", tmp_path / "t.nc"), "t.blocks.png"),
        (("draw", file, "-o", tmp_path / "model.svg"), "model.svg"),
        (("view", tmp_path / "t.nc", "--no-open"), "t.view.html"),
        (("report", tmp_path / "t.nc"), "t.html"),
        (("export", tmp_path / "t.nc", "--vtk", tmp_path / "vtk"), "vtk/blocks.pvd"),
    ):
        process = main.ok(*arguments, folder=tmp_path)
        assert files in process.stdout and (tmp_path / files).stat().st_size > 100
    page = (tmp_path / "t.html").read_text(encoding="utf-8")
    assert "<h2>Check" in page and "highest frequency" in page
    for command, option, value, message in (
        ("draw", "-t", "0.5", "choose 0 to 0.04 s"),
        ("movie", "-o", "t.avi", ".mp4 or .gif"),
    ):
        refused = main(command, tmp_path / "t.nc", option, value, folder=tmp_path)
        assert refused.returncode == 1 and message in refused.stderr
    refused = main("draw", tmp_path / "t.png", folder=tmp_path)
    assert refused.returncode == 1 and "t.png" in refused.stderr


@pytest.mark.parametrize("command", [("draw",), ("view", "--no-open"), ("report",)])
def test_a_model_that_does_not_settle_is_shown_as_drawn(main, write_input, command):
    file = write_input(flying_block(gravity=[0.0, -9.81], settle=True))
    with pytest.warns(RestWarning, match="does not settle: .*; shown as drawn"):
        main.ok(*command, file)


def test_a_report_checks_the_input_as_it_was_run(main, write_input, tmp_path):
    """The changes of the command line apply, although the file no longer exists."""
    file = write_input(tower(steps=5))
    expected, other = (
        next(line.words for line in sitedda.check(file, changes).lines if "ω_max" in line.words)
        for changes in ({"material.density": 1234.0}, None)
    )
    options = ("-o", tmp_path / "t.nc", "-q", "--no-plot", "--set", "material.density=1234")
    main.ok("run", file, *options)
    file.unlink()
    main.ok("report", tmp_path / "t.nc", "-o", tmp_path / "t.html")
    page = (tmp_path / "t.html").read_text(encoding="utf-8")
    assert expected.split(",")[0] in page and other.split(",")[0] not in page


def test_outputs_are_selected_by_names(run):
    history = run.history
    one = history.block_coordinates.sel(block="right", coordinate="x")
    assert (one.values == history.block_coordinates.values[:, 2, 0]).all()
    assert history.block_stress.sel(component="yy").sel(frame=0.1, method="nearest").shape == (3,)
    assert history.displacement.sel(axis="y").shape == (121, 1)
    assert "&lt;" in run._repr_html_() and "<img" not in run._repr_html_()


def test_objects_have_a_readable_repr(write_input):
    file = write_input(tower())
    simulation = sitedda.Simulation(file)
    assert repr(simulation) == "<sitedda.Simulation 'A small tower': 4 blocks, 0 of 0.06 s>"
    simulation.close()
    assert repr(simulation).endswith("closed>")
    modes = sitedda.modes(file, 2)
    assert f"{modes.frequency[0]:.4g} Hz" in repr(modes)
    cell = f"<td class='n' data-head='frequency (Hz)'>{modes.frequency[1]:.4g}</td>"
    assert cell in modes._repr_html_()
    assert "highest frequency" in sitedda.check(file)._repr_html_()


def test_models_and_simulations_show_themselves_in_notebooks(write_input):
    file = write_input(sliding_blocks())
    model = sitedda.Model.read(file)
    for displayed_object in (model, sitedda.Simulation(file)):
        text = displayed_object._repr_html_()
        assert "data:image/" in text and "&lt;/script&gt;" in text
        assert EVIL not in text and "<img src=x" not in text
    empty = sitedda.Model("nothing yet", time_step=1e-3)._repr_html_()
    assert "cannot run yet" in empty and "Model.control" in empty


def test_hostile_names_stay_texts_in_pictures_and_exports(run, tmp_path):
    figure = run.draw(color="material").figure
    figure.savefig(tmp_path / "x.svg")
    parsed = xml.parse(tmp_path / "x.svg")  # a name that ended its element would not parse
    assert not [e for e in parsed.iter() if e.tag.endswith(("script", "image"))]
    run_picture(run.history).savefig(tmp_path / "y.svg")
    xml.parse(tmp_path / "y.svg")
    collection = write_vtk(run, tmp_path / "vtk")
    text = collection.read_text()
    assert "<img" not in text and text.count("-->") == 1
    head = (tmp_path / "vtk" / "blocks_0000.vtp").read_bytes().partition(b"<AppendedData")[0]
    assert b"onerror" not in head and b"<script" not in head


def excavated() -> list:
    """Two blocks side by side on a table; a stage removes the first."""
    groups = tower(2, steps=None, gravity=[0.0, -9.81])
    groups = [pair for pair in groups if pair[1].get("name") != "surface"]
    return [
        *groups,
        group("measured_point", name="low", x=7.5, y=0.5, block="layer_1"),
        group("stage", name="shake, low", steps=40),
        group("stage", name="dig", kind="static", remove="layer_2"),
        group("stage", name="after <b>", steps=30),
    ]


def test_stages_are_marked_and_removed_blocks_are_gone(write_input):
    groups = changed(excavated(), "output", block_interval=10)
    run = sitedda.run(write_input(groups))
    scene = Scene.of(run)
    assert [name for name, _ in scene.stage_starts()] == ["shake, low", "dig", "after <b>"]
    assert scene.removed(scene.frames - 1).tolist() == [False, False, True]
    low, dig = (scene.frame_at(None, name) for name in ("shake, low", "dig"))
    assert scene.removed(low).sum() == 0 and scene.removed(dig).sum() == 1
    assert int(run.history.frame_stage[dig + 1]) > int(run.history.frame_stage[dig])
    assert scene.frame_at(0.0, "dig") > low
    with pytest.raises(sitedda.InputError, match="stage 'digging' has no frame"):
        run.draw(stage="digging")
    axes = run.draw(color="velocity")
    paths = axes.collections[-1].get_paths()
    is_drawn = [np.isfinite(path.vertices).all() and len(path.vertices) > 0 for path in paths]
    assert is_drawn[:2] == [True, True] and (len(is_drawn) == 2 or not is_drawn[2])
    assert "1 block removed" in axes.texts[-1].get_text()
    from sitedda.vtk import blocks_of

    assert blocks_of(scene, scene.frames - 1).cells["removed"].tolist() == [0, 0, 1]
    figure = run_picture(run.history)
    texts = [t.get_text() for a in figure.axes[2:] for t in a.texts]
    assert {"shake, low", "after <b>"} <= set(texts)
    assert "damping ratio of the scheme" in figure.texts[-1].get_text()


def test_check_prints_four_digits(write_input, main):
    import json
    from dataclasses import replace

    file = write_input(tower())
    report = sitedda.check(file)
    assert [line.topic for line in report.lines][:2] == ["contacts", "highest frequency"]
    assert not any("E-0" in line.words or "E+0" in line.words for line in report.lines)
    assert report.conclusion.startswith(f"verdict: {report.verdict}")
    assert replace(report, text=f"{report}\n{report}").conclusion == report.conclusion
    values = json.loads(main("check", file, "--json").stdout)
    assert values["omega_max"] == report.omega_max and len(values["lines"]) == len(report.lines)


def test_a_report_of_a_motion_without_movement(main, write_input, tmp_path):
    """One frame of a wall under a motion of zeros."""
    file = write_input(changed(tower(steps=1), "motion", values=[0.0, 0.0, 0.0]))
    main.ok("run", file, "-o", tmp_path / "t.nc", "-q", "--no-plot")
    main.ok("report", tmp_path / "t.nc", "-o", tmp_path / "t.html")
    assert "<h2>" in (tmp_path / "t.html").read_text(encoding="utf-8")
