# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda record`: reads records in text, names missing options, and overwrites nothing."""

import math
import sys

import numpy as np
import pytest

import sitedda

STEP, SAMPLES, LARGEST = 0.01, 400, 2.0


@pytest.fixture
def pulse() -> np.ndarray:
    """Acceleration, m/s²: a sine of 2 Hz."""
    return LARGEST * np.sin(2 * np.pi * 2.0 * STEP * np.arange(SAMPLES))


@pytest.fixture
def table(pulse, tmp_path):
    """Return a writer of a file of times and accelerations under a heading."""

    def write(heading: str, separator: str = ","):
        rows = "".join(f"{i * STEP:.2f}{separator}{a:.9g}\n" for i, a in enumerate(pulse))
        file = tmp_path / "own.csv"
        file.write_text(f"{heading}\n{rows}" if heading else rows)
        return file

    return write


@pytest.mark.parametrize(
    ("heading", "separator"),
    [("time,acc", ","), ("Time (s), Acceleration (m/s2)", ", "), ("t\ta", "\t"), ("", ","),
     ('"time","a"', ","), ("# a comment\ntime  acc", "  ")],
)  # fmt: skip
def test_columns_may_have_headings(table, pulse, heading, separator):
    motion = sitedda.read_record(table(heading, separator), unit="m/s2", drift_order=0)
    assert motion.acceleration.values == pytest.approx(pulse, abs=1e-7)
    assert float(motion.time[1]) == pytest.approx(STEP)


@pytest.mark.parametrize("heading", ["three,names,here", "1,acc", "time,acc\nanother,line", "nan"])
def test_invalid_headings_are_refused(table, heading):
    with pytest.raises(sitedda.InputError, match="line 1: the format is not recognised; name one"):
        sitedda.read_record(table(heading), unit="m/s2")


@pytest.mark.parametrize(
    ("text", "option"),
    [("0 0\n0.1 1\n0.2 0\n", "try --unit"), ("once\nthere was none\n", "--format")],
)
def test_a_message_names_the_option_to_use(main, tmp_path, text, option):
    (tmp_path / "own.txt").write_text(text)
    process = main("record", "own.txt", folder=tmp_path)
    assert process.returncode == 1 and option in process.stderr and process.stderr.count("\n") == 1


def test_one_column_requires_a_time_step(main, tmp_path):
    (tmp_path / "own.txt").write_text("0\n1\n0\n")
    command = ("record", "own.txt", "--unit", "g", "--format", "text")
    assert "--time-step" in main(*command, folder=tmp_path).stderr
    process = main(*command, "--time-step", "0.01", folder=tmp_path)
    assert process.returncode == 0 and "3 samples, 0.020 s" in process.stdout


def test_measures_are_printed_and_nothing_is_overwritten_unasked(main, table, monkeypatch):
    file = table("time,acc")
    command = ("record", file, "--unit", "m/s2")
    process = main.ok(*command, folder=file.parent)
    arias = math.pi / (2 * 9.80665) * LARGEST**2 / 2 * STEP * SAMPLES  # of a sine, whole periods
    measures = next(line for line in process.stdout.splitlines() if "Arias" in line)
    printed_text = float(measures.split("Arias ")[1].split()[0])
    assert printed_text == pytest.approx(arias, rel=0.02)  # the drift is removed
    picture = file.parent / "own.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    another = b"\x89PNG\r\n\x1a\nanother"
    picture.write_bytes(another)
    second_process = main(*command, folder=file.parent)
    assert second_process.returncode == 5 and "--force" in second_process.stderr
    assert picture.read_bytes() == another
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    for answer, is_kept in (("n", True), ("y", False)):
        monkeypatch.setattr("builtins.input", lambda _, answer=answer: answer)
        assert main(*command, folder=file.parent).returncode == (5 if is_kept else 0)
        assert (picture.read_bytes() == another) is is_kept


def test_help_lists_the_formats(main):
    output = " ".join(main("record", "--help").stdout.split())
    for name in ("smc", "at2", "knet", "esm", "cosmos", "text", "obspy"):
        assert f"'{name}'" in output


def test_a_missing_library_is_reported_in_one_sentence(main, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "obspy", None)  # as if it were not installed
    (tmp_path / "a.mseed").write_bytes(b"0")
    process = main("record", "a.mseed", "--format", "obspy", folder=tmp_path)
    expected = "sitedda: format 'obspy' needs this library: pip install obspy"
    assert (process.returncode, process.stderr.splitlines()) == (1, [expected])
