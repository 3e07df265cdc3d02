# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of the speed benchmark as tables and as a picture."""

import re
from pathlib import Path

STATES = ("quiet", "sudden", "settling", "shaken")
HEAD = """# Speed

`python tests/benchmarks/speed.py --docs` writes this page and [all measurements](benchmarks.csv)
(`late_ms` is the 99th percentile; counts are means per step). [Ablation](ablation.md) lists the
effect of each remedy of the iteration.

```{toctree}
:hidden:
ablation
```"""
SUMMARY = """If no contact changes its state, a step requires one to three microseconds per
block. With many contact changes it requires up to forty times as much, because of more
open–close iterations and factorisations. Mean time per step (ms) of a wall in running bond (Δt
1 ms, penalty 100 E), one thread and two:"""
MEANING = """- *sudden*: the first ten steps after sudden gravity on a wall whose bricks touch
  without force (avoidable by a [start from equilibrium](method.md#starting-from-equilibrium));
- *settling*: the next fifty steps;
- *shaken*: a settled wall, shaken by 0.1 g (a stack by 0.75 g);
- *quiet*: a settled wall, without contact changes.

![Cost of a step against the number of blocks](benchmarks.png)"""
AGAINST_PLAIN = """The same step in numpy and scipy (`tests/benchmarks/plain_step.py`) uses the
contacts that the engine has detected. The numpy program reuses its factor if no spring changes,
has no line search, and stops after 25 open–close iterations. The last column is the difference of
positions over the largest displacement (– without convergence):

"""
NOTES = """## Design choices

- **Low-rank update** (`low_rank.f90`): up to 160 springs that contacts add or remove correct the
  lagged factor. For more springs, or after eight extra iterations, K̂ is factorised again.
- **Zero blocks** of K̂, such as those of open joints, are omitted from the factor
  (`cholesky.f90.in`). A wall of 100,000 bricks with open head joints then requires 56 % of the
  entries and 39 % of the operations.
- **Factorisation** of 6×6 blocks: 2.7 to 5.8 times as fast as the supernodal factorisation of
  CHOLMOD, for walls of 1,000 and 10,000 bricks and one thread.
"""
OTHERS = """## Other programs

`tests/benchmarks/rivals.py` lets a wall of touching bricks settle under sudden gravity. Processor
times (one thread, median and range) of both DDA programs exclude the first step. Pairs of errors
are those of sitedda and of the other program: settlement of the top over ρgH²/2E, largest asymmetry
over ρgH²/2E, and reaction of the base over the weight, minus 1. After 60 steps of 1 ms the wall
still vibrates."""
AGAINST = {
    "ntdda": (
        """ntdda descends from the original DDA; penalty (its own, 50 E) and time steps are equal.
It updates velocities again whenever it repeats a step. Its walls become asymmetric, then collapse,
or a run does not end in 20 s (*fails*):""",
        ["blocks", "Δt, ms", "steps", "sitedda, ms/step", "ntdda, ms/step"],
    ),
    "box2d": (
        """Box2D 3 (16 substeps of 1/960 s) is faster for one second of 1,008 blocks, settling or
shaken by 0.1 g at 2 Hz. Its rigid bricks overlap by millimetres, thus its wall sinks and
spreads:""",
        ["wall", "Δt of sitedda, ms", "sitedda, ms/s", "Box2D, ms/s"],
    ),
}
GROWTH = ("wall 1000", "wall 10000", "wall 100000")
LOOKS = {(1e-3, 1): "C0o-", (1e-3, 2): "C1s-", (1e-5, 1): "C2o--", (1e-5, 2): "C3s--"}
RIVALS = (("sor", "C4x:", "engine with SOR"), ("plain", "C5^:", "numpy and scipy"))
PHASES = ("search", "detect", "assemble", "factorise", "solve", "iterate", "update")


def text(machine: str, results: list[dict], others: str = "") -> str:
    """Return the short page in Markdown, with a section on other programs."""
    measured_results = [result for result in results if "error" not in result]
    engine = [result for result in measured_results if result["solver_asked"] == "auto"]
    parts = [HEAD, f"Machine: {machine}.", SUMMARY, summary_table(engine), MEANING]
    parts += [growth_line(engine), rivals_table(engine), disturbances(measured_results)]
    failures = [f"- {name(result)}: {result['error']}" for result in results if "error" in result]
    if failures:
        parts.append("Not measured:\n\n" + "\n".join(failures))
    return "\n\n".join(part for part in [*parts, others, NOTES] if part)


