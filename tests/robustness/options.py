# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of scripts, which the usage at the head of each tells."""

import argparse


def asked(doc: str, **defaults) -> argparse.Namespace:
    """``--name VALUE`` for each default, of its type, or of a type alone; False: a switch."""
    style = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=doc, formatter_class=style)
    for name, default in defaults.items():
        kind = default if isinstance(default, type) else type(default)
        more = {"action": "store_true"} if default is False else {"type": kind}
        parser.add_argument(f"--{name}", default=None if kind is default else default, **more)
    return parser.parse_args()
