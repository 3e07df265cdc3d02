# SPDX-License-Identifier: GPL-3.0-or-later
"""Version, metadata, recipes and the paper of a release are consistent."""

import json
import re
import runpy
import subprocess
import sys
import tomllib

import pytest
from environment import captured, executable

import sitedda

EXACT = {
    "CITATION.cff": r"^version: (.+)$",
    "codemeta.json": r'"version": "(.+)"',
    ".zenodo.json": r'"version": "(.+)"',
    "meson.build": r"version: '(.+)'",
    "CHANGELOG.md": r"^## \[(\d.+?)\]",
    "docs/packaging/conda/meta.yaml": r'version: "(.+)"',
    "docs/packaging/modules/sitedda.lua": r'"Version: (.+)"',
    "docs/packaging/spack/package.py": r'version\("(.+)"\)',
}


@pytest.fixture
def root(request):
    return request.config.rootpath


@pytest.mark.parametrize("name", EXACT)
def test_every_file_has_the_version_of_the_program(root, name):
    match = re.search(EXACT[name], (root / name).read_text(), re.MULTILINE)
    assert match[1] == sitedda.__version__


def test_metadata_can_be_read(root):
    for name in ("codemeta.json", ".zenodo.json"):
        assert json.loads((root / name).read_text())["license"].endswith("GPL-3.0-or-later")


@pytest.mark.parametrize("file, width", [("spack/package.py", 99), ("easybuild/*.eb", 120)])
def test_recipes_follow_the_style_of_their_collections(root, file, width):
    """The collections provide names that are used without import."""
    text = next((root / "docs/packaging").glob(file)).read_text()
    ruff = [sys.executable, "-m", "ruff", "check", "--isolated", "--select=E,W,F"]
    options = (
        "--ignore=F403,F405,F821",
        f"--line-length={width}",
        "--stdin-filename=recipe.py",
        "-",
    )
    process = captured([*ruff, *options], input=text)
    assert process.returncode == 0, process.stdout


def test_recipes_name_every_library_that_the_package_needs(root):
    """Otherwise, users would detect a missing library at installation."""
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    needed = {re.match(r"[\w-]+", text)[0].lower() for text in project["dependencies"]}
    other_names = {"numpy": "numpy|scipy-bundle", "pandas": "pandas|scipy-bundle"}
    for file in ("conda/meta.yaml", "spack/package.py", "easybuild/sitedda-0.3.0-foss-2025b.eb"):
        text = (root / "docs/packaging" / file).read_text().lower()
        for name in needed:
            assert re.search(other_names.get(name, re.escape(name)), text), (file, name)


def test_the_documented_packages_are_those_that_recipes_install(root):
    command = re.search(r"apt-get install ([^`]+)```", (root / "docs/install.md").read_text())
    documented = command[1].replace("\\\n", "").split()
    assert documented == runpy.run_path(str(root / "python/start.py"))["PACKAGES"]
    libraries = {name for name in documented if name.startswith("lib")}
    recipes = (".github/workflows/ci.yml", ".github/workflows/publish.yml", ".readthedocs.yaml")
    for file in (*recipes, "docs/packaging/Containerfile", "docs/packaging/apptainer.def"):
        assert libraries <= set(re.findall(r"[\w.-]+", (root / file).read_text())), file


def test_the_paper_has_the_form_of_the_journal(root):
    """JOSS: 750 to 1,750 words, a summary, a statement of need, and sources of all citations."""
    text = (root / "docs/joss/paper.md").read_text()
    _, head, body = text.split("---\n", 2)
    assert 750 <= len(body.split()) <= 1750
    assert all(field in head for field in ("title:", "authors:", "affiliations:", "bibliography:"))
    assert "# Summary" in body and "# Statement of need" in body
    cited = set(re.findall(r"@(\w+)", body))
    keys = set(re.findall(r"^@\w+\{(\w+),", (root / "docs/joss/paper.bib").read_text(), re.M))
    assert cited == keys


