# SPDX-License-Identifier: GPL-3.0-or-later
"""The TextMate grammar in the tokenizer of Visual Studio Code, compared with the input reader."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from sitedda.editor.description import text_mate_grammar
from sitedda.input.input_text import find_groups

PACKAGES = ("vscode-textmate@9", "vscode-oniguruma@2")
TEXT = """! a/b = 1
&control stepps = 3, time_step = 1d-3 ! 'x
  settle = .true. / &contrl steps = 1 /
&run title = "it's 2 / 3! &mesh" /"""
SCOPES = {
    "comment.line": ["! a/b = 1", "! 'x"],
    "constant.language": [".true."],
    "constant.numeric": ["3", "1d-3"],
    "entity.name.section": ["&control", "&run"],
    "string.quoted": ['"it\'s 2 / 3! &mesh"'],
    "variable.parameter": ["time_step", "settle", "title"],
}


@pytest.fixture(scope="module")
def tokens(tmp_path_factory):
    """A function that returns the words of a text by their scope."""
    if not shutil.which("node") or not shutil.which("npm"):
        pytest.skip("the tokenizer of Visual Studio Code needs node and npm")
    folder = tmp_path_factory.mktemp("node")
    install = ["npm", "install", "--silent", "--prefix", folder, *PACKAGES]
    if subprocess.run(install, check=False).returncode:
        pytest.skip("npm cannot download the tokenizer of Visual Studio Code")
    script = Path(__file__).with_name("tokens.js")

    def tokens(text, grammar):
        process = subprocess.run(["node", script], check=True, stdout=subprocess.PIPE, text=True,
                              env=os.environ | {"NODE_PATH": str(folder / "node_modules")},
                              input=json.dumps({"grammar": grammar, "text": text}))  # fmt: skip
        scopes: dict = {}
        for token_text, scope in json.loads(process.stdout):
            scopes.setdefault(scope.removesuffix(".sitedda"), []).append(token_text)
        return {scope: scopes[scope] for scope in scopes if scope != "source"}

    return tokens


def test_mistakes_have_no_scope_and_each_pattern_is_needed(tokens):
    assert tokens(TEXT, text_mate_grammar()) == SCOPES
    for removed in range(5):
        grammar = text_mate_grammar()
        for group in grammar["patterns"][1:]:
            del group["patterns"][removed]
        assert tokens(TEXT, grammar) != SCOPES


def test_names_of_examples_have_the_scopes_that_the_reader_gives_them(tokens, request):
    files = request.config.rootpath.glob("inputs/**/*.nml")
    text = "\n".join(file.read_text() for file in files)
    groups, scopes = find_groups(text), tokens(text, text_mate_grammar())
    assert scopes["entity.name.section"] == [f"&{group.name}" for group in groups]
    names = [name for group in groups for name in group.values]
    assert sorted(scopes["variable.parameter"]) == sorted(names)
