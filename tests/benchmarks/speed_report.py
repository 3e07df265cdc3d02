# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of the speed benchmark as tables and as a picture."""

from pathlib import Path

STATES = ("quiet", "sudden", "settling", "shaken")
STATES_NOTE = """*Quiet*: settled, nothing changes.  *Sudden*: the first ten steps after gravity has
come on a wall that touches everywhere and carries nothing.  *Settling*: the next fifty of these.
*Shaken*: settled, then shaken by a tenth of g (a stack by three quarters).  99 % of the steps take
no longer than the time of that name; of fewer than a hundred steps it is near the worst.  Counts
are means of a step.

"""
HEAD = """# Speed

`python tests/benchmarks/speed.py --docs` writes this page and [all tables](benchmarks_full.md)."""
SUMMARY = """A step costs one to two microseconds a block while no contact changes its state, and
up to sixty times that while many do: changes mean another open–close iteration, many of them
another factor. Milliseconds a step (means; Δt 1 ms, penalty 100 E) of a running-bond wall, on
one thread and on two, the dearest first:"""
MEANING = """*Sudden* are the first ten steps after gravity has come on a wall that touches
everywhere and carries nothing, *settling* the next fifty; who needs the rest alone starts from it
([a start at rest](method.md#a-start-at-rest)). *Shaken* is by a tenth of g, *quiet* is settled.

![Cost of a step against the number of blocks](benchmarks.png)"""
AGAINST_PLAIN = """Against the same step in numpy and scipy (`tests/benchmarks/plain_step.py`),
which begins with the contacts that the engine has found and keeps its factor while no spring
changes; it has no line search and is given up after 25 open–close iterations.  Places differ by so
much of the largest move (– where no plain iteration converged):

"""
NOTES = """## Choices behind these numbers

- Springs that contacts put in or take out are taken up by a low-rank update of the lagged factor
  (`low_rank.f90`), up to 160 of them; beyond that, or when its age has cost eight iterations, the
  factor is made anew. A correction costs a small part of a factor and leaves solves as short.
- The factor is kept in panels of 8 rows and 6 columns (`packed_panels.f90`), read upwards through
  memory in the first half of a solve and downwards in the second: one stream for the processor to
  fetch ahead.
- Blocks of K̂ that are zero, as of open joints between bricks, are left out when a factor is
  planned (`cholesky.f90.in`): in a wall of 100,000 bricks with open head joints that leaves .56 of
  the entries and .39 of the operations. It is planned anew when such a joint has closed.
- Solves before the last of a step stop at a hundredth of their first residual; the last one is
  finished to 1e-11 before convergence is accepted.
- SSOR is not offered as preconditioner.  Prototypes (1,000 bricks, 100 E, 1e-5 s) took 8 iterations
  in place of 15, 0.69 ms in place of 0.77 ms on one thread, but 0.60 ms in place of 0.42 ms on two;
  at 10,000 bricks 11.6 ms in place of 13 ms, and 7.9 ms in place of 5.9 ms.  Where block Jacobi
  needs many iterations, the lagged factor is several times faster than both.
- Residuals are measured by the loads whose balance a right side is: at rest they all but cancel.
- The engine's own factor of 6×6 blocks was measured against CHOLMOD's supernodal one before it was
  kept: 2.7 to 5.8 times as fast on walls of 1,000 and 10,000 bricks, on one thread.
- Walls of 100,000 blocks are measured in quiet steps only.
- Short loops do not open a parallel region: even with one thread that costs a microsecond.
"""
GROWTH = ("wall 1000", "wall 10000", "wall 100000")
LOOKS = {(1e-3, 1): "C0o-", (1e-3, 2): "C1s-", (1e-5, 1): "C2o--", (1e-5, 2): "C3s--"}
RIVALS = (("sor", "C4x:", "engine with SOR"), ("plain", "C5^:", "numpy and scipy"))
PHASES = ("search", "detect", "assemble", "factorise", "solve", "iterate", "update")


