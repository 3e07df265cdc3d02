# SPDX-License-Identifier: GPL-3.0-or-later
"""Study of ablation of the contact iteration: its changes still apply to the source."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import ablation
import hard
import pytest

import sitedda

pytestmark = pytest.mark.slow


def test_each_remedy_and_constant_exists_in_its_file():
    variants = ablation.variants([""])
    assert sum(name.startswith("without") for name in variants) == len(ablation.REMEDIES)
    for name, (file, text) in variants.items():
        before = file.read_text().splitlines()
        pairs = zip(before, text.splitlines(), strict=False)
        changed = [pair for pair in pairs if len(set(pair)) > 1]
        assert changed, name
        if not name.startswith("without"):
            assert len(changed) == 1 and f":: {name.split()[1]} = " in changed[0][0], name


def test_hard_walls_differ_by_their_friction():
    texts = {text() for text, _ in ablation.hard_cases().values()}
    assert len(texts) == 96


@pytest.mark.parametrize("law", hard.LAWS)
def test_each_law_has_hard_walls_and_steps_of_one_close(tmp_path, law):
    texts = hard.cases(law)
    assert len(set(texts.values())) >= 60
    file = tmp_path / "wall.nml"
    file.write_text(next(text for name, text in texts.items() if ": shaken, 20 at 1 ms" in name))
    history = sitedda.run(file, output=False).history
    assert history.sizes["time"] > hard.STEPS[1]
