# SPDX-License-Identifier: GPL-3.0-or-later
"""Layout of pictures: texts neither overlap nor leave the figure, for models of random content."""

import re
from contextlib import suppress
from itertools import combinations

import pytest
from matplotlib.axes import Axes
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from random_content import random_model

import sitedda
from sitedda.facade.page import _TABLES, _add_model_section, _group_table
from sitedda.output.scene import Scene
from sitedda.plot import run_picture
from sitedda.report import Facts, Page
from sitedda.report.html import _table_html
from sitedda.style import new_figure

_TOUCH = 1.0  # allowed overlap of boxes of letters, pixels
_MODELS = 40
_VARIABLE = re.compile(r"[a-z]+_[a-z]+")  # such words do not occur in names of the models
_LOOKS = [{"color": color, "contacts": contacts, "arrows": arrows}
          for color in ("material", "displacement", "rotation", "compression", "velocity")
          for contacts in (None, "force", "chain", "slip", "opening")
          for arrows in (None, "displacement", "velocity")]  # fmt: skip


def overlaps(figure) -> list[str]:
    """Pairs of texts that share an area, and texts that leave the figure."""
    figure.draw_without_rendering()
    boxes = [(text.get_text().strip(), _box(text)) for text in _visible_texts(figure)]
    page = figure.bbox.padded(_TOUCH)
    messages = [f"{name!r} leaves the figure" for name, box in boxes
             if not (page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1))]  # fmt: skip
    for (name, one), (other_name, other) in combinations(boxes, 2):
        shared = Bbox.intersection(one, other)
        if shared and min(shared.width, shared.height) > _TOUCH:
            messages.append(f"{name!r} over {other_name!r}")
    return messages


def raw_words(figure) -> list[str]:
    """Labels of axes and colour bars without a unit, and texts that contain names of variables."""
    quantities = [label for axes in figure.findobj(Axes) for label in
                  (axes.get_xlabel(), axes.get_ylabel(),
                   axes.get_title(loc="left") if hasattr(axes, "_colorbar") else "")]  # fmt: skip
    unlabelled = [label for label in quantities if label and not re.search(r" ?\(.+\)$| / ", label)]
    texts = (text.get_text() for text in _visible_texts(figure))
    return list(dict.fromkeys([label for label in texts if _VARIABLE.search(label)] + unlabelled))


def _box(text: Text) -> Bbox:
    """Extent of a text in pixels, without blank lines at its end."""
    box = Text.get_window_extent(text)  # of a name beside a point without its line
    lines = text.get_text().split("\n")
    below = len(lines) - len(text.get_text().rstrip().split("\n"))
    return Bbox.from_extents(box.x0, box.y0 + below / len(lines) * box.height, box.x1, box.y1)


def _visible_texts(figure) -> list[Text]:
    """Texts that are drawn; axes also contain tick labels beyond their ends."""
    hidden: set[Text] = set()
    for axes in figure.findobj(Axes):
        for axis in (axes.xaxis, axes.yaxis):
            ticks = axis.get_major_ticks() + axis.get_minor_ticks()
            hidden |= {label for tick in ticks for label in (tick.label1, tick.label2)}
            if axes.get_visible() and axes.axison and axis.get_visible():
                ticks = axis._update_ticks()
                hidden -= {label for tick in ticks for label in (tick.label1, tick.label2)}
    return [text for text in figure.findobj(Text)
            if text.get_visible() and text.get_text().strip() and text not in hidden]  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> list:
    folder, outputs = tmp_path_factory.mktemp("layout"), []
    for seed in range(_MODELS):
        file = folder / f"model_{seed}.nml"
        file.write_text(random_model(seed), encoding="utf-8")
        with suppress(sitedda.ConvergenceError):  # some fail or do not come to rest
            outputs.append(sitedda.run(file, output=False))
    assert len(outputs) > 0.7 * _MODELS
    return outputs


def test_texts_of_pictures_neither_overlap_nor_leave_the_figure(runs):
    for seed, run in enumerate(runs):
        look = _LOOKS[seed * 7 % len(_LOOKS)]
        axes = run.draw(**look)
        for figure in (run_picture(run.history), axes.figure):
            assert overlaps(figure) == [], (seed, look)
            assert raw_words(figure) == [], (seed, look)
            texts = [text.get_text() for text in _visible_texts(figure)]
            assert not any("Pa…" in text for text in texts), (seed, look)
        for bar in (child._colorbar for child in axes.child_axes if hasattr(child, "_colorbar")):
            values = bar.mappable.get_array()  # none is beyond an end
            assert values is None or bar.vmin <= values.min() <= values.max() <= bar.vmax, seed


def test_tables_of_a_report_contain_words_and_wrap_lists(runs):
    shaken = 0
    for seed, run in enumerate(runs):
        scene = Scene.of(run)
        tables = {name: _group_table(scene, name, title) for name, title in _TABLES}
        heads = [head for table in tables.values() if table for head in table.heads]
        assert "name" in heads and not any("_" in head for head in heads), (seed, heads)
        if tables["motion"]:
            shaken += 1
            cells = re.findall("<td(.*?)>(.*?)</td>", _table_html(tables["motion"]))
            lists = [kind for kind, text in cells if text.count(", ") > 5]
            assert lists and not any("class='n'" in kind for kind in lists), seed
    assert shaken


def test_facts_of_a_report_count_blocks_as_pictures_do_and_have_no_raw_words(runs):
    for seed, run in enumerate(runs[:14]):  # a run or two of each kind that settles
        page = Page(str(seed))
        _add_model_section(page, scene := Scene.of(run))
        facts = dict(next(p for p in page.sections[0].parts if isinstance(p, Facts)).lines)
        assert facts["blocks"].startswith(scene.size_words)
        assert ("cells" in facts["blocks"]) is (scene.bodies < scene.blocks), seed
        assert not _VARIABLE.search(facts["boundaries"]), seed


def test_a_failed_layout_is_detected():
    figure, axes = new_figure(size=(3.0, 2.0))
    axes.set(xlabel="largest_tilt_rad", ylabel="displacement")
    for position in ((0.5, 0.5), (0.52, 0.5), (0.9, 0.9)):
        axes.annotate("a long name", position, annotation_clip=False).set_in_layout(False)
    assert len(overlaps(figure)) == 2 and "leaves the figure" in "".join(overlaps(figure))
    assert raw_words(figure) == ["largest_tilt_rad", "displacement"]
