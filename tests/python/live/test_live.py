# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda live`: sessions, access control, saved files and stored state."""

import asyncio
import json
import random
import runpy
import stat
import sys
import threading
from contextlib import suppress
from html import unescape
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from environment import DEADLINE, captured, wait_for
from live_server import Client, LiveProcess, connect, live, talk
from model_text import group, namelist
from test_added_stages import pile
from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest
from tornado.websocket import WebSocketClosedError

import sitedda
from sitedda.block_file import write_block_file
from sitedda.live import drawn
from sitedda.live.document import Document, locate_error
from sitedda.live.running import LiveRun
from sitedda.live.script import literal
from sitedda.live.session import Session
from sitedda.scene import Scene

COMPARED = ("time", "displacement", "vertices", "block_rates", "energy_strain", "energy_friction")
PILE = namelist([
    group("run", title="pile"),
    *pile(duration=0.6, time_step_control="adaptive", settle=True),
])  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "work"
    path.mkdir()
    (path / "pile.nml").write_text(PILE)
    return path


@pytest.fixture
def server(folder, tmp_path):
    with live(folder, tmp_path / "state") as process:
        yield process


def same_bits(*outputs) -> bool:
    return all(np.array_equal(*(output[name] for output in outputs)) for name in COMPARED)


# --- independence of other parts--------------------------------------------------------------


def test_a_run_imports_nothing_of_the_server(folder):
    code = (
        "import sys; from sitedda.commands.command import main; "
        "main(['run', 'pile.nml', '--quiet', '--no-plot']); "
        "found = [m for m in sys.modules if m.startswith(('tornado', 'sitedda.live'))]; "
        "assert not found, found"
    )
    process = captured([sys.executable, "-c", code], cwd=folder)
    assert process.returncode == 0, process.stderr


def test_without_the_library_one_sentence_says_what_to_install(folder):
    code = "import sys; sys.modules['tornado'] = None; from sitedda.program import main; "
    command = [sys.executable, "-c", f"{code}sys.exit(main(['live', '--no-open']))"]
    process = captured(command, cwd=folder)
    assert process.returncode == 1 and "pip install 'sitedda[live]'" in process.stderr
    assert "Traceback" not in process.stderr


# --- the document ----------------------------------------------------------------------------

TEXT = """! about the model
&control time_step = 1e-3, steps = 3 / ! the steps
&joint name = 'bed', friction_angle = 38 /  ! tested
! the second
&joint name = 'cross', friction_angle = 30 /
"""


def test_edits_keep_comments_and_are_undone_singly():
    document = Document(TEXT, "m.nml")
    for angle in ("31", "32", "33"):  # a slider makes one version
        document.set("joint", 2, "friction_angle", angle)
    assert "friction_angle = 33 /" in document.text and "! the second" in document.text
    document.settle()
    document.set("joint", 2, "friction_angle", "34")
    document.set("control", 1, "steps", "7")
    document.undo()
    document.undo()
    assert "friction_angle = 33" in document.text
    document.undo()
    assert document.text == TEXT
    document.redo()
    assert "friction_angle = 33" in document.text and document.described()["redo"]


def test_groups_are_added_with_unique_names_and_removed_with_their_lines():
    document = Document(TEXT, "m.nml")
    document.add("joint")
    document.add("joint")
    names = [group["values"]["name"] for group in document.described()["groups"] if group["number"]
             and group["name"] == "joint"]  # fmt: skip
    assert names == ["bed", "cross", "bedding", "bedding_2"]
    document.take_out("joint", 4)
    document.take_out("joint", 3)
    document.take_out("joint", 2)
    assert document.text == TEXT.replace("&joint name = 'cross', friction_angle = 30 /\n", "")
    with pytest.raises(sitedda.InputError, match="no &joint number 2"):
        document.take_out("joint", 2)


