# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of `sitedda live` in the system's Chromium, headless.

With SITEDDA_PICTURES=FOLDER the pictures of docs/live.md are taken.
"""

import json
import os
import time
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from environment import DEADLINE
from live_server import LiveProcess, live
from random_content import random_model
from test_live import COMPARED, PILE, failing

import sitedda

pytestmark = pytest.mark.slow

PICTURES = os.environ.get("SITEDDA_PICTURES")
ENDLESS = PILE.replace("duration = 0.6", "duration = 6e5").replace(
    "interval = 20", "interval = 1000\n   history_interval = 1000"
)  # few data, because the run is longer than the test
OPEN_ALL = "all => all.forEach((details) => { details.open = true; })"
OVER = "page.run && ['done', 'failed', 'stopped'].includes(page.run.status)"


@pytest.fixture
def served(tmp_path):
    folder = Path(PICTURES or tmp_path) / "models"
    folder.mkdir()
    with live(folder, tmp_path / "state") as server:
        yield server


@pytest.fixture
def opened(new_page):
    """Return an opener of pages of a server; it records errors of the page."""

    def enter(server: LiveProcess, **options):
        options = {"viewport": {"width": 1400, "height": 900}} | options
        page = new_page((server.address, "file:", "data:"), **options)
        page.goto(server.redirect_page.as_uri())
        until(page, "window.page && (page.view.state.decoded || "
                    "!document.getElementById('start').hidden)")  # fmt: skip
        return page

    return enter


def until(page, condition: str) -> None:
    """Wait until an expression of the page is true; its policy forbids Playwright's own method."""
    end = time.monotonic() + DEADLINE
    while True:
        try:
            if page.evaluate(condition):
                return
        except Exception as trouble:  # the page is just being forwarded
            if "context" not in str(trouble) and "not defined" not in str(trouble):
                raise
        assert time.monotonic() < end, page.evaluate(
            "JSON.stringify([page.run, page.view.state, ...['said', 'trouble'].map((id) => "
            "document.getElementById(id).textContent)])"
        )
        time.sleep(0.05)


def drawn(page) -> None:
    """Wait until the newest version of the model is drawn."""
    until(page, "page.view.state.decoded && page.view.state.good === page.model.version "
                "&& page.view.state.version === page.model.version")  # fmt: skip


@contextmanager
def edited(page):
    """Wait until the edits within the context have been stored and drawn as a newer version."""
    before = page.evaluate("page.model ? page.model.version : -1")
    yield
    until(page, f"page.model?.version > {before}")
    drawn(page)


def holds(page, text: str) -> None:
    """Wait until the input contains a text and is drawn."""
    until(page, f"page.model.text.includes({json.dumps(text)})")
    drawn(page)


def begun(page, name: str):
    """Return the page with a model that is opened from the start page."""
    with edited(page):
        press(page, name)
    return page


@pytest.fixture
def page_of(served, opened):
    """Return an opener of pages with a model."""

    def open_model(text: str):
        (served.folder / "pile.nml").write_text(text)
        return begun(opened(served), "pile.nml")

    return open_model


def over(page) -> None:
    """Wait until the run has ended and is drawn completely."""
    until(page, OVER)
    page.evaluate("page.drawing.then(() => true)")


def picture(page, name: str) -> None:
    if PICTURES:
        page.wait_for_timeout(400)
        page.screenshot(path=str(Path(PICTURES) / f"{name}.png"))


def field(page, group: str, variable: str):
    """Return the field of a variable; open its group."""
    box = page.locator(f'[data-group="{group}"]')
    if box.get_attribute("open") is None:
        box.locator("summary").first.click()
    key = f"{group} {variable}"
    element = page.locator(f'[data-key="{key}"]')
    if element.count() == 0:
        box.locator("details.more summary").click()
    return element


def type_into(element, text: str) -> None:
    """Replace the text of a field."""
    element.fill(text)
    element.press("Enter")


def type_numbers(page, group: str, **numbers) -> None:
    """Type numbers into fields of a group."""
    for variable, text in numbers.items():
        type_into(field(page, group, variable), text)
        holds(page, f"{variable} = {text}")


