# SPDX-License-Identifier: GPL-3.0-or-later
"""Access control: only pages of the server itself that send its secret token are served.

The token is stored in a private file, never in an argument, a transmitted address or a log.  The
browser opens this file, which forwards to the address of the server with ``#`` and the token.  The
page sends the token in its first message.  The server rejects requests with other host names and
origins, so that foreign web pages have no access.
"""

import hmac
import os
import secrets
from html import escape
from pathlib import Path

from ..base.files import make_folder, write

SECONDS_TO_ENTER = 10.0  # s within which a new connection must send the token
LOOPBACK = "127.0.0.1"


class Guard:
    """The token of a server, and its accepted host names.

    `host`: address at which the server listens.
    `notebook`: whether notebooks on this machine may show the page in a frame.
    """

    def __init__(self, host: str, port: int, notebook: bool = False):
        names = {host, "localhost"} if host == LOOPBACK else {host}
        self.hosts = {f"{_host_in_url(name)}:{port}" for name in names}
        self.address = f"http://{_host_in_url(host)}:{port}/"
        self.token = secrets.token_urlsafe(32)
        self.frames = "http://127.0.0.1:* http://localhost:*" if notebook else "'none'"

    def knows_origin(self, origin: str | None) -> bool:
        """Return whether an origin is that of a page of this server."""
        return origin in {f"http://{host}" for host in self.hosts}

    def admits(self, token) -> bool:
        """Return whether a token is correct; the time of the comparison reveals nothing."""
        return isinstance(token, str) and hmac.compare_digest(token.encode(), self.token.encode())

    def headers(self) -> dict[str, str]:
        """Return the headers of all responses, which allow only content of this server."""
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

    def write_redirect_page(self, folder: Path) -> Path:
        """Write the private page that forwards a browser to the server; return its path."""
        target = escape(f"{self.address}#{self.token}")
        page = (
            "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>sitedda</title>"
            f"<meta http-equiv='refresh' content='0; url={target}'></head>"
            f"<body><p><a href='{target}'>sitedda live</a></p></body></html>\n"
        )
        file = private_folder(folder) / "enter.html"
        old_mask = os.umask(0o077)
        try:
            write(file, page, "a page")
        finally:
            os.umask(old_mask)
        file.chmod(0o600)
        return file


def private_folder(folder: Path) -> Path:
    """Create a folder that nobody else can read."""
    make_folder(folder).chmod(0o700)
    return folder


def _host_in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host
