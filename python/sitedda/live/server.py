# SPDX-License-Identifier: GPL-3.0-or-later
"""The web server of `sitedda live`: files of the page, and a web socket for its messages."""

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

from ..base.errors import InputError, OutputError, SiteddaError, library_required

with library_required("sitedda live needs the library tornado: pip install 'sitedda[live]'"):
    from tornado.httpserver import HTTPServer
    from tornado.netutil import bind_sockets
    from tornado.web import Application, RequestHandler
    from tornado.websocket import WebSocketClosedError, WebSocketHandler

from ..input.changes import BETWEEN_STEPS
from ..input.schema import GROUPS
from ..report.html import VIEW_MODULES, page_style
from .guard import LOOPBACK, SECONDS_TO_ENTER, Guard
from .journal import Journal
from .protocol import LONGEST_MESSAGE, read_message
from .session import Session
from .starts import BundledFiles

_LARGEST_BACKLOG = 40_000_000  # bytes not yet sent to a page above which it receives no frames
_PAGES = 16  # largest number of open pages
_COLLECT = (50_000, 20, 100)  # thresholds of the garbage collector (gc.set_threshold)
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
    """Base of all handlers: it checks the host name, and sets headers and short error pages."""

    application: Any  # this and the following attributes belong to tornado's handler
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
    """Handler of the files of the page, which contain no data of a model."""

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
    """Web socket of an open page; the server sends nothing before it has received the token."""

    def check_origin(self, origin: str) -> bool:
        return self.server.guard.knows_origin(origin)

    def prepare(self) -> None:
        super().prepare()
        is_allowed = self.server.guard.knows_origin(self.request.headers.get("Origin"))
        if not self._finished and not is_allowed:
            self.set_status(403)
            self.finish("Only pages of this server may connect.")

    def open(self, *_, **__) -> None:
        self.entered = False
        self.waiting = 0  # bytes not yet sent
        self.set_nodelay(True)
        loop = asyncio.get_running_loop()
        self.limit = loop.call_later(SECONDS_TO_ENTER, self._close_without_token)

    def _close_without_token(self) -> None:
        if not self.entered:
            self.close(4401, "no token")

    def on_message(self, message) -> None:
        if not self.entered:
            self._admit_or_close(message)
            return
        try:
            command, fields = read_message(message)
        except InputError as error:
            self.send({"kind": "refused", "message": str(error)})
            return
        self.server.carry_out(command, fields, self.send)

    def _admit_or_close(self, message) -> None:
        """Admit the page if its first message contains the token; otherwise close the socket."""
        try:
            reply = json.loads(message) if isinstance(message, str) and len(message) < 400 else None
        except (ValueError, RecursionError):
            reply = None
        token = reply.get("token") if isinstance(reply, dict) else None
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
        """Send a message to the page; only the thread of the event loop may call this."""
        if self.ws_connection is None:
            return
        binary = isinstance(message, bytes)
        if binary and self.waiting > _LARGEST_BACKLOG and b'"kind": "frame"' in message[:40]:
            return
        data = message if binary else json.dumps(message)
        try:
            future = self.write_message(data, binary=binary)
        except WebSocketClosedError:
            return
        self.waiting += len(data)
        future.add_done_callback(lambda sent: self._subtract_sent(len(data), sent))

    def _subtract_sent(self, size: int, future: asyncio.Future) -> None:
        self.waiting -= size
        future.exception()  # ignores the error of a page that has been closed