def text(machine: str, results: list[dict]) -> str:
    """All tables in Markdown."""
    good = [result for result in results if "error" not in result]
    engine = [result for result in good if result["solver_asked"] == "auto"]
    parts = [steps_table(engine), phases_table(engine), rivals_table(engine), sor_table(good)]
    parts.append(growth_line(engine))
    parts.append(disturbances(good))
    failed = [f"- {name(result)}: {result['error']}" for result in results if "error" in result]
    if failed:
        parts.append("Not measured:\n\n" + "\n".join(failed))
    return "\n\n".join(part for part in [f"Machine: {machine}.", *parts] if part)


def disturbances(results: list[dict]) -> str:
    """Cases whose threads had to share the processors with other programs."""
    lines = [f"- {name(result)}: {note}" for result in results for note in result["disturbed"]]
    head = "Cases in which threads had to share the processors with other programs:\n\n"
    return head + "\n".join(lines) if lines else ""


def name(result: dict) -> str:
    """Model, penalty, time step."""
    return f"{result['model']}, {result['penalty']:g} E, {result['time_step']:g} s"


def row(*cells) -> str:
    """A row of a Markdown table."""
    return "| " + " | ".join(map(str, cells)) + " |"


def table(heads: list[str], rows: list[str]) -> str:
    """A Markdown table."""
    return "\n".join([row(*heads), row(*["---"] * len(heads)), *rows])


def measured(result: dict) -> list[str]:
    """The states that were."""
    return [state for state in STATES if state in result]


def digits(value: float) -> str:
    """Three of them."""
    return f"{float(f'{value:.3g}'):,g}"


def steps_table(results: list[dict]) -> str:
    """Time of a step in each state."""
    rows = []
    for result in results:
        for state in measured(result):
            it = result[state]
            times = [digits(1e3 * it[each]) for each in ("step", "mean", "late", "worst")]
            counts = [it["counts"][each] for each in ("iterations", "factors", "solver_iterations")]
            rows.append(
                row(name(result), result["blocks"], result["threads"], state, it["steps"], *times,
                    f"{counts[0]:.1f}", f"{counts[1]:.2f}", f"{counts[2]:.0f}",
                    result["solver"], f"{result['memory']:.0f}")
            )  # fmt: skip
    heads = ["model, penalty, time step", "blocks", "threads", "state", "steps", "median, ms",
             "mean", "99 %", "worst", "open–close iterations", "factors", "solver iterations",
             "solver", "MB"]  # fmt: skip
    return STATES_NOTE + table(heads, rows)


def phases_table(results: list[dict]) -> str:
    """Milliseconds of each phase."""
    rows = []
    for result in results:
        for phase in measured(result):
            spent = [f"{1e3 * result[phase]['phases'][each]:.3g}" for each in PHASES]
            rows.append(row(name(result), result["threads"], phase, *spent))
    return "Milliseconds a step by phases (means):\n\n" + table(
        ["model, penalty, time step", "threads", "state", *PHASES], rows
    )


def rivals_table(results: list[dict]) -> str:
    """The engine against the plain step, one thread."""
    rows = []
    for result in results:
        for phase in measured(result):
            it = result[phase]
            if "plain" in it:
                rows.append(
                    row(name(result), phase, f"{1e3 * it['own']:.3g}", f"{1e3 * it['plain']:.3g}",
                        f"{it['plain_iterations']:.0f}", f"{it['plain'] / it['own']:.0f}",
                        "–" if it["difference"] is None else f"{it['difference']:.0e}")
                )  # fmt: skip
    if not rows:
        return ""
    heads = ["model, penalty, time step", "state", "engine, ms", "numpy + scipy, ms",
             "its iterations", "times", "differ by"]  # fmt: skip
    return AGAINST_PLAIN + table(heads, rows)


def sor_table(results: list[dict]) -> str:
    """The engine's solve against SOR, one thread, quiet."""
    rows = []
    for other in results:
        if other["solver_asked"] != "sor":
            continue
        for result in results:
            if (name(result), result["threads"]) != (name(other), 1):
                continue
            if result["solver_asked"] == "auto":
                own, theirs = solve_time(result), solve_time(other)
                sweeps = other["quiet"]["counts"]["solver_iterations"]
                rows.append(row(name(result), f"{1e3 * own:.3g}", f"{1e3 * theirs:.3g}",
                                f"{theirs / own:.0f}", f"{sweeps:.0f}"))  # fmt: skip
    if not rows:
        return ""
    heads = ["model, penalty, time step", "solve, ms", "SOR, ms", "times", "sweeps"]
    return "One solve of a quiet step against SOR:\n\n" + table(heads, rows)


