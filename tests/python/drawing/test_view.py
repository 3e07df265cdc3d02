# SPDX-License-Identifier: GPL-3.0-or-later
"""The interactive view and reports in the system's Chromium, headless and without a network."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from environment import DEADLINE, wait_for
from model_text import DRY, ROCK, group, rectangle

import sitedda
from sitedda.drawing.view import view
from sitedda.drawing.view.encode import encode
from sitedda.facade.page import report_page
from sitedda.report import write_html
from sitedda.scene import Scene
from sitedda.view import write_view

EVIL = "</script><img src=x onerror=alert(1)>"
TITLE = f"{EVIL} \"&'< ]]> --> `$x$` **b**"


def sliding_blocks(steps: int = 120) -> list:
    """Two blocks on a table that is thrown sideways; every name is hostile."""
    rock, joint = dict(ROCK, name="&<'\"m"), dict(DRY, name="<b>j</b>", friction_angle=5.0)
    return [
        group("run", title=TITLE),
        group("control", time_step=2e-3, steps=steps, gravity=[0.0, -9.81]),
        group("contact", normal_stiffness=1e9),
        ("material", rock),
        ("joint", joint),
        group("block", name="table", vertices=rectangle(0, 0, 8, 1)),
        group("block", name=EVIL, vertices=[1, 1, 3, 1, 3, 2, 2, 1.6, 1, 2]),
        group("block", name="right", vertices=rectangle(5, 1, 1, 1)),
        *(group("fixed_point", x=x, y=0.5, block="table", motion_x="throw") for x in (1, 7)),
        group("motion", name="throw", quantity="displacement", time_step=0.05,
              values=[0.0, 0.0, 0.05, 0.15, 0.25, 0.3, 0.3]),
        group("measured_point", name="top<&", x=5.5, y=2.0, block="right"),
        group("output", block_interval=10),
    ]  # fmt: skip


@pytest.fixture(scope="module")
def pages(run, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    write_html(report_page(run), folder / "report.html")
    write_view(run, folder / "view.html")
    return folder


@pytest.fixture
def opened(new_page):
    """Return an opener of pages, which request nothing but themselves."""

    def open_page(file: Path, **options):
        page = new_page(("file:", "data:", "blob:"), **options)
        page.goto(file.as_uri())
        decoded = "window.blockViews.every(v => v.state.decoded || v.state.trouble)"
        wait_for(lambda: page.evaluate(decoded))
        return page

    return open_page


def wait_until_decoded(page) -> None:
    """Wait until the first view of a page has decoded all frames."""
    wait_for(lambda: page.evaluate("window.blockViews?.[0]?.state.decoded"))


def wait_until(page, condition) -> None:
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline
        page.wait_for_timeout(20)


def wait_for_drawing(page) -> None:
    """Wait until the view is drawn, and the next frame has begun."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def place_in_view(page, x: float, y: float) -> list[float]:
    """Pixels of a point of the model."""
    return page.evaluate(
        """([x, y]) => { const v = blockViews[0], c = v.camera, [ox, oy] = v.meta.origin;
        const box = v.stage.getBoundingClientRect(), k = box.width / c.width;
        return [box.left + k * (c.width / 2 + c.scale * (x - ox - c.x)),
                box.top + k * (c.height / 2 - c.scale * (y - oy - c.y))]; }""",
        [x, y],
    )


def drawn(page) -> list[int]:
    """Sums of red, green and blue over the redrawn canvas."""
    return page.evaluate(
        """() => { const v = blockViews[0]; v.draw(); const gl = v.painter.gl;
        const [w, h] = [v.camera.width, v.camera.height], p = new Uint8Array(4 * w * h);
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p); const sums = [0, 0, 0];
        for (let i = 0; i < p.length; i++) if (i % 4 < 3) sums[i % 4] += p[i]; return sums; }"""
    )


def test_a_report_shows_hostile_names_without_executing_them(pages, opened):
    page = opened(pages / "report.html", viewport={"width": 1280, "height": 900})
    assert page.complaints == []
    assert page.title() == page.inner_text("h1") == " ".join(TITLE.split())
    assert page.evaluate("document.querySelectorAll('main img:not(.picture img)').length") == 0
    assert page.evaluate("document.querySelectorAll('b:not(.chart b)').length") == 0
    text = page.inner_text("main")
    assert "&<'\"m" in text and "<b>j</b>" in text and "top<&" in text
    page.evaluate("blockViews[0].pick(1)")
    wait_for_drawing(page)
    assert page.inner_text(".info h3") == EVIL
    assert page.complaints == []