def add(page, kind: str) -> None:
    page.locator("#add-kind").select_option(kind)
    with edited(page):
        press(page, "Add")


def press(page, name: str, condition: str = "true") -> None:
    """Press a button, and wait until an expression of the page is true."""
    page.get_by_role("button", name=name, exact=True).click()
    until(page, condition)


def test_from_nothing_to_a_shaken_slope_with_its_movie_and_report(served, opened):
    page = opened(served)
    until(page, "page.start.cards.size > 10")
    if PICTURES:
        page.wait_for_timeout(8000)
    picture(page, "start")
    begun(page, "An empty model")
    type_numbers(page, "measured_point 1", x="35", y="18")
    type_numbers(page, "region 1", outline="0, 0, 90, 0, 60, 30, 30, 30")
    type_numbers(page, "measured_point 1", x="40", y="30")
    add(page, "joint")
    type_numbers(page, "joint 2", friction_angle="38")
    for number, (angle, spacing) in enumerate([("20", "5"), ("105", "7")], 1):
        add(page, "joint_set")
        type_numbers(page, f"joint_set {number}", angle=angle, spacing=spacing)
    add(page, "motion")
    with edited(page):
        page.get_by_label("shipped record").select_option(index=1)
    with edited(page):
        field(page, "boundary 1", "motion_x").select_option("shaking")
    type_numbers(page, "control 1", duration="8" if PICTURES else "0.5", time_step="1e-3")
    type_numbers(page, "motion 1", scale="2")
    blocks = page.evaluate("page.view.model.n")
    assert blocks > 40
    picture(page, "model")

    press(page, "Rest", "page.run?.status === 'paused'")
    assert page.evaluate("page.run.time") == 0
    press(page, "Run", "page.view.model.frames > 3")
    page.locator(".choices .field", has_text="contacts").locator("select").select_option("force")
    picture(page, "run")
    over(page)
    assert page.evaluate("page.run.status") == "done"
    assert page.evaluate("page.view.plots.length") >= 2
    assert "what happened" in page.locator("#verdict table").inner_text()
    page.evaluate("page.view.pick(3)")
    picture(page, "done")

    page.get_by_role("tab", name="Save").click()
    for kind in ("namelist", "script", "report", "output", "movie"):
        press(page, f"save the {kind}")
        until(page, f"page.saves.fields.{kind}.words.textContent.startsWith('saved')")
    picture(page, "save")
    saved_files = {f.suffix: f for f in served.folder.iterdir() if "input" not in f.name}
    assert saved_files.keys() >= {".nml", ".py", ".html", ".mp4", ".nc"}
    assert page.complaints == []
    repeated_run = sitedda.run(saved_files[".nml"]).history
    with sitedda.open_output(saved_files[".nc"]) as data:
        assert data.sizes["block"] == blocks and str(data.attrs["stages"]).startswith("rest")
        for name in COMPARED:
            assert np.array_equal(data[name].values, repeated_run[name].values), name


def test_an_invalid_value_is_reported_at_its_field_and_the_picture_remains(served, opened):
    page = begun(opened(served), "An empty model")
    heads = page.locator("details.group > summary").all_inner_texts()
    assert "control\ntime step 0.001 s" in heads and not any("_" in head for head in heads)
    title = "([group, values]) => page.forms.title(values, page.forms.kinds.get(group))"
    for group, value, text in (
        ("contact", {"normal_stiffness": "15446984225.7"}, "15.45 GN/m"),
        ("control", {"gravity": "0.0, -9.81234567"}, "0, −9.812 m/s²"),
        ("control", {"analysis": "plane_strain"}, "plane strain"),
    ):
        assert page.evaluate(title, [group, value]).endswith(f" {text}")
    page.locator("details").evaluate_all(OPEN_ALL)
    field(page, "control 1", "settle").wait_for()
    placeholders = "all => all.map((item) => item.placeholder || item.textContent).join('\\n')"
    texts = page.locator("#panel-form :is(.row option, input)").evaluate_all(placeholders)
    assert "plane strain" in texts and "_" not in texts and ".true." not in texts
    before = page.evaluate("page.view.model.n")
    for text, message in (("95", "0 and 89"), ("steep", "steep")):
        type_into(field(page, "joint 1", "friction_angle"), text)
        script = "document.querySelector('.row:has([aria-invalid=true]) .wrong')?.textContent"
        until(page, f"({script} || '').includes('{message}')")
    assert page.evaluate("page.view.model.n") == before
    type_numbers(page, "joint 1", friction_angle="33")
    assert page.evaluate("document.querySelector('[aria-invalid=true]') === null")
    press(page, "Undo", "page.model.text.includes('friction_angle = 95')")
    with edited(page):
        press(page, "Undo")
    page.get_by_role("tab", name="Text").click()
    until(page, "document.querySelector('#text').value.includes('friction_angle = 35')")