def test_an_invalid_value_changes_nothing_and_its_message_has_a_field():
    document = Document(TEXT, "m.nml")
    with pytest.raises(sitedda.InputError):
        document.set("joint", 1, "friction_angle", "steep")
    assert document.text == TEXT
    message = "m.nml, group &joint (line 5): friction_angle = 95 must lie between 0 and 89"
    field = {"group": "joint", "number": 2, "variable": "friction_angle", "line": 5}
    assert locate_error(message, TEXT, "m.nml") == field


@pytest.mark.parametrize(
    ("text", "python"),
    [("30", "30.0"), ("0, -9.81", "(0.0, -9.81)"), (".false.", "False"), ("none", "'none'"),
     ("1d-3", "0.001"), ("a -> b", "'a -> b'")],
)  # fmt: skip
def test_typed_values_are_literals_of_a_script(text, python):
    assert literal(text) == python


def test_many_blocks_are_drawn_from_a_file_as_from_text(root, monkeypatch):
    file = root / "inputs" / "slope.nml"
    block_files, pictures = [], []

    def store_file(target, blocks):
        block_files.append(target)
        return write_block_file(target, blocks)

    monkeypatch.setattr(drawn, "write_block_file", store_file)
    for limit in (1_000, 1):
        monkeypatch.setattr(drawn, "_FILE_BLOCKS", limit)
        pictures.append(drawn.draw_model(file.read_text(), file))
    assert len(block_files) == 1 and not block_files[0].exists()
    from_text, from_file = pictures
    assert from_text.message == from_file.message and from_text.notes == from_file.notes


# --- the run ---------------------------------------------------------------------------------


def test_a_later_page_receives_the_valid_picture(server):
    async def use():
        async with Client(server) as first:
            await first.open()
            valid_message = await first.until(lambda m: m["kind"] == "good")
            async with Client(server) as later_page:
                assert await later_page.until(lambda m: m["kind"] == "good") == valid_message

    talk(use())


def steered(server, steps: int, command: str, values: dict, *kinds: str) -> tuple:
    """Change a settled run after some steps and complete it; return messages, files and output."""

    async def use():
        async with Client(server) as page:
            await page.open()
            await page.until(lambda m: m["kind"] == "good")
            await page.ask("rest")
            await page.status("paused")
            await page.ask("step", steps=steps)
            await page.until(lambda m: m["kind"] == "run" and m["status"] == "paused"
                             and m["step"] == steps)  # fmt: skip
            await page.ask(command, values=values)
            await page.ask("run")
            await page.status("done")
            files = [await page.saved("output", "live")]
            return page.messages, [*files, *[await page.saved(kind, "saved") for kind in kinds]]

    messages, (output, *files) = talk(use())
    with sitedda.open_output(output) as data:
        return messages, files, data.load()


def test_the_saved_namelist_is_bit_identical(server):
    stage = {"name": "digging", "remove": "low"}
    kinds = ("namelist", "script", "report")
    messages, (namelist, script, report), data = steered(server, 50, "stage", stage, *kinds)
    last_message = next(m for m in messages if m["kind"] == "run" and m["status"] == "done")
    assert last_message["verdict"]["lines"] and last_message["verdict"]["charts"]
    assert sum(m["kind"] == "frame" for m in messages) > 2
    assert "&stage name = 'digging'" in namelist.read_text()
    assert same_bits(data, sitedda.run(namelist).history)
    assert report.read_text().startswith("<!doctype html>")
    assert "run.begin_stage(name='digging', remove='low')" in script.read_text()


def test_a_new_friction_as_a_stage_is_bit_identical(server):
    text = PILE.replace("gravity = 0.0, -9.81", "gravity = -2.0, -9.81")
    (server.folder / "pile.nml").write_text(f"{text}&joint name = 'ice', friction_angle = 1 /\n")
    stage = {"name": "wet", "change_joints": "dry -> ice"}
    _, (namelist,), data = steered(server, 50, "stage", stage, "namelist")
    assert "in the script alone" not in namelist.read_text()
    displacement = data.displacement.sel(point="top", axis="x")
    assert abs(displacement.sel(time=0.05, method="nearest")) < 1e-3 < 0.1 < abs(displacement[-1])
    assert same_bits(data, sitedda.run(namelist).history)