def test_the_view_plays_and_a_block_is_picked_by_a_click(pages, opened, run):
    page = opened(pages / "view.html", viewport={"width": 1000, "height": 900})
    assert page.evaluate("blockViews[0].state.renderer") == "WebGL 2"
    page.evaluate("blockViews[0].show(0)")
    first = drawn(page)
    page.click("button.play")
    wait_for(lambda: page.evaluate("blockViews[0].frame") >= 2)
    page.evaluate("blockViews[0].play(false)")
    assert drawn(page) != first

    last = page.evaluate("blockViews[0].model.frames") - 1
    page.evaluate(f"blockViews[0].show({last})")
    x, y = run.history.block_coordinates[-1, 2, :2].values
    x, y = place_in_view(page, float(x), float(y))
    page.mouse.click(x, y)
    wait_for_drawing(page)
    assert page.evaluate("blockViews[0].state.picked") == "right"
    assert page.inner_text(".info h3") == "right"
    assert page.locator(".block-chart canvas").bounding_box()["width"] > 200
    scene = Scene.of(run)
    area = page.evaluate("blockViews[0].state.area")
    assert area == pytest.approx(scene.areas(last)[2], rel=1e-5)
    assert page.complaints == []


def test_positions_in_the_view_are_those_of_the_output(pages, opened, run):
    """Within 1 mm per 100 m in each frame at scale 1; forces as well."""
    page = opened(pages / "view.html")
    scene = Scene.of(run)
    for frame in range(scene.frames):
        places = page.evaluate(
            f"(m => {{ m.put({frame}, 1); return Array.from(m.places); }})(blockViews[0].model)"
        )
        origin = page.evaluate("blockViews[0].meta.origin")
        positions = np.reshape(places, (-1, 2)) + origin
        assert abs(positions - scene.vertices(frame)).max() <= 1e-5 * scene.size
    largest = page.evaluate("blockViews[0].meta.largest_force")
    assert largest == pytest.approx(run.history.contact_normal_force.values.max(), rel=1e-6)


def test_bolts_in_the_view_are_those_of_the_output(bolted, opened, tmp_path):
    """Positions, forces and states in each frame, and the largest force in the legend."""
    page = opened(write_view(bolted, tmp_path / "bolts.html"))
    scene = Scene.of(bolted)
    for frame in range(scene.frames):
        bolts = page.evaluate(f"blockViews[0].model.lines('bolts', {frame}, 1)")
        origin = np.array(page.evaluate("blockViews[0].meta.origin"))
        for bolt, expected in zip(bolts, scene.bolts(frame), strict=True):
            assert bolt["state"] == expected["state"]
            assert abs(bolt["points"] + origin - expected["places"]).max() <= 1e-5 * scene.size
            assert bolt["size"] == pytest.approx(expected["force"], rel=1e-3)
    page.evaluate(f"blockViews[0].show({scene.frames - 1})")
    wait_for_drawing(page)
    largest = max(bolt["force"] for bolt in scene.bolts(scene.frames - 1))
    assert f"bolt, largest force: {largest / 1e3:.4g} kN/m" in page.inner_text(".legend")
    assert page.complaints == []


@pytest.mark.parametrize("dark", [False, True])
def test_a_phone_stacks_all_parts(pages, opened, dark):
    phone = {"viewport": {"width": 390, "height": 844}}
    page = opened(pages / "report.html", color_scheme="dark" if dark else "light", **phone)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    names = (".stage", ".bar", ".side", ".charts")
    boxes = [page.locator(name).first.bounding_box() for name in names]
    assert all(above["y"] + above["height"] <= below["y"] + 1
               for above, below in zip(boxes[:-1], boxes[1:], strict=True))  # fmt: skip
    assert all(box["x"] >= 0 and box["x"] + box["width"] <= 390 for box in boxes)
    ink, paper = page.evaluate(
        """['color', 'backgroundColor'].map((name) =>
        getComputedStyle(document.body)[name].match(/\\d+/)[0])"""
    )
    assert (int(ink) > int(paper)) is dark


