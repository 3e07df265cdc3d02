# SPDX-License-Identifier: GPL-3.0-or-later
"""The task [pushover] of a study: a pushover of each case."""

from dataclasses import dataclass
from typing import ClassVar

from ..base.arguments import COUNT, POSITIVE
from ..base.errors import InputError
from .quantities import Quantity, check_names


@dataclass(frozen=True)
class PushTo:
    """Settings of a pushover, see `sitedda.pushover`."""

    point: str  # measured point whose displacement the curve shows
    load: str = "horizontal"
    sense: int = 1  # sense of the load along x
    displacement: float | None = None  # at the end, m; default: height of the point / 10
    steps: int = 200  # number of steps to this displacement
    limits: bool = False  # whether to compute limits of dry rigid blocks under a horizontal load
    results: ClassVar = (
        "peak_factor", "displacement_at_peak_m", "end_factor", "end_displacement_m", "work_j_m",
        "slip_loss_j_m", "limit_lower", "limit_upper",
    )  # fmt: skip

    def checked(self) -> "PushTo":
        """Return the settings; raise InputError if one is invalid."""
        from ..stability.capacity import LOADS

        if self.load not in LOADS or self.sense not in (1, -1):
            raise InputError(f"[pushover] load = {self.load!r}, sense = {self.sense!r}: load "
                             f"must be {' or '.join(LOADS)}, and sense 1 or -1")  # fmt: skip
        COUNT.check("[pushover] steps", self.steps)
        if self.displacement is not None:
            POSITIVE.check("[pushover] displacement", self.displacement)
        return self

    def check(self, file) -> None:
        """Check before the pushover that the measured point exists in an input."""
        check_names(file, [Quantity("", f"displacement[{self.point}].x")])

    def __call__(self, file) -> dict:
        """Run a pushover of an input; return the numbers named in `results`, and warnings."""
        from ..stability import limit_analysis, pushover

        curve = pushover(file, self.point, load=self.load, sense=self.sense,
                         displacement=self.displacement, steps=self.steps)  # fmt: skip
        results = {
            "peak_factor": curve.peak,
            "displacement_at_peak_m": curve.at_peak,
            "end_factor": float(curve.factor[-1]),
            "end_displacement_m": float(curve.displacement[-1]),
            "work_j_m": float(curve.work[-1]),
            "slip_loss_j_m": float(curve.friction[-1]),
            "warning": "" if curve.converged else curve.ending,
        }
        if self.limits:
            limits = limit_analysis(file, direction=(self.sense, 0.0))
            results |= {"limit_lower": limits.lower.factor, "limit_upper": limits.upper.factor}
        return results
