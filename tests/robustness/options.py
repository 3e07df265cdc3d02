# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of scripts, which the usage at the head of each tells, and their loop over cases."""

import argparse
from collections.abc import Iterable
from pathlib import Path


def asked(doc: str, *paths: str, **defaults) -> argparse.Namespace:
    """Paths by position, and ``--name VALUE`` for each default: of its type, or of a type alone.

    False is a switch; a list takes several values.
    """
    style = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=doc, formatter_class=style)
    for name in paths:
        parser.add_argument(name, type=Path)
    for name, default in defaults.items():
        one = default[0] if isinstance(default, list) else default
        kind = one if isinstance(one, type) else type(one)
        more = {"action": "store_true"} if one is False else {"type": kind}
        more |= {"nargs": "+"} if isinstance(default, list) else {}
        option = "--" + name.replace("_", "-")
        parser.add_argument(option, default=None if kind is one else default, **more)
    return parser.parse_args()


def count_wrong(cases: Iterable[tuple[str, bool]]) -> int:
    """Print words on each case and whether it is right; return status 1 if one is wrong."""
    right = []
    for words, good in cases:
        print(f"{words}: {'right' if good else 'WRONG'}", flush=True)
        right.append(good)
    print(f"{len(right)} cases, {right.count(False)} wrong")
    return int(not all(right))
