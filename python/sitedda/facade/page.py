# SPDX-License-Identifier: GPL-3.0-or-later
"""Compose the report of a run, of a model before its run, and of a check."""

from pathlib import Path

import numpy as np

from ..base.errors import SiteddaError
from ..base.numbers import number
from ..drawing.pictures import draw
from ..drawing.view import BUDGET, view
from ..engine.checking import Report, check, check_table
from ..input.schema import GROUPS
from ..input.source import InputOfRun
from ..output.energies import TERMS
from ..output.scene import Scene
from ..output.verdict import verdict
from ..output.verdict_lines import NO_BARS, Doubt
from ..report.page import Bullets, Facts, Listing, Page, Paragraph, Part, Picture, Table
from ..report.provenance import provenance
from ..study.error_bars import stored_accuracy
from .plot import CAPTIONS, purpose_of, run_picture

_TABLES = (("material", "Materials"), ("joint", "Joints"), ("boundary", "Boundaries"),
           ("motion", "Motions"))  # fmt: skip
_PICTURES = 1_500_000  # bytes of the page budget for pictures; the view may use the remainder


def report_page(source, report: Report | None = None, discrete=None) -> Page:
    """Return the report of an output, or of an input before its run.

    Parameters
    ----------
    source : path, Run, Simulation, xarray.Dataset or Scene
    report : Report, optional
        Check of the model; by default, the input that was run is checked.
    discrete : ndarray, optional
        The model's own transfer function for the picture, see `plot.run_picture`.
    """
    scene = Scene.of(source)
    report = report if report is not None else _check_input(scene, source)
    return _page_of_model(scene, report) if scene.before else _page_of_run(scene, report, discrete)


def _page_of_run(scene: Scene, report: Report | str, discrete) -> Page:
    """Return the report of a run: verdict, view, pictures, model, check, energies, input."""
    data = scene.data
    page = Page(scene.title or "Untitled run", _first_paragraph(scene))
    page.add("Verdict", _findings_part(report), *_verdict_parts(scene))
    page.add("Blocks", view(scene, BUDGET - _PICTURES))
    subject = purpose_of(scene)
    page.add("Pictures", Picture(run_picture(subject, discrete), CAPTIONS[subject.kind], "run"))
    _add_model_section(page, scene)
    _add_check_section(page, report)
    _add_energy_section(page, data)
    _add_input_section(page, scene)
    program, commit = (str(data.attrs.get(name, "")) for name in ("source", "commit"))
    page.provenance = provenance(input=str(data.attrs.get("input_file", "")),
                                 computed_by=f"{program}, commit {commit}" if commit else program,
                                 step_control=str(data.attrs.get("step_control", "")),
                                 solver=str(data.attrs.get("solver", "")))  # fmt: skip
    return page


def _page_of_model(scene: Scene, report: Report | str) -> Page:
    """Return the report of a model before its run: check, view, model, input."""
    page = Page(scene.title or "Untitled model", "A model before its run.")
    _add_check_section(page, report)
    page.add("Blocks", view(scene, BUDGET - _PICTURES, "material"))
    _add_model_section(page, scene)
    _add_input_section(page, scene)
    page.provenance = provenance(input=str(scene.data.attrs.get("input_file", "")))
    return page


def _first_paragraph(scene: Scene) -> str:
    """Return the sizes of a run, and whether it failed or is incomplete, in one sentence."""
    complete = scene.data.attrs.get("complete", "yes") == "yes"
    text = f"{scene.size_words}, {scene.time[-1]:.4g} s, {scene.frames:,} frames of blocks"
    doubts = Doubt.lines(str(scene.data.attrs.get("doubts", "")))
    state = "failed" if any(doubt.topic == "failed" for doubt in doubts) else "is not complete"
    return text + ("." if complete else f"; the run {state}.")


def _check_input(scene: Scene, source) -> Report | str:
    """Return the check of the input that was run, or the error that prevents the check."""
    file = Path(str(scene.data.attrs.get("input_file", "") or source))
    text = str(scene.data.attrs.get("input_text", ""))
    try:
        return check(InputOfRun(file, text) if text else file)
    except SiteddaError as error:
        return str(error)


def _findings_part(report: Report | str) -> Part:
    """Return verdict and topics of the check of the model as a table."""
    if isinstance(report, str):
        return Paragraph(f"The input cannot be checked: {report}")
    verdict, _, topics = report.conclusion.removeprefix("verdict: ").partition(": ")
    return Table(["check of the model", "verdict"], [[topics.capitalize(), verdict]])


def _verdict_parts(scene: Scene) -> list[Part]:
    """Return the verdict, the results with error bars, the warnings and the counts."""
    bars = stored_accuracy(scene.data.attrs)
    result = verdict(scene, bars)
    heads, *rows = result.rows()
    parts: list[Part] = [Paragraph(result.happened)]
    if rows:
        parts.append(Table(heads, rows))
    if result.all_doubts:
        parts.append(Bullets(list(map(str, result.all_doubts)), "Doubts"))
    parts.append(Facts([("steps", result.steps)]))
    if bars is None:
        return [*parts, Paragraph(f"{NO_BARS[:1].upper()}{NO_BARS[1:]}.")]
    return [*parts, *bars_of(scene)]


