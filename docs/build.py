#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the handbook with the pages of the Fortran tree beside it.

usage: python docs/build.py [-o FOLDER] [--without-fortran]

Needs `pip install '.[docs]'`.  Warnings are errors: a link that leads nowhere is one.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

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
    print(f"handbook: {output / 'index.html'}")


def call(module: str, *words) -> None:
    """Run a module of this Python; end with its status if it fails."""
    status = subprocess.run([sys.executable, "-m", module, *map(str, words)]).returncode
    if status:
        sys.exit(f"{module} failed ({status})")


if __name__ == "__main__":
    main()
