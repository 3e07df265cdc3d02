# SPDX-License-Identifier: GPL-3.0-or-later
"""Version, metadata, recipes and the paper of a release agree with each other."""

import ast
import json
import re
import runpy
import tomllib

import pytest

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
    found = re.search(EXACT[name], (root / name).read_text(), re.MULTILINE)
    assert found[1] == sitedda.__version__


def test_metadata_and_recipes_can_be_read(root):
    for name in ("codemeta.json", ".zenodo.json"):
        assert json.loads((root / name).read_text())["license"].endswith("GPL-3.0-or-later")
    for file in ("spack/package.py", "easybuild/sitedda-0.3.0-foss-2024a.eb"):
        ast.parse((root / "docs/packaging" / file).read_text())


def test_recipes_name_every_library_that_the_package_needs(root):
    """One that is missing is found when somebody installs it, not before."""
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    needed = {re.match(r"[\w-]+", one)[0].lower() for one in project["dependencies"]}
    same = {"matplotlib": "matplotlib", "numpy": "numpy|scipy-bundle", "scipy": "scipy"}
    for file in ("conda/meta.yaml", "spack/package.py", "easybuild/sitedda-0.3.0-foss-2024a.eb"):
        text = (root / "docs/packaging" / file).read_text().lower()
        for name in needed:
            assert re.search(same.get(name, re.escape(name)), text), (file, name)


def test_the_documented_packages_are_those_that_recipes_install(root):
    command = re.search(r"apt-get install ([^`]+)```", (root / "docs/install.md").read_text())
    documented = command[1].replace("\\\n", "").split()
    assert documented == runpy.run_path(str(root / "python/start.py"))["PACKAGES"]
    libraries = {name for name in documented if name.startswith("lib")}
    recipes = (".github/workflows/ci.yml", ".github/workflows/publish.yml", ".readthedocs.yaml")
    for file in (*recipes, "docs/packaging/Containerfile", "docs/packaging/apptainer.def"):
        assert libraries <= set(re.findall(r"[\w.-]+", (root / file).read_text())), file


def test_the_paper_keeps_the_form_of_the_journal(root):
    """JOSS: 750 to 1,750 words, a summary, a statement of need; every citation has its source."""
    text = (root / "docs/joss/paper.md").read_text()
    _, head, body = text.split("---\n", 2)
    assert 750 <= len(body.split()) <= 1750
    assert all(field in head for field in ("title:", "authors:", "affiliations:", "bibliography:"))
    assert "# Summary" in body and "# Statement of need" in body
    cited = set(re.findall(r"@(\w+)", body))
    known = set(re.findall(r"^@\w+\{(\w+),", (root / "docs/joss/paper.bib").read_text(), re.M))
    assert cited == known