def bars_of(scene: Scene) -> list[Part]:
    """Return a table of results with error bars, and bands over time, if stored."""
    bars = stored_accuracy(scene.data.attrs)
    if bars is None:
        return []
    heads, *rows = bars.rows()
    parts: list[Part] = [Table(heads, rows, "How accurate are the results?")]
    if bars.bands:
        caption = "Results of twins over time; a twin has one block displaced by 1e-9 of its size."
        parts.append(Picture(bars.draw(), caption, "bands"))
    return parts


def _add_check_section(page: Page, report: Report | str) -> None:
    """Add the section on the check of the model to a page."""
    if isinstance(report, str):
        page.add("Check", _findings_part(report))
    else:
        page.add("Check", Paragraph(report.conclusion.capitalize() + "."), check_table(report))


def _add_model_section(page: Page, scene: Scene) -> None:
    """Add the section on the model to a page: picture, counts, groups, slivers."""
    areas = scene.areas()
    vertices = np.diff(scene.first)
    kinds = [boundary["kind"] for boundary in scene.boundaries(0)]
    counts = [
        ("blocks", f"{scene.size_words} with {_range_words(vertices)} vertices"),
        ("areas", f"{_range_words(areas)} m², {number(areas.sum(), 6)} m² in total"),
        ("edges in contact", f"{len(scene.interfaces):,}"),
        ("fixed points", f"{len(scene.supports()):,}"),
        ("boundaries", ", ".join(kinds).replace("_", " ") or "none"),
        ("measured points", ", ".join(p["name"] for p in scene.points()) or "none"),
    ]
    parts: list[Part] = [
        Picture(
            draw(scene, time=float(scene.time[0]), color="material").figure,
            "The model at the start, to scale.",
            "model",
        ),
        Facts(counts),
    ]
    for name, title in _TABLES:
        table = _group_table(scene, name, title)
        parts += [table] if table else []
    slivers = scene.slivers()
    if len(slivers):
        lines = [f"{scene.names[b]}: {areas[b]:.3g} m²" for b in slivers[:50]]
        parts.append(Bullets(lines, "Slivers"))
    page.add("Model", *parts)


def _range_words(values) -> str:
    """Return the smallest and the largest value as text."""
    low, high = number(values.min()), number(values.max())
    return low if low == high else f"{low} to {high}"


def _group_table(scene: Scene, name: str, title: str) -> Table | None:
    """Tabulate the groups of a kind, with the variables that differ from their default."""
    groups = scene.groups.get(name, [])
    defaults = {variable.name: variable.default.partition(":")[0].strip("'")
                for variable in GROUPS[name].variables}  # fmt: skip
    variables = [pair for group in groups for pair in group.items()]
    changed_names = [k for k, v in variables if _shorten_value(v) != defaults.get(k)]
    heads = list(dict.fromkeys(changed_names))
    if not heads:
        return None
    variables = {variable.name: variable for variable in GROUPS[name].variables}
    space = {key: " " if variables[key].kind == "word" else "_" for key in heads}
    rows = [[_shorten_value(group.get(key, "")).replace("_", space[key]) for key in heads]
            for group in groups]  # fmt: skip
    units = {key: f" ({variables[key].unit})" if variables[key].unit else "" for key in heads}
    return Table([key.replace("_", " ") + units[key] for key in heads], rows, title)


def _shorten_value(value) -> str:
    """Format a value of the input in at most 80 characters."""
    if isinstance(value, bool):
        return f".{value}.".lower()
    if isinstance(value, float):
        return number(value, 6)
    text = ", ".join(map(_shorten_value, value)) if isinstance(value, list) else str(value)
    return text if len(text) <= 80 else text[:77] + "…"


def _add_energy_section(page: Page, data) -> None:
    """Add the section on energies to a page: audit, final and largest values."""
    rows = [
        [name.replace("_", " "), number(float(series[-1])), number(float(abs(series).max()))]
        for name in TERMS
        if f"energy_{name}" in data and np.any(series := data[f"energy_{name}"].values)
    ]
    if rows:
        heads = ["energy", "at the end (J/m)", "largest (J/m)"]
        audit = str(data.attrs.get("energy_audit", ""))
        page.add("Energies", Paragraph(f"Audit: {audit}."), Table(heads, rows))


def _add_input_section(page: Page, scene: Scene) -> None:
    """Add the section on the input to a page: text, records, compiler."""
    text = str(scene.data.attrs.get("input_text", ""))
    limit = 400_000
    if len(text) > limit:
        text = text[:limit] + f"\n… {len(text) - limit:,} more characters"
    parts = [Listing(text, "The input with its changes", folded=True)]
    motions = str(scene.data.attrs.get("motions", "")).strip()
    if motions:
        parts.append(Listing(motions, "Records and their processing", folded=True))
    compiler = str(scene.data.attrs.get("compiler", ""))
    if compiler:
        parts.append(Listing(compiler, "Compiler and its options", folded=True))
    page.add("Input", *parts)