def solve_time(result: dict) -> float:
    """Seconds of one solve of the quiet phase, the factor included."""
    quiet = result["quiet"]
    spent = quiet["phases"]["solve"] + quiet["phases"]["factorise"]
    return spent / quiet["counts"]["solves"]


def growth_line(results: list[dict]) -> str:
    """How the cost of a step grows with the number of blocks."""
    from math import log

    lines = []
    for state, threads in ((state, threads) for state in STATES for threads in (1, 2)):
        times = sorted(
            (result["blocks"], result[state]["mean"])
            for result in results
            if (result["penalty"], result["time_step"], result["threads"]) == (100.0, 1e-3, threads)
            and result["model"] in GROWTH and state in result
        )  # fmt: skip
        if len(times) < 2:
            continue
        (n, few), (m, many) = times[0], times[-1]
        power = log(many / few) / log(m / n)
        lines.append(row(state, threads, f"{n:,}", f"{m:,}", f"{power:.2f}"))
    if not lines:
        return ""
    heads = ["state", "threads", "from blocks", "to", "exponent"]
    return "Growth of the mean cost of a step with the blocks of a wall:\n\n" + table(heads, lines)


def summary_table(results: list[dict]) -> str:
    """Mean time of a step of a wall, the dearest state first, and memory."""
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
    least = [min(wall.values(), key=lambda it: it["threads"]) for wall in walls]
    rows.append(row("MB of the process", *(f"{it['memory']:.0f}" for it in least)))
    return table(["", *(f"{it['blocks']:,} blocks" for it in least)], rows)


def write(folder: Path, machine: str, results: list[dict]) -> None:
    """docs/benchmarks.md, docs/benchmarks_full.md and docs/benchmarks.png."""
    engine = [it for it in results if "error" not in it and it["solver_asked"] == "auto"]
    short = [HEAD, f"Machine: {machine}.", SUMMARY, summary_table(engine), MEANING]
    short += [growth_line(engine), rivals_table(engine), NOTES]
    (folder / "benchmarks.md").write_text("\n\n".join(part for part in short if part))
    head = "# Speed: all tables\n\n`python tests/benchmarks/speed.py --docs` writes this page.\n\n"
    (folder / "benchmarks_full.md").write_text(head + text(machine, results) + "\n")
    draw(results, folder / "benchmarks.png")


def draw(results: list[dict], file: Path) -> None:
    """Cost of a step of walls against blocks, log-log."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    figure, panels = plt.subplots(1, 3, figsize=(12.0, 4.2), sharey=True, layout="constrained")
    for panel, phase in zip(panels, ("settling", "shaken", "quiet"), strict=True):
        for (step, threads), look in LOOKS.items():
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
                panel.loglog(*np.transpose(curve), look, label=label)
        for other, look, label in RIVALS:
            curve = rivals(results, other, phase)
            if curve:
                panel.loglog(*np.transpose(curve), look, label=f"{label}, Δt 0.001 s, 1 thread")
        panel.set(title=f"{phase} step of a wall, 100 E", xlabel="blocks")
        panel.grid(which="both", alpha=0.25)
    panels[0].set_ylabel("mean of a step, ms")
    handles = panels[2].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=3, fontsize=8)
    figure.savefig(file, dpi=110)


def rivals(results: list[dict], which: str, phase: str) -> list[tuple[int, float]]:
    """Blocks and milliseconds of SOR, or of the plain step."""
    walls = [result for result in results if "error" not in result and "wall" in result["model"]]
    if which == "sor":
        chosen = [result for result in walls if result["solver_asked"] == "sor" and phase in result]
        return sorted((result["blocks"], 1e3 * result[phase]["step"]) for result in chosen)
    chosen = [result for result in walls if "plain" in result.get(phase, {})]
    return sorted((result["blocks"], 1e3 * result[phase]["plain"]) for result in chosen)