def test_canvas_2d_draws_without_webgl_and_states_the_reason(run, pages, new_page):
    page = new_page(("file:",))
    page.add_init_script(
        "const get = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
        "return kind === 'webgl2' ? null : get.call(this, kind, ...more); };"
    )
    page.goto((pages / "view.html").as_uri())
    wait_until_decoded(page)
    wait_for_drawing(page)
    assert page.evaluate("blockViews[0].state.renderer") == "Canvas 2D"
    assert "refuses WebGL 2" in page.inner_text(".note")
    colors = page.evaluate(
        """() => { const v = blockViews[0]; v.draw(); const c = v.canvas;
        const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
        return new Set(new Uint32Array(p.buffer)).size; }"""
    )
    assert colors > 3


def test_the_page_blocks_network_and_foreign_scripts(pages, opened):
    """No network access, no scripts from texts, no evaluation of texts."""
    page = opened(pages / "report.html")
    policy = page.get_attribute("meta[http-equiv='Content-Security-Policy']", "content")
    assert policy.startswith("default-src 'none'") and "unsafe" not in policy
    refused = page.evaluate(
        """async () => { const found = [];
        try { await fetch('https://example.org/'); } catch { found.push('network'); }
        const script = document.createElement('script'); script.textContent = 'window.bad = 1';
        document.body.append(script); if (!window.bad) found.push('script');
        const image = document.createElement('img');
        image.setAttribute('onerror', 'window.bad = 1');
        image.src = 'data:image/png;base64,AA'; document.body.append(image);
        await new Promise((next) => setTimeout(next, 100));
        if (!window.bad) found.push('handler');
        return found; }""")  # fmt: skip
    assert refused == ["network", "script", "handler"]


