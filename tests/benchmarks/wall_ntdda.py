# SPDX-License-Identifier: GPL-3.0-or-later
"""Input files of ntdda for a wall."""

from speed_models import DENSITY, FRICTION_ANGLE, GRAVITY, POISSON_RATIO, YOUNG_MODULUS, Model

FACTOR = 50.0  # penalty of ntdda over Young's modulus
OVERHANG = 0.01  # m: ntdda forms blocks from lines that cross
NEVER = 10**6  # steps


def lines(model: Model) -> list[tuple[float, float, float, float]]:
    """Return lines x1, y1, x2, y2 that cut a plane into the blocks of a wall."""
    beds: dict[float, tuple[float, float]] = {}
    heads = set()
    for polygon in model.polygons:
        (left, bottom), (right, top) = polygon[[0, 2]].tolist()
        for y in (bottom, top):
            low, high = beds.get(y, (left, right))
            beds[y] = (min(low, left), max(high, right))
        heads |= {(left, bottom, top), (right, bottom, top)}
    horizontal = [(low - OVERHANG, y, high + OVERHANG, y) for y, (low, high) in beds.items()]
    return horizontal + [(x, low - OVERHANG, x, high + OVERHANG) for x, low, high in sorted(heads)]


def document(content: str) -> str:
    """Return an input file of ntdda."""
    return f'<?xml version="1.0"?>\n<Berkeley:DDA xmlns:Berkeley="dda">\n{content}</Berkeley:DDA>\n'


def geometry(model: Model) -> str:
    """Return the geometry for ntdda."""
    joints = "".join('<Joint type="1"> {} {} {} {} </Joint>\n'.format(*line)
                     for line in lines(model))  # fmt: skip
    points = "".join(f"<Point> {x} {y} </Point>\n" for x, y, _ in model.fixed)
    return document(
        '<Berkeley:Geometry>\n<Berkeley:Edgenodedist distance="0.001"/>\n<Jointlist>\n'
        f"{joints}</Jointlist>\n<Fixedpointlist>\n{points}</Fixedpointlist>\n</Berkeley:Geometry>\n"
    )


def analysis(steps: int, time_step: float) -> str:
    """Return the analysis for ntdda."""
    zeros = "".join(f"<{tag}> 0 0 0 </{tag}>" for tag in ("Istress", "Ivelocity", "Istrain"))
    return document(
        f'<Analysis type="dynamic">\n<Analysistype type="dynamic"/>\n<Rotation type="linear"/>\n'
        f'<Gravity flag="no"> </Gravity>\n<Autotimestep flag="no"/>\n'
        f'<Autopenalty flag="no" pfactor="{FACTOR}"/>\n<Planestrain flag="no"/>\n'
        f'<Numtimesteps timesteps="{steps}"/>\n<Maxtimestep maxtimestep="{time_step}"/>\n'
        f'<Maxdisplacement maxdisplacement="0.01"/>\n<Saveinterval step="{NEVER}"/>\n'
        f'<Blockmaterial type="1"><Unitmass> {DENSITY} </Unitmass>'
        f"<Unitweight> {DENSITY * GRAVITY} </Unitweight><Youngsmod> {YOUNG_MODULUS} </Youngsmod>"
        f"<Poissonratio> {POISSON_RATIO} </Poissonratio><Damping> 0 </Damping>{zeros}"
        f'</Blockmaterial>\n<Jointproperties type="1"><Friction> {FRICTION_ANGLE} </Friction>'
        f"<Cohesion> 0 </Cohesion><Tensile> 0 </Tensile></Jointproperties>\n</Analysis>\n"
    )
