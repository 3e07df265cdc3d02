#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two builds read the same inputs: both accept each input, to the same state, or neither does.

usage: python tests/robustness/same_inputs.py OTHER_PYTHON [--seeds FIRST LAST]

OTHER_PYTHON is the interpreter of an environment with another build.  Half of the inputs are those
of fuzz.py; the others are good ones written in other forms: repeat counts, values left out, parts
of lists, exponents with d, doubled quotes, comments, several groups on a line.  Prints what
differs, and ends with status 1 if anything does.
"""

import argparse
import hashlib
import json
import random
import subprocess
import sys
import tempfile
from itertools import groupby
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]

from mutations import models, mutated_input  # noqa: E402

MOST = 2000  # blocks of a model that is set up


def number_text(chance: random.Random, value: float) -> str:
    """A number in one of its forms."""
    text = repr(value)
    forms = [text, f"+{text}" if value >= 0 else text, text.replace("e", "d"), f"{value:.17e}"]
    return chance.choice([*forms, f"{value:.17E}".replace("E", "D")])


def list_text(chance: random.Random, name: str, values: list) -> str:
    """A list in one of its forms."""
    words = [number_text(chance, one) if isinstance(one, float) else str(one) for one in values]
    match chance.randrange(4):
        case 0:  # repeat counts
            runs = [(word, len(list(same))) for word, same in groupby(words)]
            return f"{name} = " + ", ".join(f"{n}*{word}" if n > 1 else word for word, n in runs)
        case 1 if len(words) > 1 and name != "vertices":  # in two parts
            cut = chance.randrange(1, len(words))
            head, tail = " ".join(words[:cut]), ", ".join(words[cut:])
            return f"{name}({cut + 1}:{len(words)}) = {tail}, {name}(1:{cut}) = {head}"
        case 2:  # first something else, then values left out
            kept = chance.randrange(len(words))
            rest = ["" if i == kept else word for i, word in enumerate(words)]
            first = [word if i == kept else "7.5" for i, word in enumerate(words)]
            return f"{name} = {', '.join(first)} {name} = {', '.join(rest)}"
    return f"{name} = " + chance.choice([" ", ", ", " ,\n "]).join(words)


def written_otherwise(seed: int) -> bytes:
    """A good input in other forms; the same seed gives the same bytes."""
    chance = random.Random(seed)
    text = ""
    for name, values in chance.choice(models()):
        parts = []
        for variable, value in values.items():
            if value is None:
                continue
            if isinstance(value, bool):
                word = chance.choice(["T", ".true.", "true"] if value else ["F", ".false.", ".f"])
            elif isinstance(value, str):
                quote = chance.choice("'\"")
                word = quote + value.replace(quote, 2 * quote) + quote
            elif isinstance(value, int | float):
                word = number_text(chance, value) if isinstance(value, float) else str(value)
            else:
                parts.append(list_text(chance, variable, [one for one in value]))
                continue
            parts.append(f"{chance.choice([variable, variable.upper()])} = {word}")
        between = chance.choice([" ", ", ", "\n", " ! / & a comment'\n"])
        text += f"&{name} {between.join(parts)} /" + chance.choice(["\n", " ", "\t", " ! end\n"])
    return text.encode()


def state_of(file: Path) -> str:
    """What becomes of an input: a word for a refusal, or a number for the state."""
    import sitedda

    try:
        with sitedda.Simulation(file) as run:
            parts = [run.title.encode(), *[part.tobytes() for part in run.polygons]]
            parts += [run.coordinates.tobytes(), run.rates.tobytes(), run.stresses.tobytes()]
            if len(run.polygons) < MOST:
                run.advance(2)
                parts += [
                    run.coordinates.tobytes(),
                    repr({n: e for n, e in run.energies.items() if e}).encode(),
                ]
            return hashlib.sha256(b"".join(parts)).hexdigest()[:16]
    except sitedda.InputError as error:
        return f"refused: {str(error).replace(str(file), 'FILE')[:300]}"
    except sitedda.SiteddaError as error:
        return f"ended: {type(error).__name__}"


def worker(folder: Path) -> None:
    """Answer the seeds on standard input."""
    for line in sys.stdin:
        file = folder / "input.nml"
        seed = int(line)
        file.write_bytes(mutated_input(seed) if seed % 2 else written_otherwise(seed))
        print(json.dumps([seed, state_of(file)]), flush=True)


def main() -> int:
    """Compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("other", nargs="?")
    parser.add_argument("--seeds", nargs=2, type=int, default=(0, 20_000))
    parser.add_argument("--worker", type=Path)
    options = parser.parse_args()
    if options.worker:
        worker(options.worker)
        return 0
    differing = 0
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        both = [
            subprocess.Popen(
                [python, __file__, "--worker", folder],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            )
            for python, folder in ((options.other, one), (sys.executable, two))
        ]  # fmt: skip
        for seed in range(*options.seeds):
            for process in both:
                process.stdin.write(f"{seed}\n")
                process.stdin.flush()
            before, after = (json.loads(process.stdout.readline())[1] for process in both)
            refused = before.startswith("refused") and after.startswith("refused")
            if before != after and not refused:
                differing += 1
                print(f"{seed}: {before} | {after}", flush=True)
        for process in both:
            process.stdin.close()
            process.wait()
    print(f"{differing} of {options.seeds[1] - options.seeds[0]} inputs differ")
    return int(differing > 0)


if __name__ == "__main__":
    sys.exit(main())