def test_the_saved_script_is_bit_identical_with_changes_outside_stages(server, monkeypatch):
    change = {"joint[1].friction_angle": "2"}
    kinds = ("script", "namelist")
    _, (script, namelist), data = steered(server, 60, "change", change, *kinds)
    note = "! only in the script: at t = 0.06 s: joint[1].friction_angle = 2"
    assert note in namelist.read_text()
    monkeypatch.chdir(server.folder)
    runpy.run_path(str(script))
    with sitedda.open_output("saved.nc") as repeated_run:
        assert same_bits(data, repeated_run)


def test_two_pages_show_the_same_run_and_a_later_one_shows_it_from_its_start(server):
    async def use():
        async with Client(server) as first, Client(server) as second:
            await first.open()
            await first.ask("run")
            await first.status("done")
            await second.status("done")
            async with Client(server) as later_page:
                await later_page.status("done")
                times = [[m["time"] for m in page.messages if m["kind"] == "frame"]
                         for page in (first, second, later_page)]  # fmt: skip
                assert times[0] == times[1] and times[2] and times[2][-1] == times[0][-1]

    talk(use())


def test_displacements_of_frames_are_relative_to_equilibrium_as_in_the_output(folder):
    soft_input = PILE.replace("normal_stiffness = 1000000000.0", "normal_stiffness = 1e7")
    soft_input = soft_input.replace("duration = 0.6", "duration = 0.1")
    soft_input = soft_input.replace("&fixed_point", "&fixed_point motion_x = 'm',")
    run = LiveRun(soft_input, folder / "soft.nml", folder / "soft.nc", *(Mock(),) * 3)
    run.run()
    wait_for(lambda: run.status in ("done", "failed"))
    message = list(run.frames)[-1]
    size = 4 + int.from_bytes(message[:4], "little")
    at, length = json.loads(message[4:size])["streams"]["blocks"]
    displacement = np.frombuffer(message[size + at :][:length], "<f4").reshape(10, -1)[:2].T
    scene = Scene(sitedda.open_output(run.result))
    expected = scene.displacement(scene.frames - 1) + scene.base[-1]
    assert abs(displacement - expected).max() < 1e-6 < 1e-3 < abs(displacement).max()
    assert run.words["summary"].count("at rest") == 1


def failing() -> str:
    """Return the pile, shaken so that steps do not converge."""
    text = PILE.replace("'adaptive'", "'fixed'").replace("1.0, -1.0", "30.0, -30.0")
    text = text.replace("&contact", "&contact max_iterations = 3,")
    return text.replace("&fixed_point", "&fixed_point motion_x = 'm',")


def test_a_step_that_fails_names_its_blocks(server):
    (server.folder / "fails.nml").write_text(failing())

    async def use():
        async with Client(server) as page:
            await page.open("fails.nml")
            await page.ask("run")
            return await page.status("failed", "done"), await page.saved("report", "why")

    end, report = talk(use())
    assert server.process.poll() is None
    assert end["status"] == "failed" and "does not converge" in end["verdict"]["failure"]
    assert end["verdict"]["blocks"] == [1, 0]
    report_text = unescape(report.read_text())
    assert "the run failed." in report_text
    assert f"failed: {end['verdict']['failure']}" in report_text


# --- the guard -------------------------------------------------------------------------------


def test_the_token_is_private_and_not_in_an_argument(server):
    assert stat.S_IMODE(server.redirect_page.stat().st_mode) == 0o600
    assert stat.S_IMODE(server.redirect_page.parent.stat().st_mode) == 0o700
    assert server.token not in server.printed
    assert server.token.encode() not in Path(f"/proc/{server.process.pid}/cmdline").read_bytes()
    assert server.host.startswith("127.0.0.1:")
    assert server.end() == 0
    assert not server.redirect_page.exists()


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
def test_a_server_for_other_machines_prints_a_warning(folder, tmp_path, host):
    with live(folder, tmp_path / "state", "--host", host) as server:
        assert server.end() == 0
        has_warning = "without encryption" in server.process.stderr.read()
        assert has_warning == (host != "127.0.0.1")


