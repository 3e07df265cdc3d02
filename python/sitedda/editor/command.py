# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda editor`: support for inputs in editors and for commands in shells."""

import argparse
import json

from ..base.errors import library_required

_SHELLS = ("bash", "zsh", "tcsh")


def add_editor(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "what",
        choices=("server", "schema", "grammar", *_SHELLS, "man"),
        help="start a language server on standard input and output, or print the JSON schema or "
        "TextMate grammar of inputs, the completion for a shell, or the man page",
    )
    parser.set_defaults(act=help_editor)


def help_editor(options: argparse.Namespace) -> int:
    """Run the language server, or print a schema, grammar, completion or man page."""
    if options.what == "server":
        from .server import language_server

        language_server().start_io()
    elif options.what in ("schema", "grammar"):
        from . import description

        pages = {"schema": description.json_schema, "grammar": description.text_mate_grammar}
        print(json.dumps(pages[options.what](), indent=1))
    else:
        print(_describe_commands(options.what))
    return 0


def _describe_commands(what: str) -> str:
    """Return the completion for a shell or the man page, generated from the parser."""
    from ..commands.command import whole_parser

    with library_required(f"{what} needs a library: pip install 'sitedda[editor]'"):
        if what == "man":
            from argparse_manpage.manpage import Manpage

            return str(Manpage(whole_parser()))
        import shtab

        return shtab.complete(whole_parser(), shell=what)