def test_a_slider_cuts_repeatedly_and_the_text_is_the_same_model(served, opened):
    page = begun(opened(served), "An empty model")
    page.get_by_role("tab", name="Text").click()
    page.locator("#text").press("Control+End")
    page.locator("#text").type("! mine\n&joint_set joint = 'joint', angle = 20, spacing = 4 /\n")
    until(page, "page.groups.some((g) => g.name === 'joint_set')")
    drawn(page)
    initial_count = page.evaluate("page.view.model.n")
    page.get_by_role("tab", name="Form").click()
    field(page, "joint_set 1", "spacing")
    slider = page.locator('[data-group="joint_set 1"] [aria-label="spacing, slider"]')
    slider.focus()
    for _ in range(40):
        slider.press("ArrowLeft")
    last = slider.evaluate("slider => String(+Number(slider.value).toPrecision(4))")
    holds(page, f"spacing = {last} ")
    assert page.evaluate("page.view.model.n") > initial_count
    text = page.evaluate("page.model.text")
    assert "! mine" in text and "spacing = 4 " not in text


def test_the_page_has_no_accessibility_errors_on_phones_and_in_dark_mode(served, opened):
    axe = pytest.importorskip("axe_playwright_python.base")
    script = Path(axe.__file__).with_name("axe.min.js").read_text(encoding="utf-8")
    (served.folder / "pile.nml").write_text(PILE)
    for options in ({}, {"color_scheme": "dark"}, {"viewport": {"width": 400, "height": 800}}):
        page = opened(served, **options)

        def check_page(label: str, page=page, options=options) -> None:
            page.evaluate(script)
            violations = page.evaluate("axe.run().then((r) => r.violations.map((v) => "
                                  "[v.id, v.nodes.map((n) => n.html.slice(0, 90))]))")  # fmt: skip
            assert violations == [], (label, options)
            fits_width = "document.scrollingElement.scrollWidth <= innerWidth"
            assert page.evaluate(fits_width), (label, options)

        check_page("start")
        begun(page, "pile.nml")
        page.locator("details").evaluate_all(OPEN_ALL)
        check_page("forms")
        press(page, "Check", "page.check?.state === 'done'")
        assert page.locator("#verdict table").is_visible(), page.locator("#verdict").inner_text()
        check_page("check")
        page.get_by_role("tab", name="Text").click()
        check_page("text")
        press(page, "Run")
        over(page)
        check_page("run")
        page.get_by_role("tab", name="Save").click()
        check_page("save")
        press(page, "Start page", "!document.getElementById('start').hidden")
        assert page.complaints == []


def test_names_of_points_do_not_overlap(page_of):
    page = page_of(random_model(32))
    boxes = page.evaluate(
        """() => { const v = page.view, boxes = [], half = 5;
        v.write = (c, text, x, y) =>
          boxes.push([x, y - half, x + c.measureText(text).width, y + half]);
        v.overlaid = ''; v.drawOverlay(); return boxes; }"""
    )
    assert len(boxes) == 3
    for (left, bottom, right, top), other in combinations(boxes, 2):
        assert left >= other[2] or other[0] >= right or bottom >= other[3] or other[1] >= top


