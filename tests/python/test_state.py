# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing that a run changes may be missing from its checkpoints: all types are looked through."""

import re

import pytest

# What a resumed run has without a checkpoint: from the input, or made anew before it is used.
REMADE = {
    ("dynamics", "simulation_type"): {
        "model": "the input",
        "detection": "the input",
        "laws": "the input",
        "scheme": "the input, by the stage",
        "history": "where old contacts are: made in each step",
        "resting": "only within a static stage, between whose steps nothing is saved",
        "linear_about": "set at the start of each round of a step",
        "solution": "set at the end of each round, before it is used",
    },
    ("model", "blocks_type"): {
        name: "the input"
        for name in (
            *("n", "first", "owner", "next", "previous", "material", "joint", "reference"),
            *("radius", "area", "mass", "inertia", "stiffness", "half_size"),
            *("mixed", "removed", "damps", "damping"),
            *("body", "inner", "outline", "rest_share", "joined", "joined_first", "whole_area"),
        )
    },
    ("contact", "neighbours_type"): {
        "crowded": "a search that found too much, which ends the run",
        "first_corner": "listed anew from the present places, which changes no decision",
        "corner": "listed anew from the present places, which changes no decision",
        "convex": "the input",
        "convex_block": "the input",
    },
    ("contact", "contacts_type"): {
        "with_laws": "the input",
        "held_bound": "allocated within a step alone",
        "imposed_spring": "allocated within a static step alone",
        "imposed_force": "allocated within a static step alone",
        "gap_change": "set before it is used",
        "slip_change": "set before it is used",
    },
    ("dynamics", "system_type"): {
        "matrix": "its pattern follows from the neighbours, its numbers are made in each step",
        "pair_of_entry": "the pattern",
        "first_contact": "listed in each step",
        "contact_terms": "made anew in each step",
        "constant": "made for a new time step",
        "constant_step": "made for a new time step",
        "constant_damps": "made with `constant`",
        "linear": "made in each step",
        "has_terms": "made in each step",
        "linear_entry": "the pattern",
        "terms": "made in each step",
        "load": "made in each step",
        "rhs": "made in each step",
        "d": "guessed at the start of each step",
        "previous_d": "set before it is used",
        "watch": "a clock for those who measure",
        "drifts": "set in each step",
        "drift": "set in each step, where `drifts`",
        "drift_load": "set in each step, where `drifts`",
    },
    ("algebra", "solver_type"): {
        "name": "the input",
        "loads": "weighed in each step",
    },
    ("algebra", "lagged_factor_type"): {},
    ("algebra", "low_rank_type"): {
        name: "follows from the springs and the factor"
        for name in ("columns", "gram", "n", "order", "pivot", "t")
    },
    ("algebra", "rank_one_type"): {},
    ("algebra", "factor_type"): {
        name: "follows from the pattern, or is workspace"
        for name in (
            "plan",
            "planned",
            "panel",
            "update",
            "vector",
            "front_vector",
            "bad_pivot",
            "threads",
        )
    },
    ("dynamics", "open_close_type"): {
        "region_residual": "each step begins without",
        "cycle": "each step begins without",
        "max_iterations": "the input",
        "relative_tolerance": "the input",
        "weight": "the input",
        "noise": "the input; under joint laws set in each step",
        "penetration_tolerance": "the input",
        "may_stop": "set in static stages",
        "last_resort": "set in each step",
        "passes": "counted in each step",
        "most_changes": "set in static steps",
        "relaxes": "set in static stages",
        "converged": "set in each step",
        "unbalanced_work": "set in each step",
        "slides": "listed in each iteration",
        "rounding": "set in each step",
        "keeps_states": "each step begins without",
        "reversed": "found in each iteration",
    },
    ("elements", "fixed_points_type"): {"point": "the input"},
    ("elements", "energy_type"): {},
    ("dynamics", "counters_type"): {},
    ("dynamics", "stop_state_type"): {},
    ("dynamics", "maxima_type"): {
        "last": "taken before it is written",
        "moved": "taken before it is written",
        "size_of": "the input",
        "least_size": "the input",
        "below": "the input",
    },
    ("dynamics", "base_type"): {},
    ("dynamics", "first_contacts_type"): {"pressed": "found before it is used"},
    ("dynamics", "largest_type"): {},
    ("output", "journal_type"): {"file": "opened anew"},
}


def components(text: str, name: str) -> set[str]:
    """Names of the components of a derived type."""
    begin = rf"^ *type(?:, extends\(\w+\))? :: {name}\n"
    body = re.search(rf"{begin}(.*?)^ *end type", text, re.M | re.S)
    assert body, f"there is no type {name}"
    found = set()
    for line in body[1].splitlines():
        code = line.partition("!")[0]
        if code.strip() == "contains":
            break
        names = re.sub(r"\(.*?\)", "", code.partition("::")[2])
        found |= set(re.findall(r"(?:^|,)\s*(\w+)", names))
    return found


@pytest.fixture(scope="module")
def serialised(root):
    """The code that serialises the state."""
    journal = (root / "fortran" / "output" / "journal.f90").read_text()
    mark = re.search(r"subroutine serialise_mark.*?end subroutine", journal, re.S)[0]
    contact = (root / "fortran" / "contact" / "contact.f90").read_text()
    listed = "".join(re.findall(r"subroutine for_each_\w+.*?end subroutine", contact, re.S))
    folders = ("state", "algebra/solvers", "elements")
    parts = [
        path.read_text() for name in folders for path in (root / "fortran" / name).glob("*.f90")
    ]
    return re.sub(r"!.*", "", "\n".join([mark, listed, *parts]))


def source_of(folder, name: str) -> str:
    """The one file of a folder that defines a type."""
    files = [f for f in folder.rglob("*") if f.suffix in (".f90", ".inc", ".in")]
    found = [text for text in map(type(folder).read_text, files) if f":: {name}\n" in text]
    assert len(found) == 1, f"{name} is defined {len(found)} times in {folder}"
    return found[0]


@pytest.mark.parametrize(("folder", "name"), REMADE)
def test_every_component_is_serialised_or_made_anew(root, serialised, folder, name):
    found = components(source_of(root / "fortran" / folder, name), name)
    excused = set(REMADE[folder, name])
    written = {part for part in found if re.search(rf"%{part}\b", serialised)}
    missing = found - written - excused
    assert not missing, f"{name}: {missing} are neither serialised nor said to be made anew"
    assert excused <= found, "something is excused that is not there any more"
