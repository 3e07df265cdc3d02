#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Close or reload the page of `sitedda live`, or kill its server, at random moments.

usage: python tests/robustness/live_kills.py [--kills N] [--seed S]

Each case edits a model in the system's Chromium, runs it, begins a stage, and is cut off at a
random moment; what comes back must be the edited model and its run, and the run's output must have
the bits of the saved namelist by `sitedda run`.  Ends with status 1 if one differs.
"""

import random
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))

from environment import ARGUMENTS, BROWSER  # noqa: E402
from live_server import LiveProcess  # noqa: E402
from options import asked  # noqa: E402
from playwright.sync_api import sync_playwright  # noqa: E402
from test_live import COMPARED, PILE  # noqa: E402
from test_live_page import OVER, begun, press, until  # noqa: E402

import sitedda  # noqa: E402

WAYS = ("the page is closed", "the page is reloaded", "the server is killed")
LATEST = 2.0  # s after the stage has begun
ENTERED = "window.page?.model && page.view.state.decoded"


def enter(browser, server):
    """A page of the server."""
    page = browser.new_context().new_page()
    page.goto(server.entrance.as_uri())
    return page


def prepare(page, chance: random.Random) -> None:
    """Edit, run, dig, and go on for a random time."""
    until(page, "window.page && page.start.cards.size > 0")
    begun(page, "pile.nml")
    edit = {"group": "joint", "number": 1, "variable": "friction_angle", "value": "20"}
    page.evaluate("edit => page.ask('set', edit)", edit)
    until(page, "page.model.text.includes('friction_angle = 20')")
    page.evaluate("steps => page.ask('step', {steps})", chance.randrange(10, 60))
    until(page, "page.run?.status === 'paused'")
    page.evaluate("page.ask('stage', {values: {name: 'digging', remove: 'low'}})")
    until(page, "page.run.actions.length === 1")
    press(page, "Run")
    time.sleep(chance.random() * LATEST)


def finish(page, folder: Path) -> str:
    """Let the run end, save it, and say what is wrong with it."""
    until(page, f"{ENTERED} && page.run && !['opening', 'ready'].includes(page.run.status)")
    if not page.evaluate("page.model.text.includes('friction_angle = 20')"):
        return "the edit is lost"
    if page.evaluate("page.run.actions.length") != 1:
        return "the stage is lost"
    if page.evaluate("page.run.status === 'paused'"):
        press(page, "Run")
    until(page, OVER)
    page.evaluate("page.drawing.then(() => true)")
    page.get_by_role("tab", name="Save").click()
    for what in ("output", "namelist"):
        press(page, f"save the {what}")
        until(page, f"page.saves.fields.{what}.words.textContent.startsWith('saved')")
    again = sitedda.run(folder / "pile_live.nml").history
    with sitedda.open_output(folder / "pile_live.nc") as found:
        for name in COMPARED:
            if not np.array_equal(found[name].values, again[name].values):
                return f"{name} has other bits"
    return ""


def case(browser, way: str, chance: random.Random) -> str:
    """One cut-off; what is wrong after it."""
    with tempfile.TemporaryDirectory() as place:
        folder, state = Path(place) / "work", Path(place) / "state"
        folder.mkdir()
        (folder / "pile.nml").write_text(PILE)
        server = LiveProcess(folder, state)
        try:
            page = enter(browser, server)
            prepare(page, chance)
            if way == WAYS[1]:
                page.reload()
            else:
                page.context.close()
            if way == WAYS[2]:
                server.kill()
                server = LiveProcess(folder, state)
            if way != WAYS[1]:
                page = enter(browser, server)
            wrong = finish(page, folder)
            page.context.close()
        finally:
            server.kill()
    return wrong


def main() -> None:
    """Print a line for each case."""
    options = asked(__doc__, kills=21, seed=1)
    chance, wrong = random.Random(options.seed), 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        for number in range(options.kills):
            way = WAYS[number % len(WAYS)]
            found = case(browser, way, chance)
            wrong += bool(found)
            print(
                f"{number + 1}: {way}: {found or 'model and run are there, same bits'}", flush=True
            )
        browser.close()
    print(f"{options.kills} cut-offs, {wrong} wrong")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
