# SPDX-License-Identifier: GPL-3.0-or-later
"""Access control of the server: one user with a token, from a page of the server itself.

The token is stored in a private file, never in an argument, a transmitted address or a log.  The
browser opens this file, which forwards the token behind the ``#`` of the address, and the page
sends the token in its first message.  Only host names and origins of the server are accepted, so
that no other page can reach it by another name.
"""

import hmac
import os
import secrets
from html import escape
from pathlib import Path

from ..base.files import make_folder, write

SECONDS_TO_ENTER = 10.0  # s in which a new connection must send the token
LOOPBACK = "127.0.0.1"


class Guard:
    """The token and the names of a server.

    Parameters
    ----------
    host : str
        Address that the server listens at.
    port : int
    notebook : bool
        Whether notebooks on this machine may show the page in a frame.
    """

    def __init__(self, host: str, port: int, notebook: bool = False):
        names = {host, "localhost"} if host == LOOPBACK else {host}
        self.hosts = {f"{_bracket_ipv6(name)}:{port}" for name in names}
        self.address = f"http://{_bracket_ipv6(host)}:{port}/"
        self.token = secrets.token_urlsafe(32)
        self.frames = "http://127.0.0.1:* http://localhost:*" if notebook else "'none'"

    def knows_origin(self, origin: str | None) -> bool:
        """Return whether a page of this server requests a connection."""
        return origin in {f"http://{host}" for host in self.hosts}

    def admits(self, token) -> bool:
        """Return whether a token is correct, compared in constant time."""
        return isinstance(token, str) and hmac.compare_digest(token.encode(), self.token.encode())

    def headers(self) -> dict[str, str]:
        """Return the headers of every answer: the page may use only content of this server."""
        sockets = " ".join(f"ws://{host}" for host in sorted(self.hosts))
        policy = (
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
            f"connect-src 'self' {sockets}; base-uri 'none'; form-action 'none'; "
            f"frame-ancestors {self.frames}"
        )
        return {
            "Content-Security-Policy": policy,
            "Cache-Control": "no-store",
            "Cross-Origin-Opener-Policy": "same-origin",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }

    def write_entrance(self, folder: Path) -> Path:
        """Write the private page that forwards a browser to the server; return its path."""
        target = escape(f"{self.address}#{self.token}")
        page = (
            "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>sitedda</title>"
            f"<meta http-equiv='refresh' content='0; url={target}'></head>"
            f"<body><p><a href='{target}'>sitedda live</a></p></body></html>\n"
        )
        file = private_folder(folder) / "enter.html"
        before = os.umask(0o077)
        try:
            write(file, page, "a page")
        finally:
            os.umask(before)
        file.chmod(0o600)
        return file


def private_folder(folder: Path) -> Path:
    """Create a folder that nobody else can read."""
    make_folder(folder).chmod(0o700)
    return folder


def _bracket_ipv6(host: str) -> str:
    return f"[{host}]" if ":" in host else host
