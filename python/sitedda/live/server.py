# SPDX-License-Identifier: GPL-3.0-or-later
"""The server of pages and a web socket, by default on the loopback address."""

from __future__ import annotations

import asyncio
import gc
import json
import logging
import os
import signal
import socket
import sys
import webbrowser
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.resources import files
from pathlib import Path
from typing import Any

try:
    from tornado.httpserver import HTTPServer
    from tornado.netutil import bind_sockets
    from tornado.web import Application, RequestHandler
    from tornado.websocket import WebSocketClosedError, WebSocketHandler
except ImportError as trouble:
    from ..base.errors import MissingLibrary

    raise MissingLibrary(
        "sitedda live needs the library tornado: pip install 'sitedda[live]'"
    ) from trouble

from ..base.errors import InputError, OutputError, SiteddaError
from ..input.changes import BETWEEN_STEPS
from ..input.schema import GROUPS
from ..report.html import VIEW_MODULES, page_style
from .guard import LOOPBACK, SECONDS_TO_ENTER, Guard
from .journal import Journal
from .protocol import MOST, read_message
from .session import Session
from .starts import Shipped

_WAITING = 40_000_000  # unsent bytes of a page above which it receives no frames
_PAGES = 16  # largest number of open pages
_COLLECT = (50_000, 20, 100)  # thresholds of the garbage collector
_PAGE_FILES = ("main", "socket", "start", "forms", "text", "live_view", "run", "save", "parts")
_SOURCES = {
    "/": (("live", "page", "index.html"), "text/html"),
    "/live.css": (("live", "page", "live.css"), "text/css"),
    "/view.css": (("drawing", "view", "view.css"), "text/css"),
} | {
    f"/live/{name}.js": (("live", "page", f"{name}.js"), "text/javascript") for name in _PAGE_FILES
} | {
    f"/view/{name}.js": (("drawing", "view", f"{name}.js"), "text/javascript")
    for name in VIEW_MODULES if name != "page"
}  # fmt: skip


class _GuardedHandler:
    """Base of all handlers: check of the host, headers, short errors."""

    application: Any  # these attributes belong to tornado's handler
    request: Any
    set_header: Callable
    clear_header: Callable
    set_status: Callable
    finish: Callable

    def initialize(self, server: LiveServer) -> None:
        self.server = server

    def set_default_headers(self) -> None:
        for name, value in self.application.settings["guard"].headers().items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        if self.request.headers.get("Host") not in self.server.guard.hosts:
            self.set_status(403)
            self.finish("This server accepts requests only under its own name.")

    def write_error(self, status_code: int, **_) -> None:
        self.finish(f"{status_code}")


class _FileHandler(_GuardedHandler, RequestHandler):
    """Handler of the files of the page: public code without data of a model."""

    def get(self) -> None:
        path, kind = _SOURCES.get(self.request.path, ((), "text/css"))
        if self.request.path == "/page.css":
            data = page_style().encode()
        elif path:
            data = files("sitedda").joinpath(*path).read_bytes()
        else:
            self.set_status(404)
            self.finish("There is no such page.")
            return
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish(data)


