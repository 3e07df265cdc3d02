# SPDX-License-Identifier: GPL-3.0-or-later
"""The handbook: its code runs and prints the shown output, and its links are valid."""

import contextlib
import io
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from environment import DEADLINE

from sitedda.command import main as command
from sitedda.output.variables import VARIABLES
from sitedda.schema import GROUPS

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
LINK = re.compile(r"\]\(([^)\s]+)\)")
ROOT = Path(__file__).parents[2]
TOLD = [  # pages that show the output of commands
    *sorted(ROOT.glob("docs/tutorials/*.md")),
    *sorted(set(ROOT.glob("docs/casebook/*.md")) - {ROOT / "docs/casebook/index.md"}),
]
SHORT = [  # tutorials and cases of at most 30 lines
    *(ROOT / f"docs/tutorials/{name}.md"
      for name in ("wall", "profile", "tunnel", "back_analysis", "bonded_blocks")),
    *(page for page in TOLD if page.parent.name == "casebook"),
]  # fmt: skip
NOTEBOOKS = ("arch", "beam", "bonded_blocks", "site", "soil", "tunnel")
PASTED = [
    page
    for page in [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md"))]
    if "```python" in page.read_text() and page not in TOLD
]


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def run_block(kind: str, text: str) -> str:
    """Return the printed output of code of a page, and text of the reports that it writes."""
    with contextlib.redirect_stdout(io.StringIO()) as output:
        if kind == "python":
            exec(compile(text, "<handbook>", "exec"), {"__name__": "handbook"})
        for line in text.splitlines() if kind == "sh" else ():
            program, *report_texts = shlex.split(line, comments=True)
            assert program == "sitedda", line
            assert command(report_texts) == 0, line
    reports = re.findall(r"^page: (\S+)$", output.getvalue(), re.M)
    report_texts = (re.sub(r"<[^>]+>", " ", Path(report).read_text()) for report in reports)
    return output.getvalue() + " ".join(" ".join(report_texts).split())


@contextlib.contextmanager
def alone(folder: Path):
    """Run in an empty folder, whose files are then moved to those of the page."""
    with tempfile.TemporaryDirectory() as empty, contextlib.chdir(empty):
        yield
        shutil.copytree(empty, folder, dirs_exist_ok=True)


@pytest.mark.parametrize("page", TOLD, ids=name_of)
def test_a_page_prints_what_it_shows(page, tmp_path, monkeypatch):
    """Each Python block runs alone in an empty folder; commands run beside all files so far."""
    monkeypatch.chdir(tmp_path)
    output = ""
    for kind, text in BLOCK.findall(page.read_text()):
        if kind == "text":
            for line in text.splitlines():
                assert line in output
        else:
            with alone(tmp_path) if kind == "python" else contextlib.nullcontext():
                output = run_block(kind, text)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_tutorial_runs_as_a_notebook(name, tmp_path, monkeypatch):
    nbformat, nbclient = map(pytest.importorskip, ("nbformat", "nbclient"))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    page = ROOT / f"docs/tutorials/{name}.md"
    notebook = runpy.run_path(ROOT / "docs/notebooks.py")["notebook"]
    book = nbformat.from_dict(notebook(page, tmp_path))
    nbformat.validate(book)
    resources = {"metadata": {"path": tmp_path}}
    nbclient.NotebookClient(book, timeout=DEADLINE, resources=resources).execute()
    outputs = [cell_output for cell in book.cells for cell_output in cell.get("outputs", ())]
    output = "".join(cell_output.get("text", "") for cell_output in outputs)
    expected_texts = [text for kind, text in BLOCK.findall(page.read_text()) if kind == "text"]
    assert expected_texts and all(
        line in output for text in expected_texts for line in text.splitlines()
    )


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("page", PASTED, ids=name_of)
def test_a_python_block_runs_alone_as_pasted(page, tmp_path):
    for kind, text in BLOCK.findall(page.read_text()):
        if kind == "python":
            with alone(tmp_path):
                run_block(kind, text)


@pytest.mark.parametrize("page", SHORT, ids=name_of)
def test_a_path_takes_thirty_lines(page):
    blocks = BLOCK.findall(page.read_text())
    lines = [line for kind, text in blocks if kind != "text" for line in text.splitlines()]
    assert sum(bool(line.strip()) for line in lines) <= 30


@pytest.fixture(scope="module")
def pages(root) -> list:
    """Return all pages of the handbook, and others that link to it."""
    return [*(root / "docs").rglob("*.md"), *root.glob("*.md")]


def test_every_input_is_in_the_gallery_with_its_sentence(root):
    text = (root / "docs/gallery.md").read_text()
    for file in (root / "inputs").glob("*.nml"):
        match = re.search(rf"^### {file.stem}\n\n(.+)\n\n```sh\nsitedda run inputs/{file.name}",
                         text, re.M)  # fmt: skip
        assert match and len(match[1]) > 30, file.name


def test_each_command_of_the_pages_exists(pages):
    """This includes programs and sub-commands."""
    with contextlib.redirect_stdout(io.StringIO()) as output, pytest.raises(SystemExit):
        command(["--help"])
    commands = set(re.findall(r"^    (\w+)", output.getvalue(), re.M))
    used = set()
    for page in pages:
        for kind, text in BLOCK.findall(page.read_text()):
            lines = text.splitlines() if kind == "sh" else ()
            used |= {m[1] for line in lines if (m := re.match(r"sitedda (\w+)", line))}
    assert {"run", "resume", "check", "example"} <= used <= commands


def test_links_of_pages_are_valid(pages):
    for page in pages:
        for link in LINK.findall(re.sub(r"```.*?```", "", page.read_text(), flags=re.S)):
            path, _, anchor = link.partition("#")
            if "://" in link or link.startswith("mailto:"):
                continue
            target = page.parent / path if path else page
            assert target.exists(), f"{page.name}: {link}"
            if anchor and target.suffix == ".md":
                assert anchor in anchors(target), f"{page.name}: {link}"


def test_links_of_built_pages_are_valid(root, tmp_path):
    """`docs/build.py` reports invalid links as errors, and repairs those in lists of Ford."""
    build = runpy.run_path(str(root / "docs/build.py"))
    page_text = "<a href='#moduleprocedure-grow_reals'></a><p id='proc-grow_reals'></p>"
    (tmp_path / "grow.html").write_text(page_text)
    (tmp_path / "index.html").write_text("<a href='grow.html#x'></a><a href='no.html'></a>")
    assert build["dead_links"](tmp_path) == [
        "grow.html: #moduleprocedure-grow_reals", "index.html: grow.html#x", "index.html: no.html",
    ]  # fmt: skip
    build["mend_interfaces"](tmp_path)
    assert len(build["dead_links"](tmp_path)) == 2


def anchors(page) -> set[str]:
    """Return the anchors of the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_every_page_is_in_a_table_of_contents(root):
    docs = root / "docs"
    listed = set()
    for page in docs.rglob("*.md"):
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(), re.S):
            for entry in re.findall(r"^(?!:)(\S+)$", tree, re.M):
                listed.add((page.parent / f"{entry}.md").resolve())
    pages = {page.resolve() for page in docs.rglob("*.md")}
    assert pages - listed == {docs / "index.md", docs / "ford.md", docs / "joss/paper.md"}
    assert listed <= pages


@pytest.mark.parametrize("of", ["input", "output"])
def test_the_reference_is_generated_from_the_schema(root, tmp_path, of):
    generated, source, page = tmp_path / "made", root / "fortran" / of, f"docs/{of}_reference.md"
    command = [sys.executable, source / "make_schema.py", "page", source / "schema.txt", generated]
    subprocess.run(command, check=True)
    assert generated.read_text() == (root / page).read_text(), (
        f"python fortran/{of}/make_schema.py page fortran/{of}/schema.txt {page}"
    )


def test_the_references_have_every_group_and_variable(root):
    pages = [root / f"docs/{kind}_reference.md" for kind in ("input", "output")]
    inputs, outputs = (page.read_text() for page in pages)
    for group in GROUPS.values():
        assert f"### `&{group.name}`" in inputs
    for name in VARIABLES:
        assert f"| `{name}` |" in outputs
