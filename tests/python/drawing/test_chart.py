# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a level site, which the program draws without matplotlib."""

from itertools import combinations

import numpy as np
import pytest
from PIL import Image

import sitedda
from sitedda.facade.purpose import shown
from sitedda.facade.site_chart import site_chart
from sitedda.report.chart import Chart, _dashed, _thinned, _ticks
from sitedda.report.words import font_of

_TOUCH = 0.01  # inches that boxes of letters may share


def boxes(chart: Chart) -> list[tuple]:
    """Words and box (left, low, right, high; inches) of each text."""
    found = []
    for x, y, words, size, _, across, bold, upright in chart.texts:
        lines = words.split("\n")
        wide = max(font_of(10 * size, bold).getlength(line) for line in lines) / 720
        tall, more = 0.75 * size / 72, (len(lines) - 1) * 1.25 * size / 72
        if upright:
            box = (x - tall - more, y - wide / 2, x, y + wide / 2)
        else:
            left = x - {"l": 0.0, "m": 0.5, "r": 1.0}[across] * wide
            box = (left, y - more, left + wide, y + tall)
        if words:
            found.append((words, *box))
    return found


@pytest.mark.parametrize("name", ["surface", "a measured point of the surface with a long name"])
def test_no_text_of_a_site_is_over_another_or_outside(name, root, tmp_path):
    text = (root / "inputs/layered_site.nml").read_text(encoding="utf-8")
    text = text.replace("'surface'", f"'{name}'").replace("'records/", f"'{root}/inputs/records/")
    file = tmp_path / "site.nml"
    file.write_text(text.replace("Layered site", 12 * "Layered site "), encoding="utf-8")
    chart = site_chart(shown(sitedda.run(file, output=False, steps=3000).history))
    chart.save(tmp_path / "site.png")
    texts = boxes(chart)
    assert {"depth (m)", "time (s)", "period (s)", "frequency (Hz)", "this run",
            "shear-wave velocity (m/s), grey"} <= {words for words, *_ in texts}  # fmt: skip
    for words, left, low, right, high in texts:
        assert left >= 0 and low >= 0 and right <= 11 and high <= 7.6, words
    for one, other in combinations(texts, 2):
        across = min(one[3], other[3]) - max(one[1], other[1])
        up = min(one[4], other[4]) - max(one[2], other[2])
        assert min(across, up) <= _TOUCH, (one, other)


def test_a_panel_draws_where_its_limits_say(tmp_path):
    chart = Chart((4.0, 3.0), dpi=100)
    panel = chart.add_panel(1.0, 2.0)
    panel.place(1.0, 1.5)
    panel.plot([0.0, 10.0], [5.0, 5.0], color="#ff0000", lw=4.0)
    panel.set(xlim=(0, 10), ylim=(0, 10))
    pixels = np.asarray(Image.open(chart.save(tmp_path / "line.png"))).astype(int)
    red = np.argwhere((pixels[..., 0] > 200) & (pixels[..., 1] < 60))
    assert abs(red.min(0) - [300 - 178, 100]).max() <= 3
    assert abs(red.max(0) - [300 - 172, 300]).max() <= 3


def test_ticks_are_round_and_labelled_by_their_step():
    values, labels = _ticks([0.0, 1.13], 2.0, "x")
    assert labels == ["0.0", "0.5", "1.0"] and values == pytest.approx([0.0, 0.5, 1.0])
    assert _ticks([-2.4, 2.4], 1.0, "y")[1] == ["−2", "0", "2"]
    assert _ticks([15.0, 0.0], 2.7, "y")[1][-1] == "14"  # downwards
    assert _ticks([0.0, 2.3e6], 2.0, "x")[1][1] == "1e+06"


def test_a_thinned_line_keeps_the_extremes():
    x = np.linspace(0.0, 2.0, 50_000)
    y = np.sin(400 * x) * np.exp(-x)
    thin = _thinned(np.column_stack([x, y]), 100)
    assert len(thin) < 1000
    assert thin[:, 1].max() == y.max() and thin[:, 1].min() == y.min()
    rising = _thinned(np.column_stack([x, x]), 100)
    assert np.all(np.diff(rising[:, 1]) >= 0)  # no step back, which would close the gaps of dashes


def test_dashes_have_their_length_and_follow_the_line():
    corner = np.array([[0.0, 0.0], [7.0, 0.0], [7.0, 10.0]])
    dashes = _dashed(corner, "--", 1.0)
    lengths = [np.hypot(*np.diff(one, axis=0).T).sum() for one in dashes]
    assert lengths[:-1] == pytest.approx([3.7] * (len(dashes) - 1))
    assert any((one == [7.0, 0.0]).all(1).any() for one in dashes)  # around the corner
    assert len(_dashed(corner, "-", 1.0)) == 1


def test_the_program_draws_a_site_without_matplotlib(python_program, root, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPROFILEIMPORTTIME", "1")
    words = ("run", root / "inputs/layered_site.nml", "--set", "steps=2000", "-o", "a.nc")
    done = python_program.ok(*words, folder=tmp_path)
    assert (tmp_path / "a.png").stat().st_size > 20_000
    assert "sitedda.report.chart" in done.stderr
    for name in ("matplotlib", "xarray", "pandas", "scipy", "shapely"):
        assert f" {name}\n" not in done.stderr, name