def test_the_view_page_fits_wide_and_narrow_windows(pages, opened):
    """This also applies to a tall model above the scale bar."""
    for width, height in ((1280, 900), (390, 844)):
        page = opened(pages / "view.html", viewport={"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        stage, bar = (page.locator(name).bounding_box() for name in (".stage", ".bar"))
        assert stage["y"] + stage["height"] <= bar["y"] + 1
        page.evaluate("{ const v = blockViews[0]; v.meta.box = [0, 0, 1, 9]; v.fit(); }")
        lowest = place_in_view(page, *page.evaluate("blockViews[0].meta.origin"))[1]
        assert lowest < stage["y"] + stage["height"] - 32
        side = page.locator(".side").bounding_box()
        beside = side["x"] >= stage["x"] + stage["width"] - 1
        assert beside is (width == 1280)


def test_the_view_of_a_model_has_nothing_to_play(write_input, tmp_path, opened):
    page = opened(write_html(report_page(write_input(sliding_blocks())), tmp_path / "model.html"))
    visible_parts = page.evaluate(
        """() => [...document.querySelectorAll('.bar > *')].filter((node) =>
        node.getClientRects().length).map((node) => node.textContent)"""
    )
    assert visible_parts == ["picture", "fit"]
    assert page.complaints == []


def test_a_removed_block_is_gone_from_the_view(write_input, tmp_path, opened):
    from test_pictures import excavated

    groups = [pair for pair in excavated() if pair[0] != "output"]
    run = sitedda.run(write_input([*groups, group("output", block_interval=10)]))
    page = opened(write_view(run, tmp_path / "dug.html"))
    areas = page.evaluate(
        """() => [0, blockViews[0].model.frames - 1].map((f) => { const m = blockViews[0].model;
        m.put(f, 1); return [0, 1, 2].map((b) => m.area(b)); })"""
    )
    assert areas[0] == pytest.approx([15.0] * 3, rel=1e-3)
    assert areas[1] == pytest.approx([15.0, 15.0, 0.0], rel=1e-3)
    assert page.evaluate("blockViews[0].plots[0].stages.map((s) => s[0])")[0] == "shake, low"
    for frame, stage in (("0", "shake, low"), ("blockViews[0].model.frames - 1", "after <b>")):
        page.evaluate(f"blockViews[0].show({frame})")
        wait_for_drawing(page)
        selection = page.get_by_label("stage").locator("option:checked")
        assert selection.inner_text() == stage
    assert page.complaints == []


# --- Without a browser ----------------------------------------------------------------------------


def shaken_grid(blocks: int, frames: int) -> xr.Dataset:
    """Square blocks beside each other, 1 m, that shake at random: nothing to compress."""
    random = np.random.default_rng(2)
    centre = np.column_stack([np.arange(blocks), np.zeros(blocks)]) + 0.5
    corners = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    q = np.zeros((frames, blocks, 6))
    q[..., :2] = centre + np.cumsum(random.normal(size=(frames, blocks, 2)), axis=0) * 0.01
    q[0, :, :2] = centre
    contact = {f"contact_{n}": ("contact", np.zeros(0)) for n in
               ("frame", "state", "bonded", "gap", "normal_force", "shear_force")}  # fmt: skip
    contact |= {f"contact_{n}": ("contact", np.zeros(0, dtype=int)) for n in ("vertex", "edge")}
    vertices = (q[:, :, None, :2] + corners).reshape(frames, -1, 2)
    stress = 1e5 * random.normal(size=(frames, blocks, 3))
    variables = {
        "vertices": (("frame", "vertex", "axis"), vertices),
        "block_coordinates": (("frame", "block", "coordinate"), q),
        "block_rates": (("frame", "block", "coordinate"), random.normal(size=q.shape)),
        "block_stress": (("frame", "block", "component"), stress),
        "frame_time": ("frame", np.arange(frames) / 100),
        "vertex_block": ("vertex", np.repeat(np.arange(blocks), 4)),
    }
    return xr.Dataset(variables | contact)


def test_frames_are_thinned_to_the_budget_and_the_page_reports_it():
    scene = Scene.of(shaken_grid(400, 200))
    full, thin = encode(scene, 10_000_000), encode(scene, 300_000)
    assert len(full.meta["time"]) == full.meta["all_frames"] == 200
    assert thin.size <= 300_000
    assert 10 < len(thin.meta["time"]) < 200 and thin.meta["all_frames"] == 200
    assert (thin.meta["time"][0], thin.meta["time"][-1]) == (0.0, 1.99)


def test_joints_have_slip_and_opening(run):
    """The slip of the right block is the displacement of its centroid relative to the table."""
    scene = Scene.of(run)
    slip, gap = scene.joint_movement(scene.frames - 1)
    displacement = scene.displacement(scene.frames - 1)
    faces = scene.interfaces
    pair = [set(p) == {0, 2} for p in zip(faces.first, faces.second, strict=True)]
    assert sum(pair) == 1
    expected = abs(displacement[2, 0] - displacement[0, 0])
    assert expected > 0.05
    assert slip[pair][0] == pytest.approx(expected, rel=0.02)
    assert gap[pair][0] < 1e-3


def test_charts_have_ticks_and_units_and_scales_are_those_of_pictures(pages, opened, run):
    from sitedda.drawing.quantities import OWN_QUANTITIES, QUANTITIES, limits_of, select_frames

    page = opened(pages / "view.html")
    charts = page.evaluate("blockViews[0].plots.map((p) => [p.state.ticks, p.title.innerText])")
    assert all(len(ticks) >= 3 and title.endswith(")") for ticks, title in charts)
    page.evaluate("blockViews[0].draw()")
    charts = page.evaluate("""blockViews[0].plots.flatMap((p) => p.lines.map((l) =>
        [l.value.textContent.replaceAll("−", "-"), l.y[l.y.length - 1] / p.scale]))""")
    for chart_lines, last in charts:  # at the end, which the page opens with
        assert float(chart_lines.split(" ")[0]) == pytest.approx(last, rel=1e-3, abs=1e-4), charts
    scene = Scene.of(run)
    for name in QUANTITIES.keys() - set(OWN_QUANTITIES):
        view_range = page.evaluate(f"blockViews[0].model.range('{name}', {scene.frames - 1})")
        expected = limits_of(scene, name, [scene.frames - 1])
        smallest = 1.0 if QUANTITIES[name].unit == "Pa" else 1e-9
        assert view_range["high"] == pytest.approx(expected.high, rel=2e-3, abs=smallest), name
        assert view_range["usual"] == pytest.approx(expected.usual, rel=2e-3, abs=smallest), name
        full_range = page.evaluate(f"blockViews[0].model.range('{name}', -1)")
        assert full_range["high"] == limits_of(scene, name, select_frames(range(scene.frames))).high


def test_histories_of_rounding_errors_have_no_chart(run):
    history = run.history.copy()
    titles = []
    for factor in (1.0, 1e-12):
        for name in ("displacement", "base_displacement", "acceleration"):
            history[name] = factor * run.history[name]
        charts = view(Scene.of(history)).meta["charts"]
        titles.append([chart["title"] for chart in charts if "measured points" in chart["title"]])
    assert len(titles[0]) == 2 and titles[1] == []


def test_keys_control_the_view_and_joints_have_histories(pages, opened, run):
    page = opened(pages / "view.html", viewport={"width": 1280, "height": 900})
    page.evaluate("blockViews[0].canvas.focus()")
    state = "(() => { const v = blockViews[0]; return [v.color, v.contacts, v.camera.x, v.frame,"
    state += " v.picked, v.span && v.span[1] - v.span[0], v.camera.scale]; })()"
    before = page.evaluate(state)
    for key in ("c", "x", "Shift+ArrowRight", "Home", "ArrowRight", "]", ".", "+"):
        page.keyboard.press(key)
    after = page.evaluate(state)
    assert all(a != b for a, b in zip(before, after, strict=True))
    page.keyboard.press("f")
    pick = "v.pickJoint(v.model.faceBlocks.indexOf(2) >> 1)"
    show = "v.setContacts('slip'); v.show(v.model.frames - 1)"
    page.evaluate(f"(v => {{ {show}; {pick}; v.draw(); }})(blockViews[0])")
    assert page.inner_text(".info h3") == "table – right"
    last = page.evaluate("(l => l[0].y[l[0].y.length - 1])(blockViews[0].blockChart.lines)")
    scene = Scene.of(run)
    assert last == pytest.approx(scene.joint_movement(scene.frames - 1)[0].max(), rel=1e-3)
    assert page.complaints == []


def test_picture_data_and_state_can_be_saved(pages, opened, tmp_path):
    from PIL import Image

    page = opened(pages / "view.html", viewport={"width": 1000, "height": 900})
    with page.expect_download() as saved:
        page.click("button.save")
    saved.value.save_as(tmp_path / "view.png")
    assert np.asarray(Image.open(tmp_path / "view.png").convert("RGB")).std() > 10
    with page.expect_download() as saved:
        page.get_by_role("button", name="data").click()
    saved.value.save_as(tmp_path / "view.csv")
    head, *rows = (tmp_path / "view.csv").read_text(encoding="utf-8").splitlines()
    assert head == "chart,line,time (s),value" and len(rows) > 100
    page.evaluate("blockViews[0].setColor('rotation')")
    page.wait_for_url(re.compile("color=rotation"), wait_until="commit")
    second_page = opened(pages / "view.html")
    second_page.goto("about:blank")  # an address alone that changes loads no page
    second_page.goto(page.url.replace("rotation", "velocity"))
    wait_until_decoded(second_page)
    assert second_page.evaluate("blockViews[0].color") == "velocity"


def test_two_runs_have_one_cursor_and_a_difference_only_if_blocks_agree(run, opened, tmp_path):
    page = opened(write_view(run, tmp_path / "two.html", other=run, difference=True))
    page.evaluate("blockViews[0].show(3)")
    assert page.evaluate("blockViews.map((v) => v.frame)") == [3, 3]
    page.evaluate("blockViews[1].show(5)")
    assert page.evaluate("blockViews.map((v) => v.frame)") == [5, 5]
    page.evaluate("blockViews[0].draw()")
    assert "at rest" in page.locator(".legend").first.inner_text()  # no difference at all
    assert page.complaints == []
    with pytest.raises(sitedda.InputError, match="runs of 3 and 4 blocks have no difference"):
        write_view(run, tmp_path / "x.html", other=shaken_grid(4, 5), difference=True)


def test_modes_are_played_as_they_are_computed(write_input, opened, tmp_path):
    from model_text import tower

    from sitedda.drawing.modes import draw_modes, mode_scene

    file = write_input(tower())
    scene, modes = mode_scene(file, 2)
    expected = sitedda.modes(file, 2)
    assert modes.frequency == pytest.approx(expected.frequency)
    for mode in (0, 1):
        peak = scene.displacement(24 * (mode + 1))
        shape = expected.shapes[mode][:, :2]
        fraction = peak / np.linalg.norm(peak, axis=1).max()
        shape = shape / np.linalg.norm(shape, axis=1).max()
        assert abs(fraction) == pytest.approx(abs(shape), abs=1e-6)
    page = opened(write_view(scene, tmp_path / "modes.html", color="displacement"))
    assert page.evaluate("blockViews[0].loopEnd()") == [25, 48]
    assert "arbitrary" in page.inner_text(".note")
    titles = [axes.get_title(loc="left") for axes in draw_modes(file, 2).axes]
    assert titles[0] == f"mode 1: {expected.frequency[0]:.4g} Hz"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_report_and_view_have_no_accessibility_errors(pages, new_page, scheme):
    axe = pytest.importorskip("axe_playwright_python.base")
    script = Path(axe.__file__).with_name("axe.min.js").read_text(encoding="utf-8")
    for name in ("report.html", "view.html"):
        for width in (1280, 400):
            look = {"viewport": {"width": width, "height": 900}, "color_scheme": scheme}
            page = new_page(("file:",), bypass_csp=True, **look)
            page.goto((pages / name).as_uri())
            wait_until_decoded(page)
            page.evaluate("(v => { v.setContacts('slip'); v.pick(1); })(blockViews[0])")
            wait_for_drawing(page)
            page.evaluate(script)
            violations = page.evaluate("axe.run().then((r) => r.violations.map((v) => v.id))")
            assert violations == [], (name, width)
            assert page.evaluate("document.documentElement.scrollWidth") <= width


NOTEBOOK = """async ([source, state]) => {
    const {default: widget} = await import("data:text/javascript," + encodeURIComponent(source));
    const heard = {};
    window.model = {get: (name) => state[name], set: (name, value) => { state[name] = value; },
        on: (event, act) => { heard[event] = act; }, save_changes: () => save(state),
        put: (name, value) => { state[name] = value; heard[`change:${name}`](); }};
    widget.render({model, el: document.body}); }"""


def test_a_block_that_is_picked_in_a_notebook_is_a_value_in_python(run, new_page):
    """The module of the widget, in a page with the model of a notebook."""
    pytest.importorskip("anywidget")
    widget = run.widget(color="material")
    names = ("page", "picked", "time")
    page = new_page(("about:", "data:"), viewport={"width": 1000, "height": 900})
    page.expose_function("save", lambda state: widget.set_state({n: state[n] for n in names}))
    page.evaluate(NOTEBOOK, [widget._esm, {name: getattr(widget, name) for name in names}])
    frame = page.wait_for_selector("iframe").content_frame()
    wait_until_decoded(frame)
    page.evaluate("model.put('time', 0)")
    x, y = place_in_view(frame, 5.5, 1.5)
    left, top = (page.locator("iframe").bounding_box()[axis] for axis in "xy")
    page.mouse.click(left + x, top + y)
    wait_until(page, lambda: widget.picked == "right")
    page.evaluate("model.put('picked', 'table')")
    wait_until(page, lambda: frame.inner_text(".info h3") == "table")
    page.evaluate("model.put('time', 0.1)")
    wait_until(page, lambda: widget.time == 0.1)
    assert page.complaints == []


def test_water_in_the_view_is_that_of_the_output(opened, tmp_path):
    """Pressures of channels in each frame, dashes if not full, and the legend."""
    model = sitedda.Model("wet", time_step=1e-3, steps=20)
    model.material("rock", density=2500.0, young_modulus=1e9, poisson_ratio=0.2)
    model.joint("joint", friction_angle=35.0)
    model.block([0, 0, 4, 0, 4, 1, 0, 1], name="low")
    model.block([0, 1, 4, 1, 4, 2, 0, 2], name="top")
    model.fixed_point(1, 0.5, "low")
    model.fixed_point(3, 0.5, "low")
    model.output(block_interval=5)
    model.flow(aperture=1e-4, channel_length=1.0, saturation=0.5, state="transient")
    model.flow_boundary(side="left", pressure=2e5)
    run = sitedda.run(model)
    page = opened(write_view(run, tmp_path / "wet.html"))
    scene = Scene.of(run)
    for frame in range(scene.frames):
        view_lines = page.evaluate(f"blockViews[0].model.lines('water', {frame}, 1)")
        pressure, full, _ = scene.water(frame)
        assert [line["state"] for line in view_lines] == [1 if is_full else 2 for is_full in full]
        np.testing.assert_allclose([line["size"] for line in view_lines], pressure, rtol=1e-3)
    assert not full.all()
    page.evaluate(f"blockViews[0].show({scene.frames - 1})")
    wait_for_drawing(page)
    largest = pressure.max()
    pressure = f"largest pressure: {largest / 1e3:.4g} kPa"
    assert f"water in joints, {pressure}" in page.inner_text(".legend")
    assert page.complaints == []
