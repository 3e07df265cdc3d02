# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda live` as a process, and a client that communicates like its page."""

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from environment import DEADLINE
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

PROGRAM = "import sys; from sitedda.program import main; sys.exit(main())"


class LiveProcess:
    """A server in a folder.

    Parameters
    ----------
    folder : path
        The working folder.
    state : path
        Folder of its private files.
    *arguments
        Arguments of the command.
    """

    def __init__(self, folder: Path, state: Path, *arguments):
        self.folder = folder
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, "live", "--no-open", *map(str, arguments)],
            cwd=folder,
            env=dict(os.environ, XDG_STATE_HOME=str(state), SSH_CONNECTION=""),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.printed = ""
        while "Ctrl-C" not in self.printed:
            line = self.process.stdout.readline()
            assert line, self.process.stderr.read()
            self.printed += line
        self.redirect_page = Path(re.search(r"to enter, open (\S+)", self.printed)[1])
        target = re.search(r"url=(\S+?)'", self.redirect_page.read_text())[1]
        self.address, _, self.token = target.partition("#")

    @property
    def host(self) -> str:
        """Return host name and port."""
        return self.address.removeprefix("http://").rstrip("/")

    def end(self) -> int:
        """Send Ctrl-C and return the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(DEADLINE)

    def kill(self) -> None:
        """Kill the server."""
        self.process.kill()
        self.process.wait()


@contextmanager
def live(folder: Path, state: Path, *arguments):
    """Yield a server that ends with the context."""
    server = LiveProcess(folder, state, *arguments)
    try:
        yield server
    finally:
        server.kill()


class Client:
    """A page without a browser.

    Attributes
    ----------
    messages : list
        Heads of all received messages.
    """

    def __init__(self, server: LiveProcess):
        self.server = server
        self.messages: list[dict] = []
        self.socket = None

    async def __aenter__(self) -> "Client":
        """Connect to the server and send the token."""
        self.socket = await connect(self.server)
        await self.socket.write_message(json.dumps({"token": self.server.token}))
        await self.until(lambda m: m["kind"] == "start")
        return self

    async def __aexit__(self, *_) -> None:
        """Close the connection."""
        self.socket.close()

    async def ask(self, command: str, **fields) -> None:
        """Send a command."""
        await self.socket.write_message(json.dumps({"do": command, **fields}))

    async def hear(self) -> dict:
        """Return the head of the next message."""
        data = await asyncio.wait_for(self.socket.read_message(), DEADLINE)
        assert data is not None, f"the connection has ended: {self.socket.close_code}"
        if isinstance(data, bytes):
            data = data[4 : 4 + int.from_bytes(data[:4], "little")]
        self.messages.append(json.loads(data))
        return self.messages[-1]

    async def open(self, name: str = "pile.nml") -> None:
        """Open a file of the folder."""
        await self.ask("open", source="file", name=name)

    async def until(self, condition) -> dict:
        """Return the first message from now on that meets a condition."""
        while not condition(message := await self.hear()):
            assert message["kind"] != "refused", message
        return message

    async def status(self, *names: str) -> dict:
        """Wait until the run has one of these states."""
        return await self.until(lambda m: m["kind"] == "run" and m["status"] in names)

    async def saved(self, what: str, name: str) -> Path:
        """Save a file and return its path."""
        await self.ask("save", what=what, name=name)
        message = await self.until(lambda m: m["kind"] == "saved")
        return self.server.folder / message["files"][0]


def talk(conversation: Coroutine):
    """Return the result of a conversation with a server.

    It runs in a separate thread, because Playwright occupies the event loop of the tests.
    """
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, conversation).result()


async def connect(server: LiveProcess, **headers):
    """Return a connection without a token; `headers` replace those of the page."""
    headers = {"Host": server.host, "Origin": server.address.rstrip("/")} | headers
    headers = {name: value for name, value in headers.items() if value is not None}
    request = HTTPRequest(f"ws://{server.host}/socket", headers=headers)
    return await websocket_connect(request, max_message_size=2**30)
