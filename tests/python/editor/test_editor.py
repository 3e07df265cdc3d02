# SPDX-License-Identifier: GPL-3.0-or-later
"""Help for editors: diagnostics in the engine's words, completion, hover, schema and grammar."""

import json
import re
import subprocess
import sys

import jsonschema
import numpy as np
import pytest
from test_bad_input import CASES

from sitedda import check
from sitedda.editor.description import json_schema, text_mate_grammar
from sitedda.editor.language import hover, offers, problems
from sitedda.input.input_text import UNSET, find_groups
from sitedda.input.schema import GROUPS

TEXT = """&control
  time_step = 1e-3  ! &joint
  time_step_control = 'f
"""


@pytest.mark.parametrize(
    ("groups", "group", "message"),
    [case for case in CASES if isinstance(case.values[0], list)][:40],
)
def test_mistakes_are_diagnostics_with_the_message_of_the_engine(
    groups, group, message, write_input
):
    file = write_input(groups)
    text = file.read_text()
    with pytest.raises(Exception) as failure:
        check(file)
    (problem,) = problems(text, file)
    assert problem.message == str(failure.value)
    row = text.split("\n")[problem.line]
    assert 0 <= problem.start < problem.end <= len(row)
    assert row[problem.start : problem.end] in problem.message or row.startswith(group)


def test_a_sound_input_has_no_problem_whether_saved_or_not(write_input):
    from model_text import tower

    file = write_input(tower())
    assert problems(file.read_text(), file) == []
    file.write_text("nonsense")
    assert problems("&control time_step = 1e-3, steps = 1 /", file)[0].message


def test_completion_offers_every_group_and_variable_once():
    assert {offer.word for offer in offers("", 0, 0)} == {f"&{name}" for name in GROUPS}
    for name, group in GROUPS.items():
        text = f"&{name} "
        names = [variable.name for variable in group.variables]
        assert [offer.word for offer in offers(text, 0, len(text))] == names
        for v in group.variables:
            hover_text = hover(f"&{name} {v.name} = ", 0, len(name) + 2)
            assert v.meaning in hover_text and v.unit in hover_text and v.default in hover_text


def test_completion_depends_on_the_position():
    assert not offers(TEXT, 1, len("  time_step = 1e-3  ! &jo"))  # a comment
    assert [offer.word for offer in offers(TEXT, 2, 24)] == ["fixed", "adaptive"]
    left = {offer.word for offer in offers("&control time_step = 1, ", 0, 24)}
    assert "steps" in left and "time_step" not in left
    assert offers("&run title = 'a / b' / ", 0, 23)[0].kind == "group"  # a slash in a text
    assert hover("! time_step", 0, 4) == ""
    assert "&control time_step" in hover("&control /", 0, 3)


def values_of(file) -> dict:
    """An input as the object that the JSON schema describes."""
    all_values: dict = {}
    for group in find_groups(file.read_text(), file):
        values = {k: np.asarray(v).ravel().tolist() if np.ndim(v) else v
                  for k, v in group.values.items()}  # fmt: skip
        values = {k: [x for x in v if x != UNSET] if isinstance(v, list) else v
                  for k, v in values.items()}  # fmt: skip
        if GROUPS[group.name].repeats:
            all_values.setdefault(group.name, []).append(values)
        else:
            all_values[group.name] = values
    return all_values


def test_shipped_inputs_meet_the_json_schema_and_mistakes_do_not(request):
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    files = sorted(request.config.rootpath.glob("inputs/*.nml"))
    assert files
    for file in files:
        assert not list(validator.iter_errors(values_of(file))), file
    good = values_of(files[0])
    for group, name, value in [
        ("control", "time_step", -1.0), ("control", "time_step_control", "free"),
        ("control", "stepps", 3), ("gone", "x", 1),
    ]:  # fmt: skip
        bad = good | {group: good.get(group, {}) | {name: value}}
        assert list(validator.iter_errors(bad)), (group, name)


def test_the_grammar_colours_groups_variables_and_comments():
    grammar = text_mate_grammar()
    pattern_by_begin = {p["begin"]: p for p in grammar["patterns"] if "begin" in p}
    assert len(pattern_by_begin) == len(GROUPS)
    control = next(p for begin, p in pattern_by_begin.items() if "&control" in begin)
    variable_pattern = next(p for p in control["patterns"] if p["name"].startswith("variable"))
    assert re.search(variable_pattern["match"], "  time_step = 1")
    assert not re.search(variable_pattern["match"], "  time_stop = 1")


def test_the_language_server_answers():
    """The test communicates through the pipe of the server, like an editor."""
    pytest.importorskip("pygls")
    server = subprocess.Popen([sys.executable, "-m", "sitedda", "editor", "server"],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip

    def send(method, params, number=None):
        body = {"jsonrpc": "2.0", "method": method, "params": params}
        data = json.dumps(body | ({} if number is None else {"id": number})).encode()
        server.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        server.stdin.flush()

    def receive(condition):
        while True:
            head = b""
            while not head.endswith(b"\r\n\r\n"):
                head += server.stdout.read(1)
            size = int(re.search(rb"Content-Length: (\d+)", head)[1])
            response = json.loads(server.stdout.read(size))
            if condition(response):
                return response

    document = {"uri": "file:///tmp/model.nml", "languageId": "nml", "version": 1}
    send("initialize", {"processId": None, "rootUri": None, "capabilities": {}}, 1)
    assert receive(lambda a: a.get("id") == 1)["result"]["capabilities"]["hoverProvider"]
    send("initialized", {})
    text = "&control time_step = -1, steps = 1 /\n"
    send("textDocument/didOpen", {"textDocument": document | {"text": text}})
    parameters = receive(lambda a: a.get("method") == "textDocument/publishDiagnostics")["params"]
    (diagnostic,) = parameters["diagnostics"]
    assert "time_step = -1 must be" in diagnostic["message"]
    assert diagnostic["range"]["start"] == {"line": 0, "character": 9}
    position = {"textDocument": {"uri": document["uri"]}, "position": {"line": 0, "character": 9}}
    send("textDocument/completion", position, 2)
    labels = [item["label"] for item in receive(lambda a: a.get("id") == 2)["result"]]
    assert "time_step" in labels or "steps" in labels
    send("shutdown", None, 3)
    receive(lambda a: a.get("id") == 3)
    send("exit", None)
    assert server.wait(20) == 0


def test_shells_complete_commands_and_options(main):
    pytest.importorskip("shtab")
    process = main("editor", "bash")
    assert process.returncode == 0 and "--set" in process.stdout and "pushover" in process.stdout
    assert subprocess.run(["bash", "-n"], input=process.stdout, text=True).returncode == 0
    assert json.loads(main("editor", "schema").stdout) == json_schema()