def test_keys_control_the_page(served, opened):
    (served.folder / "pile.nml").write_text(PILE)
    page = opened(served)

    def go_to(name: str) -> None:
        for _ in range(200):
            page.keyboard.press("Tab")
            if page.evaluate("document.activeElement.textContent") == name:
                return
        raise AssertionError(f"Tab does not come to {name}")

    go_to("pile.nml")
    with edited(page):
        page.keyboard.press("Enter")
    go_to("Form")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("document.activeElement.textContent") == "Text"
    go_to("Run")
    page.keyboard.press("Enter")
    over(page)
    page.evaluate("page.view.canvas.focus()")
    page.keyboard.press("]")
    assert page.evaluate("page.view.state.picked") == "table"
    scale = page.evaluate("page.view.camera.scale")
    page.keyboard.press("j")
    assert page.evaluate("page.view.state.picked").startswith("table – ")
    until(page, "page.view.info.textContent.includes('shear force')")
    page.keyboard.press("+")
    assert page.evaluate("page.view.camera.scale") > scale


def test_a_page_that_is_reloaded_or_opened_again_shows_model_and_run(served, opened, page_of):
    page = page_of(ENDLESS)
    press(page, "Run", "page.run?.status === 'running' && page.view.model.frames > 3")
    page.reload()
    until(page, "window.page?.run?.status === 'running' && page.view.model?.frames > 3")
    page.close()
    page = opened(served)
    until(page, "page.run?.status === 'running' && page.view.model.frames > 3")
    press(page, "Pause", "page.run.status === 'paused'")
    press(page, "Edit the model", "page.run === null")
    drawn(page)


def test_a_joint_can_be_clicked_and_shows_the_forces_between_its_blocks(page_of):
    page = page_of(PILE)
    press(page, "Run")
    over(page)
    at = page.evaluate(
        "(() => { const v = page.view, m = v.model, p = m.poses(v.frame);"
        " const out = new Float64Array(7);"
        " const k = m.jointBetween(0, 1); m.joint(k, v.frame, p, out);"
        " const b = v.stage.getBoundingClientRect(), c = v.camera, r = c.width / b.width;"
        " const x = (out[2] + out[4]) / 2, y = (out[3] + out[5]) / 2;"
        " return [b.left + (c.width / 2 + c.scale * (x - c.x)) / r,"
        " b.top + (c.height / 2 - c.scale * (y - c.y)) / r]; })()"
    )
    page.mouse.click(*at)
    until(page, "page.view.info.textContent.includes('normal force')")
    assert page.evaluate("page.view.state.picked").startswith("table – ")
    forces = page.evaluate(
        "(() => { const v = page.view, owner = v.model.owner(); let sum = 0;"
        " for (const [a, b, , n] of v.model.contactForces(v.frame))"
        " if (owner[a] + owner[b] === 1) sum += n;"
        " return [sum, v.model.jointForce(v.pickedJoint, v.frame)[0]]; })()"
    )
    assert forces[0] == forces[1] > 0


def test_a_step_that_fails_shows_the_failed_contact(page_of):
    page = page_of(failing())
    press(page, "Run")
    over(page)
    assert page.evaluate("page.view.failing") == [1, 0]
    assert page.evaluate("page.view.pickedJoint") >= 0
    camera = "[page.view.camera.x, page.view.camera.y]"
    until(page, f"page.view.model.nearest(1, 0).slice(0, 2).join() === {camera}.join()")
    picture(page, "failed")


def test_a_replaced_joint_is_a_stage_of_the_saved_namelist(served, page_of):
    page = page_of(f"{ENDLESS}&joint name = 'ice', friction_angle = 1 /\n")
    press(page, "Run", "page.run?.status === 'running' && page.view.model.frames > 2")
    press(page, "Pause", "page.run.status === 'paused'")
    page.get_by_label("replace joint").select_option(index=1)
    page.get_by_label("by joint", exact=True).select_option("ice")
    press(page, "Begin", "page.run.actions.length === 1")
    page.get_by_role("tab", name="Save").click()
    press(page, "save the namelist")
    until(page, "page.saves.fields.namelist.words.textContent.startsWith('saved')")
    assert " -> ice'" in (served.folder / "pile_live.nml").read_text()


