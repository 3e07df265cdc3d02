# SPDX-License-Identifier: GPL-3.0-or-later
"""Checkpoints contain all state that a run changes: this test examines all types."""

import re

import pytest

# Types whose components are saved.  A type names components that are not saved, because they come
# from the input or are recomputed before use, in ``! unsaved, REASON: NAMES``.
STATES = {
    "dynamics": "simulation_type system_type open_close_type counters_type "
    "stop_state_type maxima_type base_type first_contacts_type largest_type",
    "model": "blocks_type",
    "contact": "neighbours_type contacts_type",
    "algebra": "solver_type lagged_factor_type low_rank_type rank_one_type factor_type",
    "elements": "fixed_points_type energy_type",
    "output": "journal_type",
}


def components(text: str, name: str) -> set[str]:
    """Names of the components of a derived type."""
    begin = rf"^ *type(?:, extends\(\w+\))? :: {name}\n"
    body = re.search(rf"{begin}(.*?)^ *end type", text, re.M | re.S)
    assert body, f"there is no type {name}"
    component_names = set()
    for line in body[1].splitlines():
        code = line.partition("!")[0]
        if code.strip() == "contains":
            break
        names = re.sub(r"\(.*?\)", "", code.partition("::")[2])
        component_names |= set(re.findall(r"(?:^|,)\s*(\w+)", names))
    return component_names


@pytest.fixture(scope="module")
def serialised(root):
    """The code that writes and reads the state."""
    journal = (root / "fortran" / "output" / "journal.f90").read_text()
    text_of_mark = re.search(r"subroutine serialise_mark.*?end subroutine", journal, re.S)[0]
    contact = (root / "fortran" / "contact" / "contact.f90").read_text()
    texts_of_lists = "".join(re.findall(r"subroutine for_each_\w+.*?end subroutine", contact, re.S))
    folders = ("state", "algebra/solvers", "elements")
    files = [path for name in folders for path in (root / "fortran" / name).glob("*.f90")]
    parts = [path.read_text() for path in files]
    return re.sub(r"!.*", "", "\n".join([text_of_mark, texts_of_lists, *parts]))


def source_of(folder, name: str) -> str:
    """The text of the only file of a folder that defines a type."""
    files = [f for f in folder.rglob("*") if f.suffix in (".f90", ".inc", ".in")]
    texts = [text for text in map(type(folder).read_text, files) if f":: {name}\n" in text]
    assert len(texts) == 1, f"{name} is defined {len(texts)} times in {folder}"
    return texts[0]


@pytest.mark.parametrize(
    ("folder", "name"), [(folder, one) for folder, names in STATES.items() for one in names.split()]
)
def test_every_component_is_saved_or_declared_unsaved(root, serialised, folder, name):
    text = source_of(root / "fortran" / folder, name)
    component_names = components(text, name)
    declaration = re.search(rf":: {name}\n(.*?)^ *end type", text, re.M | re.S)[1]
    texts = re.findall(r"! unsaved, .*: (.*)", declaration)
    unsaved_names = set(", ".join(texts).split(", ")) - {""}
    saved_names = {part for part in component_names if re.search(rf"%{part}\b", serialised)}
    missing_names = component_names - saved_names - unsaved_names
    assert not missing_names, f"{name}: {missing_names} are neither saved nor declared unsaved"
    assert unsaved_names <= component_names, "an unsaved component no longer exists"
