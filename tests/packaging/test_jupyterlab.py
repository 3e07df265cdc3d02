# SPDX-License-Identifier: GPL-3.0-or-later
"""The widgets in a real JupyterLab: a command of its own, after `pip install jupyterlab`."""

import json
import os
import socket
import subprocess
import time

import pytest
from environment import DEADLINE, executable
from model_text import namelist
from test_view import place_in_view, sliding_blocks, wait_until_decoded

VIEW = (
    "import sitedda\nwidget = sitedda.run('model.nml').widget(color='material')\nwidget",
    "print('picked', widget.picked)\nwidget.picked = 'table'",
)
LIVE = (
    "from sitedda.live.widget import LiveWidget\nwidget = LiveWidget('model.nml')\nwidget",
    "widget.close()\nLiveWidget('none.nml')",
)


@pytest.fixture
def lab(tmp_path, request):
    """Address of a notebook with the cells of a test, in a JupyterLab with its Python."""
    (tmp_path / "model.nml").write_text(namelist(sliding_blocks()), encoding="utf-8")
    cells = [{"cell_type": "code", "metadata": {}, "execution_count": None, "outputs": [],
              "source": text} for text in request.param]  # fmt: skip
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python"}}
    book = {"nbformat": 4, "nbformat_minor": 4, "metadata": kernel, "cells": cells}
    (tmp_path / "book.ipynb").write_text(json.dumps(book))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    options = ("--no-browser", "--allow-root", f"--port={port}", "--IdentityProvider.token=key")
    server = subprocess.Popen([executable("jupyter-lab"), *options], cwd=tmp_path,
                              env=os.environ | {"HOME": str(tmp_path)})  # fmt: skip
    with socket.socket() as client:
        while client.connect_ex(("127.0.0.1", port)) and server.poll() is None:
            time.sleep(0.1)
    yield f"http://127.0.0.1:{port}/lab/tree/book.ipynb?token=key"
    server.terminate()
    server.wait()


@pytest.fixture
def frame(lab, new_page):
    """The frame below the first cell, which is executed."""
    page = new_page(("http:", "ws:", "data:", "blob:"), viewport={"width": 1300, "height": 1400})
    page.set_default_timeout(DEADLINE * 1000)
    page.goto(lab)
    page.wait_for_selector("text=| Idle")  # the kernel, in the line at the bottom
    execute(page, 0)
    return page.wait_for_selector(".jp-OutputArea iframe").content_frame()


def execute(page, cell: int) -> None:
    """Execute a cell as a person does."""
    page.locator(".jp-Notebook .cm-content").nth(cell).click()
    page.keyboard.press("Shift+Enter")


@pytest.mark.parametrize("lab", [VIEW], indirect=True)
def test_a_block_picked_in_jupyterlab_is_a_value_in_python(frame):
    page = frame.page
    wait_until_decoded(frame)
    frame.evaluate("blockViews[0].showTime(0)")
    x, y = place_in_view(frame, 5.5, 1.5)
    box = page.locator(".jp-OutputArea iframe").bounding_box()
    page.mouse.click(box["x"] + x, box["y"] + y)
    frame.wait_for_selector(".info h3:text('right')")
    execute(page, 1)
    page.wait_for_selector("text='picked right'")
    frame.wait_for_selector(".info h3:text('table')")


@pytest.mark.parametrize("lab", [LIVE], indirect=True)
def test_a_model_runs_in_the_live_page_of_a_notebook(frame):
    frame.click("#run button:text-is('Run')")
    frame.wait_for_selector("#verdict table")
    execute(frame.page, 1)
    frame.page.wait_for_selector("text=none.nml: there is no such file")
