# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of scripts, which the usage at the head of each tells."""

import argparse
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
