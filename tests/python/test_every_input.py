"""Every file in inputs/ runs from the package and from the executable, with the same bits."""

import re
from pathlib import Path

import pytest
import sitedda

INPUTS = Path(__file__).parents[2] / "inputs"
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
    done = native("run", again, "--output", tmp_path / "native.nc", "--quiet")
    assert done.returncode == 0, done.stderr
    same_bits(tmp_path / "python.nc", tmp_path / "native.nc")
    assert result.summary in done.stdout


def shortening(file) -> dict:
    """A change that keeps a long input short; an input with few steps runs as it stands."""
    with sitedda.Simulation(file) as simulation:
        steps = round(simulation.duration / _time_step(file))
    return {"steps": LONGEST} if steps > LONGEST else {}


def _time_step(file) -> float:
    control = re.search(r"(?is)&control.*?\btime_step\s*=\s*([-+.\dedED]+)", file.read_text())
    return float(control[1].lower().replace("d", "e"))


def beside_its_records(file, folder, text) -> Path:
    """Write a text where the files that `file` names can be found under the same names."""
    folder.mkdir()
    for neighbour in file.parent.iterdir():
        if neighbour.suffix != ".nml":
            (folder / neighbour.name).symlink_to(neighbour)
    copy = folder / file.name
    copy.write_text(text)
    return copy
