# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of the command line, and arguments of functions, have ranges."""

import pytest
from model_text import tower

import sitedda
from sitedda.arguments import Range

BAD = {
    "draw": {"--dpi": ["0", "-5", "nan", "inf", "1e9", "x"], "--time": ["nan", "inf"],
             "--deformation": ["nan", "inf"], "-o": ["x.xyz", "x", ""]},
    "movie": {"--fps": ["0", "-1", "nan", "inf"], "--seconds": ["inf", "-1", "0", "nan"],
              "--deformation": ["nan", "-inf"]},
    "safety": {"--factor": ["0", "-1", "nan", "inf"], "--tolerance": ["0", "nan", "1e-99", "2"],
               "--displacement": ["0", "-1", "nan"], "-o": ["a.xyz"]},
    "site": {"--damping": ["-1", "nan", "inf", "1.5"], "-o": ["a.xyz"]},
    "surface": {"--lowest": ["0", "nan", "-1"], "--highest": ["inf", "nan"], "-o": ["a.xyz"]},
    "record": {"--time-step": ["-1", "nan", "inf"], "-o": ["a.xyz"]},
    "study run": {"--workers": ["0", "-1", "1.5", "nan", "1e9"]},
    "validate": {"--report": [None]},
}  # fmt: skip


@pytest.mark.parametrize("command", BAD)
def test_a_number_beyond_its_range_is_refused_before_the_work(main, tmp_path, command):
    for option, values in BAD[command].items():
        for value in values:
            option_text = f"{option}={value}" if option[1] == "-" else f"{option}{value}"
            option_text = option if value is None else option_text if value else "--output="
            process = main(*command.split(), "none.nc", option_text, folder=tmp_path)
            assert process.returncode == 1, (option, value)
            (line,) = process.stderr.splitlines()
            assert option in line and f"{command} --help" in line, (option, value)


def test_unknown_names_are_reported_in_one_sentence(main):
    for command in (
        ["paper", "x"],
        ["validate", "x"],
        ["x"],
        [],
        ["study", "run"],
        ["draw", "--x"],
    ):
        process = main(*command)
        assert process.returncode == 1 and len(process.stderr.splitlines()) == 1, command


def test_numbers_in_range_are_accepted():
    assert Range(0.0, 1.0)("0") == 0.0
    assert Range(0.0, 1.0, above=True)("1") == 1.0
    assert Range(1, 5, whole=True)("5") == 5
    assert str(Range(0.0, 1.0, above=True)) == "a number above 0 to 1"


def test_functions_refuse_the_same_numbers(write_input, tmp_path):
    file = write_input(tower())
    with sitedda.Simulation(file) as simulation:
        for steps in (-1, 2**31):
            with pytest.raises(sitedda.InputError, match="steps"):
                simulation.advance(steps)
        assert simulation.advance(0) is False and simulation.steps == 0
        with pytest.raises(sitedda.InputError, match="deformation = nan"):
            sitedda.draw(simulation, deformation=float("nan"))
    from sitedda.movie import animate, write_movie

    for options in ({"fps": 0}, {"fps": float("nan")}, {"seconds": float("inf")}, {"seconds": -1}):
        with pytest.raises(sitedda.InputError, match=next(iter(options))):
            write_movie(file, tmp_path / "a.gif", **options)
        with pytest.raises(sitedda.InputError, match=next(iter(options))):
            animate(file, **options)
    with pytest.raises(sitedda.InputError, match="tolerance"):
        sitedda.safety(file, tolerance=1e-99)
