# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the actions of a run as a Python script, whose results are bit-identical.

An action is a dict: step and time after which it was executed, ``do`` ('change' or 'stage'), and
``changes`` or ``values``, as texts of the input.
"""

import math

_HEAD = '''# written by sitedda
"""{title}"""

import sitedda

with sitedda.Simulation({model!r}, output={output!r}) as run:
'''


def written_script(
    model: str, output: str, title: str, actions: list[dict], steps: int | None
) -> str:
    """Return the script of a run.

    `model`, `output`: names of the input file and of the output file; `steps`: number of steps
    after which the run was stopped; None if it is complete.
    """
    title = title.replace("\\", "\\\\").replace('"', "'")
    lines, step = [], 0
    for action in actions:
        if action["step"] > step:
            lines.append(f"run.advance({action['step'] - step})  # to t = {action['time']:.6g} s")
            step = action["step"]
        lines.append(_python_call(action))
    if steps is None:
        lines.append("while not run.advance(1000):\n        pass")
    elif steps > step:
        lines.append(f"run.advance({steps - step})")
    lines.append("run.finish()")
    body = "".join(f"    {line}\n" for line in lines)
    title = f"Repeat the run {title} with its changes and stages."
    return _HEAD.format(title=title, model=model, output=output) + body


def _python_call(action: dict) -> str:
    if action["do"] == "change":
        values = ", ".join(f"{k!r}: {literal(v)}" for k, v in action["changes"].items())
        return f"run.change({{{values}}})"
    values = ", ".join(f"{k}={literal(v)}" for k, v in action["values"].items())
    return f"run.begin_stage({values})"


def literal(typed: str) -> str:
    """Convert a value of the input to Python code: number, tuple, logical value or text."""
    text = typed.strip()
    if text.lower() in (".true.", ".false."):
        return str(text.lower() == ".true.")
    numbers = [_number_literal(number) for number in text.split(",")]
    if all(number is not None for number in numbers):
        return numbers[0] if len(numbers) == 1 else f"({', '.join(numbers)})"
    return repr(text)


def _number_literal(text: str) -> str | None:
    try:
        value = float(text.strip().lower().replace("d", "e"))
    except ValueError:
        return None
    return repr(value) if math.isfinite(value) else None


def changes_outside_stages(actions: list[dict]) -> list[str]:
    """Describe the changes that no &stage can express."""
    return [
        f"at t = {act['time']:.6g} s: {', '.join(f'{k} = {v}' for k, v in act['changes'].items())}"
        for act in actions
        if act["do"] == "change"
    ]