def test_wrong_tokens_origins_and_hosts_are_refused(server):
    async def use():
        for first_message in ("", "{}", "[]", '{"token": 3}', json.dumps({"token": "x" * 43}),
                              "{" * 9000, json.dumps({"token": server.token[:-1]}),
                              '{"do": "run"}'):  # fmt: skip
            socket = await connect(server)
            await socket.write_message(first_message)
            assert await asyncio.wait_for(socket.read_message(), DEADLINE) is None
            assert socket.close_code == 4401
        for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": None},
                        {"Host": "evil.example"}, {"Host": "localhost"},
                        {"Origin": server.address.replace("127.0.0.1", "127.0.0.2")}):  # fmt: skip
            with pytest.raises(HTTPClientError) as error_info:
                await connect(server, **headers)
            assert error_info.value.code == 403
        async with Client(server) as page:  # the server still responds
            assert page.messages[-1]["screen"] == "start"

    talk(use())


def test_answers_have_a_strict_policy_and_only_files_of_the_page(server):
    async def use():
        client = AsyncHTTPClient(force_instance=True)

        async def get(path, **headers):
            request = HTTPRequest(server.address + path, headers=headers)
            return await client.fetch(request, raise_error=False)

        page = await get("")
        policy = page.headers["Content-Security-Policy"]
        assert page.code == 200 and "default-src 'none'" in policy and "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert page.headers["X-Content-Type-Options"] == "nosniff"
        assert server.token.encode() not in page.body
        for path in ("pile.nml", "../pile.nml", "..%2f..%2fetc/passwd", "live/../../guard.py",
                     "%2e%2e/%2e%2e/etc/passwd", "live/main.js%00", "view/page.js"):  # fmt: skip
            assert (await get(path)).code == 404, path
        assert (await get("", Host="evil.example")).code == 403
        assert (await get("live/main.js")).headers["Content-Type"].startswith("text/javascript")

    talk(use())


def hostile_messages(seed: int, count: int) -> list:
    """Return messages with all kinds of errors."""
    draw = random.Random(seed)
    commands = ["open", "write", "set", "add", "save", "step", "stage", "change", "record", "x"]
    values = [None, -1, 1e300, "", "a\0b", "../../x", "/etc/passwd", [], {}, [[[]]], True, "é" * 50,
              "x" * 5000, {"a": {"b": 1}}, "&run /", "\ud800"]  # fmt: skip
    messages = []
    for _ in range(count):
        kind = draw.randrange(5)
        if kind == 0:
            letters = [chr(draw.randrange(1, 0xD000)) for _ in range(draw.randrange(80))]
            messages.append("".join(letters))
        elif kind == 1:
            messages.append(bytes(draw.randrange(256) for _ in range(draw.randrange(80))))
        elif kind == 2:
            messages.append(json.dumps(draw.choice(values)))
        else:
            names = ["source", "name", "text", "group", "number", "variable", "value", "what",
                     "steps", "values"]  # fmt: skip
            fields = {n: draw.choice(values) for n in draw.sample(names, draw.randrange(5))}
            messages.append(json.dumps({"do": draw.choice([*commands, 5, None])} | fields))
    return messages


def test_malformed_and_oversized_messages_change_and_write_nothing(server):
    before = {f: f.read_bytes() for f in server.folder.iterdir()}

    async def use():
        async with Client(server) as page:
            for message in hostile_messages(1, 200):
                await page.socket.write_message(message, binary=isinstance(message, bytes))
            await page.open("../../../etc/passwd")
            await page.ask("undo")
            count = 0
            while count < 202:
                count += (await page.hear())["kind"] in ("refused", "trouble")
        sender = await connect(server)
        await sender.write_message(json.dumps({"token": server.token}))
        with suppress(WebSocketClosedError):
            await sender.write_message("x" * 10_000_000)
        while await asyncio.wait_for(sender.read_message(), DEADLINE) is not None:
            pass
        async with Client(server) as page:
            assert page.messages[-1]["screen"] == "start"

    talk(use())
    assert server.process.poll() is None
    assert {f: f.read_bytes() for f in server.folder.iterdir()} == before


