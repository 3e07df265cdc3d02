# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets of `sitedda live`: cutting and drawing in Chromium, frame rate, and loss of speed.

python tests/benchmarks/live.py [--quick] [--loss]

--loss measures only the loss: processor time of the server per step, alternately without clients
and with a client that receives all frames without drawing them.
"""

import asyncio
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python"))

from environment import ARGUMENTS, BROWSER  # noqa: E402
from live_server import Client, live, talk  # noqa: E402
from playwright.sync_api import sync_playwright  # noqa: E402
from test_live_page import drawn, until  # noqa: E402

from sitedda.simulation import Simulation  # noqa: E402

SLOPE = """&control time_step = 2e-4, duration = 1000, gravity = 0, -9.81 /
&material name = 'rock', density = 2600, young_modulus = 5e9, poisson_ratio = 0.25 /
&joint name = 'joint', friction_angle = 35 /
&region name = 'rock', outline = 0, 0, 70, 0, 70, 40, 30, 40, 10, 8, 0, 8 /
&joint_set joint = 'joint', angle = 33, spacing = {spacing} /
&joint_set joint = 'joint', angle = 102, spacing = {spacing} /
&boundary kind = 'fixed', side = 'bottom' /
&measured_point name = 'crest', x = 30, y = 40 /
&output history_interval = 1000 /
"""
# At rest, so that the engine computes more steps per second than frames are sent.
WALL = """&control time_step = 1e-3, duration = 1000, gravity = 0, -9.81, settle = .true. /
&contact normal_stiffness = 2e10 /
&material name = 'stone', density = 2500, young_modulus = 1e10, poisson_ratio = 0.25 /
&joint name = 'dry', friction_angle = 35 /
&layers name = 'base', left = -1, bottom = -0.5, width = 102, thickness = 0.5 /
&wall left = 0, bottom = 0, brick_length = 1, brick_height = 0.5, bricks = 100, courses = 50 /
&fixed_point x = 0, y = -0.3 /
&fixed_point x = 100, y = -0.3 /
&measured_point name = 'top', x = 50, y = 25 /
&output history_interval = 1000 /
"""
EDITS = 7
WATCHED = 20.0  # s
PAIRS = 5


def blocks_of(spacing: float, folder: Path) -> tuple[Path, int]:
    """Return an input of the slope, and its number of blocks."""
    file = folder / f"slope_{spacing:g}.nml"
    file.write_text(SLOPE.format(spacing=spacing))
    with Simulation(file, drawn=True) as simulation:
        return file, len(simulation.polygons)


def enter(browser, server):
    """Open a page of a server, and wait for its drawn model."""
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.goto(server.redirect_page.as_uri())
    until(page, "window.page && page.model && page.view.state.decoded")
    drawn(page)
    return page


def renderer(page) -> str:
    """Return the name of the WebGL renderer."""
    return page.evaluate(
        "(() => { const gl = page.view.painter.gl;"
        " const e = gl.getExtension('WEBGL_debug_renderer_info');"
        " return gl.getParameter(e ? e.UNMASKED_RENDERER_WEBGL : gl.RENDERER); })()"
    )


def edits(page, spacing: float) -> list[float]:
    """Return the times from an edit to the drawn picture in the page, s."""
    times = []
    for i in range(EDITS):
        begun = time.perf_counter()
        value = f"{spacing * (1 + 0.002 * (i + 1)):.6g}"
        fields = {"group": "joint_set", "number": 1, "variable": "spacing", "value": value}
        page.evaluate("fields => page.ask('set', fields)", fields)
        until(page, f"page.model.text.includes('spacing = {value}')")
        drawn(page)
        times.append(time.perf_counter() - begun)
        page.evaluate("page.ask('settle')")
    return times


def watch(page) -> tuple[float, float, float]:
    """Return received frames, drawn frames and engine steps, per second."""
    page.locator("#run button", has_text="Run").click()
    until(page, "page.view.model.frames > 3 && page.run.status === 'running'")
    ask = "[page.view.state.frames, page.view.state.draws, page.run.step, performance.now()]"
    first = page.evaluate(ask)
    time.sleep(WATCHED)
    last = page.evaluate(ask)
    seconds = (last[3] - first[3]) / 1000
    page.locator("#run button", has_text="Stop").click()
    until(page, "page.run.status === 'stopped'")
    return tuple((b - a) / seconds for a, b in zip(first[:3], last[:3], strict=True))


def spent(process: int) -> float:
    """Return the processor time of a process, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def losses(server, repetitions: int) -> list[tuple[float, float, float]]:
    """Return processor times per step without and with a client, s, and its frames per second."""
    steps = []

    async def now() -> tuple[float, int]:
        async with Client(server) as page:
            message = await page.status("running")
            return spent(server.process.pid), message["step"]

    async with Client(server) as page:
        await page.ask("run")
        await page.status("running")
    for _ in range(repetitions):
        before = await now()
        await asyncio.sleep(WATCHED)
        after = await now()
        idle_time = (after[0] - before[0]) / (after[1] - before[1])
        async with Client(server) as page:
            first = await page.status("running")
            before, begun, frames = spent(server.process.pid), time.perf_counter(), 0
            while time.perf_counter() - begun < WATCHED:
                frames += (await page.hear())["kind"] == "frame"
            seconds = time.perf_counter() - begun
            last = await page.status("running")
            drawing_time = (spent(server.process.pid) - before) / (last["step"] - first["step"])
        steps.append((idle_time, drawing_time, frames / seconds))
    return steps


