# SPDX-License-Identifier: GPL-3.0-or-later
"""Time and error against the penalty: python tests/benchmarks/penalty.py [--docs]

A wall, a toppling slope and a column of the examples run with normal stiffnesses from 1 to
400 E · 1 m.  The error is the reduction of the first frequency by joints, as in the check; the
time is the processor time of a run, the least of three, over that at 1 E.  --docs draws
docs/howto/penalty.png.
"""

import re
import time

from common import ROOT, parse_options

import sitedda

RATIOS = (1, 4, 10, 40, 100, 400)  # ratio of the penalty to E · 1 m
STEPS = {"wall": 2000, "toppling": 2000, "column": 2000}
REPEATS = 3


def main() -> None:
    """Measure, print a table row for each penalty, and draw."""
    options = parse_options(__doc__, docs=False)
    results = {name: [measured(name, ratio) for ratio in RATIOS] for name in STEPS}
    for i, ratio in enumerate(RATIOS):
        cells = (
            f"{rows[i][0] / rows[0][0]:.2f}, {100 * rows[i][1]:.2f} %" for rows in results.values()
        )
        print(f"| {ratio} | {' | '.join(cells)} |", flush=True)
    if options.docs:
        draw(results)


def measured(name: str, ratio: float) -> tuple[float, float]:
    """Return the processor time, s, and the relative reduction of the first frequency by joints."""
    file = ROOT / "inputs" / f"{name}.nml"
    text = file.read_text()
    modulus = float(re.search(r"young_modulus = (\S+?)[,\s]", text)[1])
    step = float(re.search(r"time_step = (\S+?)[,\s]", text)[1])
    changes = {
        "contact.normal_stiffness": ratio * modulus,
        "control.duration": STEPS[name] * step,
        "control.time_step_control": "fixed",
    }
    seconds = []
    for _ in range(REPEATS):
        before = time.process_time()
        sitedda.run(file, output=False, changes=changes)
        seconds.append(time.process_time() - before)
    first = sitedda.modes(file, 1, changes=changes).frequency[0]
    return min(seconds), 1 - first / sitedda.penalty_for(file, changes=changes).limit


def draw(results: dict[str, list[tuple[float, float]]]) -> None:
    """Draw time and error versus penalty."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    for name, values in results.items():
        seconds, errors = zip(*values, strict=True)
        axes[0].loglog(RATIOS, [time / seconds[0] for time in seconds], "o-", label=name)
        axes[1].loglog(RATIOS, [100 * time for time in errors], "o-", label=name)
    axes[1].axhline(1.0, color="0.6", linewidth=1)
    for axis, label in zip(axes, ("time of a run / that at 1 E", "error of f₁, %"), strict=True):
        axis.set(xlabel="penalty / (E · 1 m)", ylabel=label)
        axis.legend(frameon=False)
    figure.savefig(ROOT / "docs" / "howto" / "penalty.png", dpi=110)


if __name__ == "__main__":
    main()
