"""Protocol settings that the paper does not state: assumed values, listed in every report with
those of the rig file.
"""

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

from rig.protocol.spec import Condition
from rig.units import unit_of

OPEN = (
    (
        "scene.axis",
        "",
        "the paper does not say; eq 5 shears horizontal layers, Fig. 4 starts a chain at a side wall",
    ),
    ("scene.cavity.wall", "length", "the paper gives carbon steel and no thickness"),
    (
        "scene.layers.clearance",
        "",
        "clearance in units of eq 4's slip: the paper's thinnest to thickest distance",
    ),
    ("scene.layers.spread", "", "relative spread of the clearance over the rows of a layer"),
    ("scene.layers.rows", "", "strata per layer; physically width over diameter"),
    ("drive.frequency", "frequency", "the paper gives none"),
    (
        "drive.mode",
        "",
        "the paper does not say; prescribed is an ideal waveform, shaker has the exciter in the loop",
    ),
)
"""Path, dimension, reason of the assumption."""


def assumed_settings(conditions: Sequence[Condition]) -> list[dict[str, Any]]:
    """Return the assumed settings with their values over all conditions, in the form of the rig
    file's values.
    """
    return [
        {
            "path": path,
            "value": _over_all(path, conditions),
            "unit": unit_of(dimension) if dimension else "",
            "status": "assumed",
            "source": why,
        }
        for path, dimension, why in OPEN
    ]


def _over_all(path: str, conditions: Sequence[Condition]) -> Any:
    """Return the value of a setting, or all its values in one text."""
    found = list(dict.fromkeys(map(attrgetter(path), conditions)))
    return (
        found[0]
        if len(found) == 1
        else ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in found)
    )
