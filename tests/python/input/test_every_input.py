# SPDX-License-Identifier: GPL-3.0-or-later
"""Each file in inputs/ runs bit-identically in the package and in the executable."""

import re
from pathlib import Path

import pytest

import sitedda
from sitedda.output.output_file import read_output
from sitedda.plot import run_picture
from sitedda.verdict import verdict

pytestmark = pytest.mark.slow

INPUTS = Path(__file__).parents[3] / "inputs"
LONGEST = 1500  # largest number of steps of an input in this test


def test_there_are_inputs():
    assert {"layered_site.nml", "layered_site_table2.nml"} <= {f.name for f in INPUTS.iterdir()}


@pytest.mark.parametrize(
    "file", sorted(INPUTS.rglob("*.nml")), ids=lambda file: str(file.relative_to(INPUTS))
)
def test_an_input_is_bit_identical_in_both_programs(file, tmp_path, binary, same_bits):
    result = sitedda.run(file, tmp_path / "python.nc", **shortening(file))
    assert result.complete
    copied_input = beside_its_records(file, tmp_path / "again", result.history.attrs["input_text"])
    process = binary.ok("run", copied_input, "--output", tmp_path / "native.nc", "--quiet")
    same_bits(tmp_path / "python.nc", tmp_path / "native.nc")
    assert result.summary in " ".join(process.stdout.split())
    as_the_program_reads_it(tmp_path / "python.nc", result.history)


def as_the_program_reads_it(file, history):
    """Check that reader, verdict and picture without xarray equal those with xarray."""
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
    """Return a change that limits the steps of a long input; {} for a short one."""
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
