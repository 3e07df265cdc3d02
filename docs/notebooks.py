# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the tutorials of this handbook as Jupyter notebooks.

usage: python docs/notebooks.py [-o FOLDER]
"""

import argparse
import json
import os
import re
from pathlib import Path

DOCS = Path(__file__).resolve().parent
CODE = re.compile(r"^```(python|sh)\n(.*?)^```$", re.M | re.S)
LINK = re.compile(r"\]\((?!\w+:|#)([^)\s]+)\)")


def main() -> None:
    """All tutorials."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("notebooks"), help="(notebooks)")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for page in sorted(DOCS.glob("tutorials/*.md")):
        (folder / f"{page.stem}.ipynb").write_text(json.dumps(notebook(page, folder), indent=1))


def notebook(page: Path, folder: Path) -> dict:
    """A page as a notebook: Python and commands are cells to run, the rest is text."""
    text, *remainder = CODE.split(page.read_text())
    cells = [_text(text, page, folder)]
    for kind, code, text in zip(remainder[::3], remainder[1::3], remainder[2::3], strict=True):
        lines = code if kind == "python" else re.sub("^(?=.)", "!", code, flags=re.M)
        ran = {"execution_count": None, "outputs": [], "source": lines.strip()}
        cells += [{"cell_type": "code", "metadata": {}} | ran, _text(text, page, folder)]
    return {"nbformat": 4, "nbformat_minor": 4, "metadata": {}, "cells": cells}


def _text(text: str, page: Path, folder: Path) -> dict:
    """A cell of text, whose links lead from the folder."""

    def moved(link):
        return f"]({os.path.relpath(page.parent / link[1], folder)})"

    return {"cell_type": "markdown", "metadata": {}, "source": LINK.sub(moved, text.strip())}


if __name__ == "__main__":
    main()
