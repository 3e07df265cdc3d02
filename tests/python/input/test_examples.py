# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda example` copies inputs and studies that run in their new folder."""

import pytest

import sitedda
from sitedda.examples import copy_example, examples
from sitedda.study.settings import read_settings

STUDIES = [name for name in examples() if name.startswith("studies/")]
INPUTS = [name for name in examples() if name not in STUDIES]


def test_all_inputs_and_studies_are_listed_with_a_sentence(main, root):
    assert set(INPUTS) == {file.stem for file in (root / "inputs").glob("*.nml")}
    study_names = {f"studies/{file.stem}" for file in (root / "inputs" / "studies").glob("*.toml")}
    assert set(STUDIES) == study_names
    assert all(20 < len(sentence) < 200 for sentence in examples().values())
    assert not [sentence for sentence in examples().values() if sentence.startswith("Then")]
    assert "et al. (2013)" in examples()["layered_site"]
    process = main.ok("example")
    assert [line.split()[0] for line in process.stdout.splitlines()] == INPUTS + STUDIES


@pytest.mark.parametrize("name", INPUTS)
def test_an_example_has_all_its_files(name, tmp_path):
    copied_files = copy_example(name, tmp_path)
    assert copied_files[0] == tmp_path / f"{name}.nml"
    sitedda.Simulation(copied_files[0]).close()


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_is_copied_with_its_model(main, name, tmp_path):
    process = main("example", name, folder=tmp_path)
    assert process.returncode == 0 and f"sitedda study {name}.toml" in process.stdout
    plan = read_settings(tmp_path / f"{name}.toml").plan
    sitedda.Simulation(plan.model).close()


def test_the_copy_is_the_input_and_its_record(main, root, tmp_path):
    process = main("example", "layered_site", folder=tmp_path)
    assert process.returncode == 0 and "sitedda run layered_site.nml" in process.stdout
    files = {file.relative_to(tmp_path) for file in tmp_path.rglob("*") if file.is_file()}
    record = "records/LomaPrieta1989_USGS1002_APEEL2_133.smc"
    assert {str(file) for file in files} == {"layered_site.nml", record}
    for file in files:
        assert (tmp_path / file).read_bytes() == (root / "inputs" / file).read_bytes()


def test_a_file_of_the_user_is_not_changed(main, tmp_path):
    (tmp_path / "slope.nml").write_text("mine")
    process = main("example", "slope", folder=tmp_path)
    assert process.returncode == 5 and "slope.nml exists" in process.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["slope.nml"]
    assert (tmp_path / "slope.nml").read_text() == "mine"
    main.ok("example", "wall", folder=tmp_path)
    main.ok("example", "wall", folder=tmp_path)  # the same content


def test_an_unknown_example_is_refused_with_the_nearest_name(main):
    process = main("example", "layered_sit")
    assert process.returncode == 1 and "did you mean 'layered_site'?" in process.stderr