def test_files_are_saved_only_in_the_folder_and_never_replace_others(server, folder, tmp_path):
    (folder / "out").symlink_to(tmp_path)
    (folder / "mine.py").write_text("print('mine')\n")
    names = ["../x", "/tmp/x", "out/x", "", " ", "a\nb", "x/../../y", "no_folder/x", "mine"]

    async def use():
        async with Client(server) as page:
            await page.open()
            for kind, name in [*(("script", name) for name in names), ("namelist", "pile")]:
                await page.ask("save", what=kind, name=name)
                while (await page.hear())["kind"] != "refused":
                    pass

    talk(use())
    assert (folder / "mine.py").read_text() == "print('mine')\n"
    assert (folder / "pile.nml").read_text() == PILE
    assert not list(tmp_path.glob("*.py"))


# --- stored state ----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_a_killed_server_loses_neither_model_nor_run(folder, tmp_path, seed):
    draw = random.Random(seed)
    state = tmp_path / "state"

    async def begin(server):
        async with Client(server) as page:
            await page.open()
            await page.ask("set", group="joint", number=1, variable="friction_angle", value="20")
            await page.until(lambda m: m["kind"] == "model" and "friction_angle = 20" in m["text"])
            await page.ask("step", steps=draw.randrange(10, 60))
            await page.status("paused")
            await page.ask("stage", values={"name": "digging", "remove": "low"})
            await page.until(lambda m: m["kind"] == "run" and m["actions"])
            await page.ask("run")
            await asyncio.sleep(draw.random() * 0.4)

    async def resume(server):
        async with Client(server) as page:
            page_model = await page.until(lambda m: m["kind"] == "model")
            assert "friction_angle = 20" in page_model["text"] and page_model["running"]
            if not page.messages or page.messages[-1].get("status") != "done":
                await page.ask("run")
            await page.status("done")
            return [await page.saved(kind, "end") for kind in ("output", "namelist")]

    server = LiveProcess(folder, state)
    try:
        talk(begin(server))
    finally:
        server.kill()
    with live(folder, state) as server:
        output, namelist = talk(resume(server))
    with sitedda.open_output(output) as data:
        assert same_bits(data, sitedda.run(namelist).history)


def test_servers_of_one_folder_are_separate_and_restart_at_their_port(server, folder, tmp_path):
    state = tmp_path / "state"
    with live(folder, state) as second:
        assert second.address != server.address
        assert second.redirect_page.parent != server.redirect_page.parent
        wait_for(second.redirect_page.exists)
    assert server.end() == 0
    with live(folder, state) as restarted:
        assert restarted.address == server.address
        (restarted.redirect_page.parent / "port.json").write_text('{"port": 700000}')
    with live(folder, state) as restarted:
        assert restarted.process.poll() is None


def test_a_damaged_journal_leads_to_the_start_page(server, folder, tmp_path):
    server.kill()
    private = server.redirect_page.parent
    (private / "model.json").write_text('{"text": 3')
    (private / "run.json").write_text("[]")

    async def use(restarted):
        async with Client(restarted) as page:
            assert page.messages[-1]["screen"] == "start"

    with live(folder, tmp_path / "state") as restarted:
        talk(use(restarted))


def test_any_failure_to_save_is_reported_to_the_page(tmp_path):
    """The page waits for a response, whichever exception a library raises."""
    events: list[dict] = []
    session = SimpleNamespace(_saver=threading.Lock(), publish=events.append, folder=tmp_path)
    for error in (TypeError("can only repeat by an integer"), ZeroDivisionError()):
        session._write_files = Mock(side_effect=error)
        Session._save_and_report(session, "report", tmp_path / "r.html")
    assert [event["message"] for event in events] == ["can only repeat by an integer",
                                                "ZeroDivisionError"]  # fmt: skip
    assert all(event["kind"] == "refused" and event["what"] == "report" for event in events)
