# SPDX-License-Identifier: GPL-3.0-or-later
"""An output file alone is enough to repeat its run."""

import importlib.metadata
import re
import shutil

import numpy as np
import pytest
from model_text import changed, group, tower

import sitedda
from sitedda import engine
from sitedda.report import provenance

RECORD = "inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc"


def shaken_by_a_record(**control) -> list:
    return changed(changed(tower(steps=300), "control", **control), "motion", values=None,
                   time_step=None, file="record.smc", unit="cm/s2")  # fmt: skip


@pytest.fixture
def first_run(write_input, root, tmp_path):
    shutil.copy(root / RECORD, tmp_path / "record.smc")

    def run(**changes):
        return sitedda.run(write_input(shaken_by_a_record()), **changes).history

    return run


def repeated(history, write_input):
    return sitedda.run(write_input(history.attrs["input_text"].encode(), "again.nml")).history


def test_the_text_of_the_input_is_stored_exactly(write_input):
    text = "! Größe α, \t tabs and 'quotes'\r\n" + "\n" * 3
    file = write_input(text.encode() + write_input(tower(steps=2)).read_bytes() + b"! the end\n\n")
    stored_text = sitedda.run(file).history.attrs["input_text"]
    assert stored_text.encode() == file.read_bytes()


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"time_step": 5e-4},
        {"time_step": 1 / 3000, "gravity": [0.1, -9.81], "title": "It's 'quoted'"},
        {"contact": {"shear_ratio": 3.0}, "material": {"density": 1e3 / 3}},
        {"time_step_control": "adaptive", "max_displacement_ratio": 1e-5},
    ],
    ids=str,
)
def test_the_stored_input_is_bit_identical(first_run, write_input, same_bits, changes):
    history = first_run(**changes)
    same_bits(history, repeated(history, write_input))


def test_the_executable_repeats_a_run_of_the_package(
    first_run, write_input, binary, same_bits, tmp_path
):
    history = first_run(time_step=1 / 700)
    copied_input = write_input(history.attrs["input_text"].encode(), "again.nml")
    binary.ok("run", copied_input, "-q", "-o", tmp_path / "again.nc")
    same_bits(history, tmp_path / "again.nc")


def test_a_long_input_is_stored_completely(write_input, same_bits):
    comment = b"! " + b"long " * 60_000 + b"\n"
    plain = write_input(tower(steps=3)).read_bytes()
    history = sitedda.run(write_input(comment + plain)).history
    assert len(history.attrs["input_text"]) > 300_000
    same_bits(history, repeated(history, write_input))


def test_the_output_names_program_and_version(first_run, tmp_path):
    attributes = first_run().attrs
    assert attributes["source"] == f"sitedda {importlib.metadata.version('sitedda')}"
    assert re.search(r"GCC|Fortran|ifx", attributes["compiler"])
    assert attributes["input_file"] == str(tmp_path / "model.nml")
    assert attributes["complete"] == "yes"
    assert "300 steps" in attributes["step_control"]


def test_the_output_names_the_record_and_its_processing(first_run):
    description = first_run().attrs["motions"]
    for phrase in ("pulse", "record.smc", "7183 samples of acceleration", "0.005 s", "drift"):
        assert phrase in description


def test_a_run_with_no_motion_names_none(write_input):
    groups = [
        group("control", time_step=1e-3, steps=2),
        *[pair for pair in tower() if pair[0] in ("material", "joint", "layers")],
    ]
    history = sitedda.run(write_input(groups)).history
    assert history.attrs["motions"] == ""
    assert np.all(history.block_rates == 0.0)


def test_output_and_report_name_the_commit_of_the_engine(first_run):
    assert first_run().attrs["commit"] == engine.commit()
    assert dict(provenance()).get("commit", "") == engine.commit()


def test_provenance_names_the_program_once():
    """This includes the page of a study, whose table has no commit."""
    program = f"sitedda {sitedda.__version__}"
    names = [name for name, value in provenance(computed_by=program) if value == program]
    assert names == ["computed by"]