def disturbances(results: list[dict]) -> str:
    """Return cases whose threads shared the processors with other programs, as Markdown."""
    lines = [f"- {name(result)}: {note}" for result in results for note in result["disturbed"]]
    introduction = "These cases shared the processors with other programs:\n\n"
    return introduction + "\n".join(lines) if lines else ""


def name(result: dict) -> str:
    """Return model, penalty and time step in words."""
    return f"{result['model']}, {result['penalty']:g} E, {result['time_step']:g} s"


def row(*cells) -> str:
    """Return a row of a Markdown table."""
    return f"|{'|'.join(map(str, cells))}|"


def table(heads: list[str], rows: list[str]) -> str:
    """Return a Markdown table."""
    return "\n".join([row(*heads), "|---" * len(heads) + "|", *rows])


def measured(result: dict) -> list[str]:
    """Return the measured states of a case."""
    return [state for state in STATES if state in result]


def digits(value: float) -> str:
    """Return a number with three significant digits."""
    return f"{float(f'{value:.3g}'):,g}"


def all_rows(results: list[dict]) -> str:
    """Return times, counts and phases of each state, as CSV."""
    times, counts = (
        ("step", "mean", "late", "worst"),
        ("iterations", "factors", "solver_iterations"),
    )
    heads = ["model", "penalty_E", "time_step_s", "blocks", "threads", "state", "steps",
             "median_ms", *(f"{each}_ms" for each in times[1:]), *counts, "solver", "memory_MB",
             *(f"{each}_ms" for each in PHASES)]  # fmt: skip
    lines = [heads]
    for result in results:
        for state in measured(result):
            row = result[state]
            case = [result[each] for each in ("model", "penalty", "time_step", "blocks", "threads")]
            lines.append([
                *case, state, row["steps"], *(f"{1e3 * row[each]:.3g}" for each in times),
                *(f"{row['counts'][each]:.3g}" for each in counts), result["solver"],
                f"{result['memory']:.0f}", *(f"{1e3 * row['phases'][each]:.3g}" for each in PHASES),
            ])  # fmt: skip
    return "".join(",".join(map(str, line)) + "\n" for line in lines)


def rivals_table(results: list[dict]) -> str:
    """Return the table of engine and plain step, with one thread."""
    rows = []
    for result in results:
        for phase in measured(result):
            x = result[phase]
            if "plain" in x:
                rows.append(
                    row(name(result), phase, f"{1e3 * x['own']:.3g}", f"{1e3 * x['plain']:.3g}",
                        f"{x['plain_iterations']:.0f}", f"{x['plain'] / x['own']:.0f}",
                        "–" if x["difference"] is None else f"{x['difference']:.0e}")
                )  # fmt: skip
    if not rows:
        return ""
    heads = ["model, penalty, time step", "state", "engine, ms", "numpy + scipy, ms",
             "numpy iterations", "time ratio", "difference"]  # fmt: skip
    return AGAINST_PLAIN + table(heads, rows)


def growth_line(results: list[dict]) -> str:
    """Return the growth of the time of a step with the number of blocks, as Markdown."""
    from math import log

    powers: dict[tuple[str, str], dict[int, str]] = {}
    for state, threads in ((state, threads) for state in STATES for threads in (1, 2)):
        times = sorted(
            (result["blocks"], result[state]["mean"])
            for result in results
            if (result["penalty"], result["time_step"], result["threads"]) == (100.0, 1e-3, threads)
            and result["model"] in GROWTH and state in result
        )  # fmt: skip
        if len(times) < 2:
            continue
        (n, small_time), (m, large_time) = times[0], times[-1]
        power = log(large_time / small_time) / log(m / n)
        powers.setdefault((state, f"{n:,} to {m:,}"), {})[threads] = f"{power:.2f}"
    if not powers:
        return ""
    lines = [row(*key, *(values.get(n, "–") for n in (1, 2))) for key, values in powers.items()]
    heads = ["state", "blocks", "exponent, 1 thread", "2 threads"]
    return "Exponent of mean step time versus number of blocks:\n\n" + table(heads, lines)


