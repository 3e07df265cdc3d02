# SPDX-License-Identifier: GPL-3.0-or-later
"""Command-line options of scripts, documented by the usage in their docstrings, and case loops."""

import argparse
from collections.abc import Iterable
from pathlib import Path


def parse_options(doc: str, *paths: str, **defaults) -> argparse.Namespace:
    """Parse positional paths, and an option ``--name VALUE`` for each default or type.

    False is a switch; a list has several values.
    """
    style = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=doc, formatter_class=style)
    for name in paths:
        parser.add_argument(name, type=Path)
    for name, default in defaults.items():
        element = default[0] if isinstance(default, list) else default
        kind = element if isinstance(element, type) else type(element)
        options = {"action": "store_true"} if element is False else {"type": kind}
        options |= {"nargs": "+"} if isinstance(default, list) else {}
        option = "--" + name.replace("_", "-")
        parser.add_argument(option, default=None if kind is element else default, **options)
    return parser.parse_args()


def count_wrong(cases: Iterable[tuple[str, bool]]) -> int:
    """Print a description of each case and whether it is right; return status 1 if one is wrong."""
    right = []
    for label, good in cases:
        print(f"{label}: {'right' if good else 'WRONG'}", flush=True)
        right.append(good)
    print(f"{len(right)} cases, {right.count(False)} wrong")
    return int(not all(right))
