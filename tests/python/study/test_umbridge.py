# SPDX-License-Identifier: GPL-3.0-or-later
"""A model served by UM-Bridge, called by the client of that package."""

import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from environment import DEADLINE
from model_text import tower

import sitedda

PARAMETERS = ["material.rock.density", "motion.scale"]
RESULTS = ["displacement[surface].x.largest", "energy_balance.last"]
PROGRAM = "from sitedda.study import serve_umbridge as s; s({!r}, {}, {}, port={}, workers=2)"


@pytest.fixture
def forward(write_input):
    umbridge = pytest.importorskip("umbridge")
    with socket.socket() as free:
        free.bind(("", 0))
        port = free.getsockname()[1]
    program = PROGRAM.format(str(write_input(tower())), PARAMETERS, RESULTS, port)
    server = subprocess.Popen([sys.executable, "-c", program])
    deadline, model = time.monotonic() + DEADLINE, None
    while model is None:
        try:
            model = umbridge.HTTPModel(f"http://localhost:{port}", "forward")
        except OSError:  # the server does not listen yet
            assert server.poll() is None and time.monotonic() < deadline
            time.sleep(0.1)
    yield model
    server.terminate()
    assert server.wait(DEADLINE) == 0


def test_clients_receive_the_results_of_studies_or_messages(forward):
    assert forward.get_input_sizes() == forward.get_output_sizes() == [2]
    inputs = [[2500.0, 1.0], [2700.0, 2.0]]
    with ThreadPoolExecutor() as pool:
        responses = list(pool.map(lambda values: forward([values]), inputs))
    for (density, scale), (numbers,) in zip(inputs, responses, strict=True):
        changes = {PARAMETERS[0]: [density], PARAMETERS[1]: [scale]}
        table = sitedda.study("model.nml", changes, RESULTS)
        assert numbers == [table[name].item() for name in RESULTS]
    assert responses[0] != responses[1]
    with pytest.raises(Exception, match="density = -1 must be"):
        forward([[-1.0, 1.0]])
