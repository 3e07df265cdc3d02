# SPDX-License-Identifier: GPL-3.0-or-later
"""A model that can be checked, drawn and run."""

from ..build import model
from ..build.model import Group
from ..engine.checking import check
from .run import run

__all__ = ["Group", "Model"]


class Model(model.Model):  # noqa: D101
    __doc__ = model.Model.__doc__

    def check(self, **changes):
        """Check the model before a run, see `sitedda.check`."""
        return check(self, **changes)

    def draw(self, **options):
        """Draw the model before a run, see `sitedda.draw`; return matplotlib axes."""
        from ..drawing.pictures import draw

        return draw(self, **options)

    def run(self, output=None, progress=None, **changes):
        """Run the model to its end, see `sitedda.run`."""
        return run(self, output, progress, **changes)

    def _repr_html_(self) -> str:
        """Return groups and picture for a notebook; the error if the model cannot be drawn."""
        from .notebook import model_fragment

        return model_fragment(self)