def test_a_group_remains_open_if_the_form_is_rebuilt_at_once(page_of):
    page = page_of(PILE)
    assert page.evaluate(
        "() => { const box = () => document.querySelector('[data-group=\"joint 1\"]');"
        " box().querySelector('summary').click(); page.forms.build(); return box().open; }"
    )


def test_a_field_shows_the_present_or_the_pending_value(page_of):
    page = page_of(PILE)
    press(page, "Rest", "page.run?.status === 'paused'")
    friction = page.locator('[data-change="joint[1].friction_angle"]')
    initial_value = friction.input_value()
    page.evaluate("() => { page.changes.ask = () => true; }")  # the server receives no change
    type_into(friction, "25")

    pending = page.locator(".change-panel .wrong", has_text="not yet")
    assert f"not yet changed from {initial_value}" in pending.inner_text()
    page.evaluate("() => { page.changes.ask = page.ask; page.ask('change', "
                  "{values: {'joint[1].friction_angle': '25'}}); }")  # fmt: skip
    until(page, "page.run.actions.length === 1")
    until(page, "!document.querySelector('.change-panel').textContent.includes('not yet')")
    assert friction.input_value() == "25"
    type_into(friction, "95")
    until(page, "document.querySelector('#said').classList.contains('bad')")
    assert friction.input_value() == "25"
    press(page, "Run")
    over(page)
    assert friction.is_disabled() and friction.input_value() == "25"
    page.evaluate("page.ask('change', {values: {'joint[1].friction_angle': '12'}})")
    until(page, "document.querySelector('#said').textContent.includes('has ended')")
    press(page, "Edit the model", "page.run === null")
    press(page, "Rest", "page.run?.status === 'paused'")
    assert friction.input_value() == initial_value and page.evaluate("page.run.actions") == []
    assert page.complaints == []


def test_another_model_fills_the_view_and_selections_are_cleared(served, page_of):
    (served.folder / "fails.nml").write_text(failing())
    page = page_of(PILE)
    fitted_scale = page.evaluate("page.view.camera.scale")
    page.evaluate("page.view.pick(1)")
    page.evaluate("page.view.setColor('displacement')")
    until(page, "page.view.root.textContent.includes('nothing has run')")
    info_text, chart = page.evaluate("[page.view.info.innerText, !!page.view.blockChart]")
    assert "centroid" in info_text and "compressive" not in info_text and not chart
    press(page, "Step", "page.run?.status === 'paused' && page.view.blockChart")
    until(page, "page.view.info.innerText.includes('compressive')")
    remove = page.locator(".stage-form .row", has_text="remove").locator("input").first
    assert remove.input_value() == ""
    press(page, "remove the selected block")
    assert remove.input_value() == "low"
    zoomed_view = """(() => { const v = page.view, {scale} = v.camera; v.zoom(4, 0, 0);
    for (const [width, height] of [["1px", "1px"], ["700px", "1px"], ["", ""]]) {
        Object.assign(v.stage.style, {width, height}); v.resize(); }
    return v.camera.scale / scale; })()"""
    assert page.evaluate(zoomed_view) == pytest.approx(4.0)
    press(page, "Start page", "!document.getElementById('start').hidden")
    page.evaluate("page.view.forget(); page.view.draw()")
    press(page, "fails.nml", "page.model.file === 'fails.nml' && page.view.color === 'material'")
    drawn(page)
    view_state = page.evaluate("[page.view.camera.scale, page.view.color, page.view.picked]")
    assert view_state == [pytest.approx(fitted_scale), "material", -1]
    press(page, "Run")
    over(page)
    message_box = page.locator("#trouble").bounding_box()
    assert "does not converge" in page.locator("#trouble").inner_text()
    assert message_box["y"] + message_box["height"] < 900
    assert page.complaints == []


def test_a_second_joint_set_crosses_the_first(served, opened):
    page = begun(opened(served), "An empty model")
    for _ in range(3):
        add(page, "joint_set")
    angles = page.evaluate(
        "page.groups.filter((g) => g.name === 'joint_set').map((g) => g.values.angle)"
    )
    assert len(set(angles)) == 3
