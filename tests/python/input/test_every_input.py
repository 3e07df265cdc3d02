# SPDX-License-Identifier: GPL-3.0-or-later
"""Every file in inputs/ runs from the package and from the executable, with identical bits."""

import re
from pathlib import Path

import pytest

import sitedda
from sitedda.output.output_file import read_output
from sitedda.plot import run_picture
from sitedda.verdict import verdict

pytestmark = pytest.mark.slow

INPUTS = Path(__file__).parents[3] / "inputs"
LONGEST = 1500  # steps of an input run here


def test_there_are_inputs():
    assert {"layered_site.nml", "layered_site_table2.nml"} <= {f.name for f in INPUTS.iterdir()}


@pytest.mark.parametrize(
    "file", sorted(INPUTS.rglob("*.nml")), ids=lambda file: str(file.relative_to(INPUTS))
)
def test_input_gives_the_same_bits_from_both(file, tmp_path, native, same_bits):
    result = sitedda.run(file, tmp_path / "python.nc", **shortening(file))
    assert result.complete
    again = beside_its_records(file, tmp_path / "again", result.history.attrs["input_text"])
    done = native.ok("run", again, "--output", tmp_path / "native.nc", "--quiet")
    same_bits(tmp_path / "python.nc", tmp_path / "native.nc")
    assert result.summary in " ".join(done.stdout.split())
    as_the_program_reads_it(tmp_path / "python.nc", result.history)


def as_the_program_reads_it(file, history):
    """What `sitedda run` reads, says and draws without xarray is the same."""
    output = read_output(file)
    assert output.variables.keys() == history.variables.keys()
    assert str(verdict(output)) == str(verdict(history))
    figures = [run_picture(data) for data in (output, history)]
    assert pixels(figures[0]) == pixels(figures[1])


def pixels(figure) -> bytes:
    figure.set(dpi=40, layout_engine="none")
    figure.canvas.draw()
    return bytes(figure.canvas.buffer_rgba())


def shortening(file) -> dict:
    """A change that keeps a long input short; an input with few steps runs as it stands."""
    with sitedda.Simulation(file) as simulation:
        steps = round(simulation.duration / _time_step(file))
    return {"steps": LONGEST} if steps > LONGEST else {}


def _time_step(file) -> float:
    control = re.search(r"(?is)&control.*?\btime_step\s*=\s*([-+.\dedED]+)", file.read_text())
    return float(control[1].lower().replace("d", "e"))


def beside_its_records(file, folder, text) -> Path:
    """Write a text into a copy of inputs/ whose other files are links."""
    for other in INPUTS.rglob("*"):
        if other.is_file() and other.suffix != ".nml":
            link = folder / other.relative_to(INPUTS)
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(other)
    copy = folder / file.relative_to(INPUTS)
    copy.parent.mkdir(parents=True, exist_ok=True)
    copy.write_text(text)
    return copy