class _PageSocket(_GuardedHandler, WebSocketHandler):
    """Web socket of an open page; nothing is sent before the page has sent the token."""

    def check_origin(self, origin: str) -> bool:
        return self.server.guard.knows_origin(origin)

    def prepare(self) -> None:
        super().prepare()
        known = self.server.guard.knows_origin(self.request.headers.get("Origin"))
        if not self._finished and not known:
            self.set_status(403)
            self.finish("Only pages of this server may connect.")

    def open(self, *_, **__) -> None:
        self.entered = False
        self.waiting = 0  # unsent bytes of the page
        self.set_nodelay(True)
        loop = asyncio.get_running_loop()
        self.limit = loop.call_later(SECONDS_TO_ENTER, self._close_without_token)

    def _close_without_token(self) -> None:
        if not self.entered:
            self.close(4401, "no token")

    def on_message(self, message) -> None:
        if not self.entered:
            self._check_token(message)
            return
        try:
            command, fields = read_message(message)
        except InputError as error:
            self.send({"kind": "refused", "message": str(error)})
            return
        self.server.carry_out(command, fields, self.send)

    def _check_token(self, message) -> None:
        try:
            found = json.loads(message) if isinstance(message, str) and len(message) < 400 else None
        except (ValueError, RecursionError):
            found = None
        token = found.get("token") if isinstance(found, dict) else None
        if not self.server.guard.admits(token):
            self.close(4401, "wrong token")
            return
        if len(self.server.sockets) >= _PAGES:
            self.close(4429, "too many pages")
            return
        self.entered = True
        self.server.welcome(self)

    def on_close(self) -> None:
        self.server.sockets.discard(self)

    def send(self, message: dict | bytes) -> None:
        """Send a message to the page, from the thread of the loop."""
        if self.ws_connection is None:
            return
        binary = isinstance(message, bytes)
        if binary and self.waiting > _WAITING and b'"kind": "frame"' in message[:40]:
            return
        data = message if binary else json.dumps(message)
        try:
            written = self.write_message(data, binary=binary)
        except WebSocketClosedError:
            return
        self.waiting += len(data)
        written.add_done_callback(lambda done: self._subtract_sent(len(data), done))

    def _subtract_sent(self, size: int, done: asyncio.Future) -> None:
        self.waiting -= size
        done.exception()  # the page has been closed


class LiveServer:
    """A server of a single session.

    Parameters
    ----------
    folder : path
        The working folder.
    shipped : Shipped
    host : str
        Address to listen at.
    port : int
        0: the port of the last server of the folder, so that its pages reconnect, or a free port.
    notebook : bool
        Whether notebooks on this machine may show the page.
    """

    def __init__(self, folder: Path, shipped: Shipped, host: str = LOOPBACK, port: int = 0,
                 notebook: bool = False):  # fmt: skip
        self.sockets: set[_PageSocket] = set()
        self.journal = Journal(folder)
        try:
            self._listening = _open_sockets(host, port) if port else self._listen_as_before(host)
        except OutputError:
            self.journal.close()
            raise
        self.port = self._listening[0].getsockname()[1]
        self.journal.keep("port", {"port": self.port})
        self.guard = Guard(host, self.port, notebook)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._worker = ThreadPoolExecutor(1, "commands")
        self.session = Session(folder, self.journal, shipped, self.tell, lambda: bool(self.sockets))

    def _listen_as_before(self, host: str) -> list[socket.socket]:
        """Listen at the port of the last server of the folder, or at a free port."""
        last = (self.journal.kept("port") or {}).get("port")
        if isinstance(last, int) and 0 < last < 65536:
            with suppress(OutputError):
                return _open_sockets(host, last)
        return _open_sockets(host, 0)

    def tell(self, message: dict | bytes) -> None:
        """Send a message to all pages, from any thread."""
        if self._loop is not None and not self._loop.is_closed():
            try:
                self._loop.call_soon_threadsafe(self._send, message)
            except RuntimeError:  # the event loop has just ended
                pass

    def _send(self, message: dict | bytes) -> None:
        for one in list(self.sockets):
            one.send(message)

    def welcome(self, page: _PageSocket) -> None:
        """Send the session to a new page, and all later events."""

        def greet() -> None:
            known = {"kind": "schema", "groups": schema(), "changeable": BETWEEN_STEPS}
            messages = [known, *self.session.welcome()]
            self._loop.call_soon_threadsafe(enter, messages)

        def enter(messages: list) -> None:
            for message in messages:
                page.send(message)
            self.sockets.add(page)

        self._worker.submit(greet)

    def carry_out(self, command: str, fields: dict, answer: Callable) -> None:
        """Execute the commands of a page in their order."""

        def work() -> None:
            try:
                self.session.carry_out(command, fields)
            except (SiteddaError, OSError) as error:
                refused = {"kind": "refused", "message": str(error), "command": command}
                self._loop.call_soon_threadsafe(answer, refused)
            except Exception as error:  # the page receives the error, and the server continues
                logging.getLogger("sitedda").exception("the command %s fails", command)
                refused = {"kind": "refused", "message": f"the program fails: {error}"}
                self._loop.call_soon_threadsafe(answer, refused)

        self._worker.submit(work)

    async def serve(self, ready: Callable[[LiveServer], None] = lambda _: None) -> None:
        """Serve until a signal arrives."""
        self._loop = asyncio.get_running_loop()
        application = Application(
            [("/socket", _PageSocket, {"server": self}), (".*", _FileHandler, {"server": self})],
            guard=self.guard,
            websocket_max_message_size=MOST,
            log_function=lambda _: None,  # addresses are private
        )
        server = HTTPServer(application, max_body_size=1000, max_header_size=16_384)
        server.add_sockets(self._listening)
        over = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            self._loop.add_signal_handler(number, over.set)
        try:
            ready(self)
            await over.wait()
        finally:
            server.stop()
            for page in list(self.sockets):
                page.close(1001, "the server ends")
            await self._loop.run_in_executor(None, self.close)

    def close(self) -> None:
        """End the session; model and run remain in the journal."""
        self.session.close()
        self._worker.shutdown(wait=False, cancel_futures=True)
        self.journal.close()