def summary_table(results: list[dict]) -> str:
    """Return mean step times of walls, the slowest state first, and memory, as Markdown."""
    walls = [
        {result["threads"]: result for result in results if result["model"] == wall
         and (result["penalty"], result["time_step"]) == (100.0, 1e-3)}
        for wall in ("wall 100", *GROWTH)
    ]  # fmt: skip
    walls = [wall for wall in walls if wall]
    rows = []
    for state in ("sudden", "settling", "shaken", "quiet"):
        cells = [
            ", ".join(digits(1e3 * it[state]["mean"]) for _, it in sorted(wall.items())
                      if state in it)
            for wall in walls
        ]  # fmt: skip
        rows.append(row(state, *(cell or "–" for cell in cells)))
    fastest = [min(wall.values(), key=lambda it: it["threads"]) for wall in walls]
    rows.append(row("MB of the process", *(f"{it['memory']:.0f}" for it in fastest)))
    return table(["", *(f"{it['blocks']:,} blocks" for it in fastest)], rows)


def write(folder: Path, machine: str, results: list[dict]) -> None:
    """Write docs/benchmarks.md, docs/benchmarks.csv and docs/benchmarks.png."""
    engine = [
        result for result in results if "error" not in result and result["solver_asked"] == "auto"
    ]
    page = folder / "benchmarks.md"
    page.write_text(text(machine, results, others_of(page.read_text())))
    (folder / "benchmarks.csv").write_text(all_rows(engine))
    draw(results, folder / "benchmarks.png")


def others_of(page: str) -> str:
    """Return the section on other programs of a page, or ''."""
    section = re.search(r"(?ms)^## Other programs\n.*?(?=\n\n## )", page)
    return section[0] if section else ""


def write_rivals(file: Path, rows: dict[str, list[str]]) -> None:
    """Write the section on other programs from the rows of their tables."""
    parts = [OTHERS]
    for program, lines in rows.items():
        sentence, heads = AGAINST[program]
        heads = [*heads, "other/sitedda", "settlement", "asymmetry", "reaction"]
        parts.append(f"{sentence}\n\n{table(heads, lines)}")
    page, section = file.read_text(), "\n\n".join(parts)
    old = others_of(page)
    notes = NOTES.splitlines()[0]
    page = page.replace(old, section) if old else page.replace(notes, f"{section}\n\n{notes}")
    file.write_text(page)


def draw(results: list[dict], file: Path) -> None:
    """Draw step times of walls versus blocks, log-log."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    figure, panels = plt.subplots(1, 3, figsize=(12.0, 4.2), sharey=True, layout="constrained")
    for panel, phase in zip(panels, ("settling", "shaken", "quiet"), strict=True):
        for (step, threads), style in LOOKS.items():
            curve = sorted(
                (result["blocks"], 1e3 * result[phase]["mean"])
                for result in results
                if phase in result
                and result["model"].startswith("wall")
                and result["solver_asked"] == "auto"
                and (result["penalty"], result["time_step"]) == (100.0, step)
                and result["threads"] == threads
            )
            label = f"Δt {step:g} s, {threads} thread{'s' if threads > 1 else ''}"
            if curve:
                panel.loglog(*np.transpose(curve), style, label=label)
        for rival, style, label in RIVALS:
            curve = rivals(results, rival, phase)
            if curve:
                panel.loglog(*np.transpose(curve), style, label=f"{label}, Δt 0.001 s, 1 thread")
        panel.set(title=f"{phase} step of a wall, 100 E", xlabel="blocks")
        panel.grid(which="both", alpha=0.25)
    panels[0].set_ylabel("mean of a step, ms")
    handles = panels[2].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=3, fontsize=8)
    figure.savefig(file, dpi=110)


def rivals(results: list[dict], rival: str, phase: str) -> list[tuple[int, float]]:
    """Return blocks and milliseconds of SOR, or of the plain step."""
    walls = [result for result in results if "error" not in result and "wall" in result["model"]]
    if rival == "sor":
        runs = [result for result in walls if phase in result]
        selection = [result for result in runs if result["solver_asked"] == "sor"]
        return sorted((result["blocks"], 1e3 * result[phase]["step"]) for result in selection)
    selection = [result for result in walls if "plain" in result.get(phase, {})]
    return sorted((result["blocks"], 1e3 * result[phase]["plain"]) for result in selection)
