# SPDX-License-Identifier: GPL-3.0-or-later
"""Generate JSON schema and TextMate grammar from the schema of the input."""

import re

from ..input.schema import GROUPS, Variable

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"
_TYPES = {"real": "number", "integer": "integer", "logical": "boolean"}
_RANGE = re.compile(rf"({_NUMBER}) to ({_NUMBER})")


def json_schema() -> dict:
    """Return the JSON schema (draft 2020-12) of an input: groups and their variables.

    A group that may repeat is an array of objects; any other group is an object.
    """
    groups = {}
    for group in GROUPS.values():
        entry = {
            "description": group.meaning,
            "type": "object",
            "properties": {v.name: _describe_variable(v) for v in group.variables},
            "required": [v.name for v in group.variables if v.default == "required" and not v.when],
            "additionalProperties": False,
        }
        groups[group.name] = {"type": "array", "items": entry} if group.repeats else entry
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Input of sitedda",
        "type": "object",
        "properties": groups,
        "additionalProperties": False,
    }


def _describe_variable(variable: Variable) -> dict:
    """Return the JSON schema of a variable."""
    schema: dict = {"type": _TYPES.get(variable.kind, "string")}
    if variable.kind == "points":
        schema = {"type": "number"}
    if variable.kind == "word":
        schema["enum"] = [value.strip("'") for value in re.findall(r"'[^']*'", variable.values)]
    if schema["type"] in ("number", "integer"):
        schema |= (
            _value_limits(variable.values) if variable.size == 0 or variable.kind == "real" else {}
        )
    if variable.size:
        size = variable.size * (2 if variable.kind == "points" else 1)
        schema = {"anyOf": [schema, {"type": "array", "items": schema, "maxItems": size}]}
    schema["description"] = variable.meaning
    for name, text in (("unit", variable.unit), ("default", variable.default)):
        schema |= {f"x-{name}": text} if text else {}
    return schema


def _value_limits(values: str) -> dict:
    """Return the limits of a number in JSON schema, from their words in the input schema."""
    if match := _RANGE.fullmatch(values):
        return {"minimum": float(match[1]), "maximum": float(match[2])}
    if match := re.fullmatch(rf"(above|at least) ({_NUMBER})", values):
        return {"exclusiveMinimum" if match[1] == "above" else "minimum": float(match[2])}
    return {}


def text_mate_grammar() -> dict:
    """Return the TextMate grammar of inputs (scope ``source.sitedda``) for editors."""
    patterns = {
        "comment.line": r"!.*$",
        "string.quoted": r"'[^']*'|\"[^\"]*\"",
        "constant.language": r"(?i)\.(?:true|false)\.",
        "constant.numeric": rf"(?<![\w.]){_NUMBER}(?![\w.])",
    }
    shared = [{"name": f"{name}.sitedda", "match": match} for name, match in patterns.items()]
    groups = [
        {
            "begin": rf"(?i)(&{group.name})\b",
            "end": "/",
            "beginCaptures": {"1": {"name": "entity.name.section.sitedda"}},
            "patterns": [
                *shared,
                {"name": "variable.parameter.sitedda",
                 "match": rf"(?i)\b(?:{'|'.join(v.name for v in group.variables)})\b(?=[^=\n]*=)"},
            ],
        }
        for group in GROUPS.values()
    ]  # fmt: skip
    return {
        "name": "sitedda input",
        "scopeName": "source.sitedda",
        "fileTypes": ["nml"],
        "patterns": [shared[0], *groups],
    }