def loss(folder: Path, repetitions: int) -> None:
    """Print the loss of engine speed by a client."""
    file = folder / "wall.nml"
    file.write_text(WALL)
    with live(folder, folder / "state", file.name) as server:
        pairs = talk(losses(server, repetitions))
    for idle, drawing, frames in pairs:
        print(f"  {idle * 1e3:.2f} and {drawing * 1e3:.2f} ms of processor time per step, "
              f"{frames:.1f} frames per second")  # fmt: skip
    percentage = 100 * (1 - statistics.median(idle / drawing for idle, drawing, _ in pairs))
    print(f"5000 bricks: a client slows down the engine by {percentage:.1f} % (target 5 %), "
          f"{repetitions} turns of {WATCHED:g} s")  # fmt: skip


def main() -> None:
    """Measure and print."""
    quick = "--quick" in sys.argv
    if "--loss" in sys.argv:
        with tempfile.TemporaryDirectory() as scratch:
            loss(Path(scratch), 2 if quick else PAIRS)
        return
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as playwright:
        folder = Path(scratch)
        browser = playwright.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        for spacing, target in ((0.99, 0.3), (0.308, 1.5)):
            file, count = blocks_of(spacing, folder)
            with live(folder, folder / "state", file.name) as server:
                page = enter(browser, server)
                times = edits(page, spacing)
                server_share = page.evaluate("page.view.state.seconds")
                print(
                    f"{count} blocks cut and drawn: median {statistics.median(times):.2f} s, least "
                    f"{min(times):.2f} s (target {target} s); of the last time, "
                    f"{server_share:.2f} s in the server; {renderer(page)}",
                    flush=True,
                )
                page.context.close()
        file, count = folder / "wall.nml", 5000
        file.write_text(WALL)
        with live(folder, folder / "state", file.name) as server:
            page = enter(browser, server)
            frames, draws, steps = watch(page)
            page.context.close()
        print(
            f"{count} bricks watched: {frames:.1f} frames per second received, {draws:.1f} drawn "
            f"(target 15); {steps:.1f} steps per second",
            flush=True,
        )
        browser.close()
    with tempfile.TemporaryDirectory() as scratch:
        loss(Path(scratch), 2 if quick else PAIRS)


if __name__ == "__main__":
    main()
