# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes on sizes in groups that are probably mistakes."""

from collections.abc import Sequence

import numpy as np


def doubtful_sizes(groups: Sequence[tuple[str, dict, str]]) -> list[str]:
    """Return a sentence for each group whose size is probably a mistake.

    `groups`: name, variables and position in the file.
    """
    outlines = [np.reshape(values["outline"], (-1, 2)) for kind, values, _ in groups
                if kind == "region" and len(values.get("outline", ()))]  # fmt: skip
    width = float(np.hypot(*np.ptp(np.concatenate(outlines), axis=0))) if outlines else np.inf
    sentences = []
    for kind, values, source in groups:
        size, fine, spacing = (values.get(name) for name in ("size", "fine_size", "spacing"))
        if kind in ("mesh", "ground") and size and fine and fine > size:
            sentence = f"fine_size = {fine:g} m is above size = {size:g} m, so no cells are refined"
        elif kind == "joint_set" and spacing and spacing > width:
            sentence = (f"spacing = {spacing:g} m is more than {width:.4g} m, the size of the "
                     "regions, so few joints cut the regions; is spacing in mm?")  # fmt: skip
        else:
            continue
        sentences.append(f"{source}: {sentence}".removeprefix(": "))
    return sentences