def schema() -> list[dict]:
    """Return the groups of the input and their variables, for the forms."""
    return [
        {
            "name": group.name,
            "meaning": group.meaning,
            "repeats": group.repeats,
            "variables": [
                {"name": v.name, "kind": v.kind, "size": v.size, "unit": v.unit, "when": v.when,
                 "default": v.default, "values": v.values, "meaning": v.meaning}
                for v in group.variables
            ],
        }
        for group in GROUPS.values()
    ]  # fmt: skip


def _open_sockets(host: str, port: int) -> list[socket.socket]:
    try:
        return bind_sockets(port, host)
    except (OSError, OverflowError, UnicodeError) as trouble:
        words = getattr(trouble, "strerror", None) or trouble
        if isinstance(trouble, UnicodeError):
            words = "this is not the name of a host"
        raise OutputError(f"no server can listen at {host!r}, port {port}: {words}") from trouble


def run_server(
    folder: Path,
    file: Path | None,
    shipped: Shipped,
    host: str = LOOPBACK,
    port: int = 0,
    show: bool = True,
    notebook: bool = False,
) -> None:
    """Serve a session until Ctrl-C.

    Parameters
    ----------
    folder : path
        The working folder.
    file : path or None
        Input to open; None: the session of the last server of the folder, if any.
    shipped : Shipped
    host, port : str, int
        Port; 0: the last one of the folder, or a free one.
    show : bool
        Open a browser.
    notebook : bool
        Whether notebooks on this machine may show the page.
    """
    gc.set_threshold(*_COLLECT)
    server = LiveServer(folder, shipped, host, port, notebook)
    try:
        if file is not None:
            server.session.open_file(file)
        else:
            server.session.recover()
        entrance = server.guard.write_entrance(server.journal.folder)
    except BaseException:
        server.close()
        raise

    def ready(_) -> None:
        _print_address(server, entrance)
        if show:
            webbrowser.open(entrance.as_uri())

    try:
        asyncio.run(server.serve(ready))
    finally:
        entrance.unlink(missing_ok=True)


def _print_address(server: LiveServer, entrance: Path) -> None:
    """Print the address and how to open it from this and other machines."""
    print(f"sitedda live: {server.guard.address} for the working folder {server.session.folder}")
    print(f"to enter, open {entrance}", flush=True)
    if os.environ.get("SSH_CONNECTION"):
        here = os.environ["SSH_CONNECTION"].split()[2]
        print(
            f"from your own machine: ssh -N -L {server.port}:127.0.0.1:{server.port} "
            f"{os.environ.get('USER', 'USER')}@{here}\nthen {server.guard.address}, "
            f"and the token, which ends the address in that file"
        )
    if not server.guard.address.startswith(f"http://{LOOPBACK}"):
        print(
            "warning: it listens beyond this machine, without encryption: anyone who reads the "
            "traffic can run models and write files in the working folder as you",
            file=sys.stderr,
        )
    print("Ctrl-C ends the server; the model and its run are kept", flush=True)
