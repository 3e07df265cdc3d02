#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the handbook with the pages of the Fortran tree beside it.

usage: python docs/build.py [-o FOLDER] [--without-fortran]

Needs `pip install '.[docs]'`.  Warnings are errors, and so are links within that lead nowhere.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

HERE = Path(__file__).resolve().parent


def main() -> None:
    """Build both parts."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("build/handbook"))
    parser.add_argument("--without-fortran", action="store_true", help="no pages of fortran/")
    options = parser.parse_args()
    output = options.output.resolve()
    call("sphinx", "-W", "--keep-going", "-q", "-b", "html", HERE, output)
    if not options.without_fortran:
        call("ford", "-q", "-o", output / "fortran", HERE / "ford.md")
        mend_interfaces(output / "fortran" / "interface")
    dead = dead_links(output)
    if options.without_fortran:
        dead = [item for item in dead if ": fortran/" not in item]
    if dead:
        sys.exit("links that lead nowhere:\n" + "\n".join(dead))
    print(f"handbook: {output / 'index.html'}")


def call(module: str, *arguments) -> None:
    """Run a module of this Python; end with its status if it fails."""
    status = subprocess.run([sys.executable, "-m", module, *map(str, arguments)]).returncode
    if status:
        sys.exit(f"{module} failed ({status})")


def mend_interfaces(folder: Path) -> None:
    """Ford lists the procedures of an interface by anchors that it then writes otherwise."""
    for file in folder.glob("*.html"):
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace("#moduleprocedure-", "#proc-"), encoding="utf-8")


class Links(HTMLParser):
    """Links and anchors of a page."""

    def __init__(self, file: Path):
        super().__init__()
        self.links: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs) -> None:
        """Take its link and its names."""
        attributes = dict(attrs)
        if tag == "a" and attributes.get("href"):
            self.links.add(attributes["href"])
        self.anchors |= {attributes[name] for name in ("id", "name") if attributes.get(name)}


def dead_links(folder: Path) -> list[str]:
    """Links between files of a folder whose file or anchor is not there."""
    pages = {file: Links(file) for file in sorted(folder.rglob("*.html"))}
    dead = []
    for file, page in pages.items():
        for link in sorted(page.links):
            path, _, anchor = unquote(link).partition("#")
            if "://" in link or link.startswith(("mailto:", "javascript:", "data:")):
                continue
            target = Path(os.path.normpath(file.parent / path)) if path else file
            here = anchor in pages[target].anchors if target in pages else True
            if not target.exists() or (anchor and not here):
                dead.append(f"{file.relative_to(folder)}: {link}")
    return dead


if __name__ == "__main__":
    main()