# Claims of the README, and the beginning of the name of a test of each.
CLAIMS = {
    "response of ground, rock slopes and masonry": "input/test_examples.py::test_an_example_has_a",
    "checks a model before a run": "engine/test_check.py::test_both_programs_report_the_same_as",
    "with error bars": "study/test_accuracy.py::test_runs_print_their_error_bars",
    "`sitedda paper` and `sitedda": "verification/test_paper.py::test_the_study_meets_its_requirem",
    "analytic solutions": "verification/test_validation_cases.py::test_case_passes_in_its_short",
    "lists each change": "test_release.py::test_every_file_has_the_version_of_the_program",
    "Linux on x86-64": "test_release.py::test_the_install_section_holds",
    "pip install .": "test_release.py::test_the_documented_packages_are_those_that_recipes_install",
    "python3 python/start.py site": "test_release.py::test_the_install_section_holds",
    "python3 python/start.py test": "test_release.py::test_the_install_section_holds",
    "pip install ./python/evidence": "test_package.py::test_commands_of_the_evidence_name_their",
    "installs missing system packages": "test_release.py::test_the_documented_packages_are_those",
    "import sitedda": "test_handbook.py::test_a_python_block_runs_alone_as_pasted",
    "sitedda.copy_example": "test_handbook.py::test_a_python_block_runs_alone_as_pasted",
    "run = sitedda.run": "test_handbook.py::test_a_python_block_runs_alone_as_pasted",
    "print(run.verdict)": "test_handbook.py::test_a_python_block_runs_alone_as_pasted",
    "run.draw(": "test_handbook.py::test_a_python_block_runs_alone_as_pasted",
    "returns matplotlib axes": "drawing/test_pictures.py::test_a_run_is_drawn_in_every_look",
    "computes the first 20 s": "test_release.py::test_the_commands_of_the_example_run",
    "a rock slope with two": "test_handbook.py::test_a_python_block_runs_alone_as_pasted",
    "![Slip of the joints": "test_handbook.py::test_links_of_pages_are_valid",
    "requires no Python": "test_release.py::test_the_executable_runs_given_blocks",
    "with [groups of the engine]": "test_release.py::test_the_executable_runs_given_blocks",
    "sitedda check slope.nml": "test_release.py::test_the_commands_of_the_example_run",
    "sitedda run slope.nml": "test_release.py::test_the_commands_of_the_example_run",
    "sitedda resume slope.nml": "engine/test_checkpoint.py::test_each_program_resumes_what",
    "sitedda accuracy slope.nml": "study/test_accuracy.py::test_runs_print_their_error_bars",
    "sitedda view slope.nc": "test_release.py::test_the_commands_of_the_example_run",
    "sitedda --help": "test_handbook.py::test_each_command_of_the_pages_exists",
    "namelist of groups": "test_handbook.py::test_the_references_have_every_group_and_variable",
    "exits with status 0": "test_release.py::test_every_exit_status_of_the_readme_has_a_test",
    "**Energy budget**": "verification/test_layered_site.py::test_the_energy_balance_i",
    "**Convergence**": "test_faults.py::test_a_fault_is_one_message_and_a_status",
    "**Checks before a run**": "engine/test_check.py::test_a_run_is_refused_by_a_check_that",
    "**Bit-identical results**": "engine/test_bolts.py::test_both_programs_and_resumed_runs_are",
    "number of threads": "engine/test_threads.py::test_joint_laws_are_bit_identical_with_any",
    "constant strain unless they are": "engine/test_bodies.py::test_the_shipped_roof_beam_is_a_bea",
    "rotations may be large": "engine/test_bodies.py::test_a_spinning_body_keeps_its_energy",
    "Water acts on edges": "engine/test_water.py::test_water_on_faces_alone_does_not_lift",
}  # fmt: skip
STATUSES = {  # exit statuses, and a test of each
    1: ("bad input", "input/test_bad_input.py::test_a_missing_file_is_named"),
    2: ("failed check", "engine/test_check.py::test_a_check_that_fails_is_status_2"),
    3: ("a step does not converge", "test_faults.py::test_a_fault_is_one_message_and_a_status"),
    4: ("linear solver", "test_faults.py::test_a_fault_is_one_message_and_a_status"),
    5: ("file", "commands/test_command.py::test_an_output_that_cannot_be_written_is_status_5"),
    6: ("interrupted", "commands/test_command.py::test_ctrl_c_keeps_the_start_of_the_complete"),
    7: ("memory", "test_package.py::test_lack_of_memory_is_one_sentence"),
    141: ("closed pipe", "commands/test_command.py::test_the_bar_is_for_terminals_and_a_closed"),
}