class LiveServer:
    """A web server with one session, which all its pages show.

    `folder`: the working folder.
    `host`: address at which the server listens.
    `port`: 0: the port of the last server of the folder, so that its pages reconnect, or a free
    port.
    `notebook`: whether notebooks on this machine may show the page.
    """

    def __init__(self, folder: Path, bundled_files: BundledFiles, host: str = LOOPBACK,
                 port: int = 0, notebook: bool = False):  # fmt: skip
        self.sockets: set[_PageSocket] = set()
        self.journal = Journal(folder)
        try:
            self._listening = _open_sockets(host, port) if port else self._open_last_sockets(host)
        except OutputError:
            self.journal.close()
            raise
        self.port = self._listening[0].getsockname()[1]
        self.journal.keep("port", {"port": self.port})
        self.guard = Guard(host, self.port, notebook)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._worker = ThreadPoolExecutor(1, "commands")
        callbacks = self.publish, lambda: bool(self.sockets)
        self.session = Session(folder, self.journal, bundled_files, *callbacks)

    def _open_last_sockets(self, host: str) -> list[socket.socket]:
        """Return sockets at the port of the last server of the folder, or at a free port."""
        port = (self.journal.kept("port") or {}).get("port")
        if isinstance(port, int) and 0 < port < 65536:
            with suppress(OutputError):
                return _open_sockets(host, port)
        return _open_sockets(host, 0)

    def publish(self, message: dict | bytes) -> None:
        """Send a message to all pages, from any thread."""
        if self._loop is not None and not self._loop.is_closed():
            try:
                self._loop.call_soon_threadsafe(self._send_to_pages, message)
            except RuntimeError:  # the event loop has just ended
                pass

    def _send_to_pages(self, message: dict | bytes) -> None:
        for page in list(self.sockets):
            page.send(message)

    def welcome(self, page: _PageSocket) -> None:
        """Send the state of the session to a new page, which then receives all messages."""

        def make_messages() -> None:
            schema_message = {"kind": "schema", "groups": schema(), "changeable": BETWEEN_STEPS}
            messages = [schema_message, *self.session.welcome()]
            self._loop.call_soon_threadsafe(send_messages, messages)

        def send_messages(messages: list) -> None:
            for message in messages:
                page.send(message)
            self.sockets.add(page)

        self._worker.submit(make_messages)

    def carry_out(self, command: str, fields: dict, answer: Callable) -> None:
        """Execute a command of a page after all earlier ones; call `answer` with an error."""

        def execute() -> None:
            try:
                self.session.carry_out(command, fields)
            except (SiteddaError, OSError) as error:
                refusal = {"kind": "refused", "message": str(error), "command": command}
                self._loop.call_soon_threadsafe(answer, refusal)
            except Exception as error:  # the server reports the error and continues
                logging.getLogger("sitedda").exception("the command %s fails", command)
                refusal = {"kind": "refused", "message": f"an error in sitedda: {error}"}
                self._loop.call_soon_threadsafe(answer, refusal)

        self._worker.submit(execute)

    async def serve(self, on_ready: Callable[[LiveServer], None] = lambda _: None) -> None:
        """Serve pages until SIGINT or SIGTERM; call `on_ready` once the server accepts requests."""
        self._loop = asyncio.get_running_loop()
        application = Application(
            [("/socket", _PageSocket, {"server": self}), (".*", _FileHandler, {"server": self})],
            guard=self.guard,
            websocket_max_message_size=LONGEST_MESSAGE,
            log_function=lambda _: None,  # requests are not logged, for privacy
        )
        server = HTTPServer(application, max_body_size=1000, max_header_size=16_384)
        server.add_sockets(self._listening)
        stop_requested = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            self._loop.add_signal_handler(number, stop_requested.set)
        try:
            on_ready(self)
            await stop_requested.wait()
        finally:
            server.stop()
            for page in list(self.sockets):
                page.close(1001, "the server has ended")
            await self._loop.run_in_executor(None, self.close)

    def close(self) -> None:
        """End the session; its model and run remain stored in the journal."""
        self.session.close()
        self._worker.shutdown(wait=False, cancel_futures=True)
        self.journal.close()


def schema() -> list[dict]:
    """Return the groups of the input and their variables, from which the page builds forms."""
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
    """Return listening sockets; raise OutputError if the host or port cannot be used."""
    try:
        return bind_sockets(port, host)
    except (OSError, OverflowError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        if isinstance(error, UnicodeError):
            reason = "this host name is invalid"
        raise OutputError(f"the server cannot use {host!r}, port {port}: {reason}") from error


def run_server(
    folder: Path,
    file: Path | None,
    bundled_files: BundledFiles,
    host: str = LOOPBACK,
    port: int = 0,
    open_browser: bool = True,
    notebook: bool = False,
) -> None:
    """Serve a session until the user presses Ctrl-C.

    `folder`: the working folder.
    `file`: input to open; None: continue the session of the last server of the folder, if any.
    `host`, `port`: address at which the server listens; port 0: the last one of the folder, or a
    free one.
    `open_browser`: whether to open a browser.
    `notebook`: whether notebooks on this machine may show the page.
    """
    gc.set_threshold(*_COLLECT)
    server = LiveServer(folder, bundled_files, host, port, notebook)
    try:
        if file is not None:
            server.session.open_file(file)
        else:
            server.session.recover()
        redirect_page = server.guard.write_redirect_page(server.journal.folder)
    except BaseException:
        server.close()
        raise

    def announce(_) -> None:
        _print_address(server, redirect_page)
        if open_browser:
            webbrowser.open(redirect_page.as_uri())

    try:
        asyncio.run(server.serve(announce))
    finally:
        redirect_page.unlink(missing_ok=True)


def _print_address(server: LiveServer, redirect_page: Path) -> None:
    """Print the address, and how to open the page on this machine or from another one."""
    print(f"sitedda live: {server.guard.address}, working folder {server.session.folder}")
    print(f"to enter, open {redirect_page}", flush=True)
    if os.environ.get("SSH_CONNECTION"):
        host = os.environ["SSH_CONNECTION"].split()[2]
        print(
            f"from another machine: ssh -N -L {server.port}:127.0.0.1:{server.port} "
            f"{os.environ.get('USER', 'USER')}@{host}\nthen open {server.guard.address} there "
            f"and enter the token (the text after # in {redirect_page})"
        )
    if not server.guard.address.startswith(f"http://{LOOPBACK}"):
        print(
            "warning: other machines can connect to this server, without encryption: anyone "
            "who reads the traffic can run models and write files here with your permissions",
            file=sys.stderr,
        )
    print("Ctrl-C ends the server; the next server continues the model and its run", flush=True)