def is_there(root, test: str) -> bool:
    """Return whether a test file has a function whose name begins like this."""
    file, _, name = test.partition("::")
    path = root / "tests" / (file if file.startswith("verification") else f"python/{file}")
    return f"\ndef {name}" in path.read_text()


def test_every_claim_of_the_readme_has_its_test(root):
    """Each paragraph, item and line of code between title and links contains a claim."""
    text = (root / "README.md").read_text().partition("\n## Read on")[0]
    parts = []
    for i, part in enumerate(re.split(r"^```.*\n", text, flags=re.M)):
        parts += part.splitlines() if i % 2 else re.split(r"\n\s*\n|\n(?=- )", part)
    parts = [" ".join(part.split()) for part in parts if part.strip() and part.strip()[0] != "#"]
    for part in parts:
        assert any(claim in part for claim in CLAIMS) or part.endswith(":"), part
    for claim, test in CLAIMS.items():
        assert any(claim in part for part in parts), claim
        assert is_there(root, test), test


def test_every_exit_status_of_the_readme_has_a_test(root):
    readme = " ".join((root / "README.md").read_text().split())
    statuses = readme.partition("statuses of errors are: ")[2]
    listed = re.findall(r"(\d+) ([a-z ]+)", statuses.partition(".")[0])
    assert {int(number): label for number, label in listed} == {
        number: readme for number, (readme, _) in STATUSES.items()
    }
    assert all(is_there(root, test) for _, test in STATUSES.values())
    constants = re.findall(
        r"parameter :: error_\w+ = (\d)", (root / "fortran/base/errors.f90").read_text()
    )
    assert {*map(int, constants)} - {8} == STATUSES.keys() - {141}  # 8 exits as file errors


def test_the_install_section_holds(root):
    readme = (root / "README.md").read_text()
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    oldest = project["requires-python"].removeprefix(">=")
    assert f"Python {oldest} or later" in readme
    jobs = (root / "python/start.py").read_text()
    assert all(f'"{job}": {job}' in jobs for job in re.findall(r"start.py (\w+)", readme))


def test_the_executable_runs_given_blocks(binary, python_program, tmp_path):
    """It refuses other inputs with a sentence that names the other program, and links no Python."""
    libraries = subprocess.check_output(["ldd", executable("sitedda-native")], text=True)
    assert "libgfortran" in libraries and "libpython" not in libraries
    python_program.ok("example", "layered_site", folder=tmp_path)
    python_program.ok("example", "slope", folder=tmp_path)
    binary.ok("check", "layered_site.nml", folder=tmp_path)
    refused = binary("check", "slope.nml", folder=tmp_path)
    assert refused.returncode == 1 and "sitedda build" in refused.stderr


def test_the_commands_of_the_example_run(main, tmp_path):
    """The commands of the README, with the first 0.1 s of the slope."""
    main.ok("example", "slope", folder=tmp_path)
    assert "duration = 20.0" in (tmp_path / "slope.nml").read_text()
    main.ok("check", "slope.nml", folder=tmp_path)
    main.ok("run", "slope.nml", "--set", "duration=0.1", "-q", folder=tmp_path)
    assert (tmp_path / "slope.nc").exists()
    main.ok("view", "slope.nc", folder=tmp_path)
    assert list(tmp_path.glob("slope*.html"))


def test_metadata_agree(root):
    """Description and keywords equal those of the package; codemeta uses its own vocabulary."""
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    codemeta, zenodo = (json.loads((root / name).read_text())
                        for name in ("codemeta.json", ".zenodo.json"))  # fmt: skip
    assert codemeta["description"] == project["description"] == zenodo["description"].rstrip(".")
    citation = (root / "CITATION.cff").read_text()
    keywords = zenodo["keywords"]
    assert set(keywords) <= set(project["keywords"])
    assert all(keyword in citation for keyword in keywords)
