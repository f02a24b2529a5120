"""Conditions with known energies, as claims read them: no signals, only runs' W and levels."""

import math
from types import SimpleNamespace

import numpy as np

from analysis.comparison.claims import judge
from analysis.results.condition import Result
from analysis.session.prediction import Predicted
from analysis.session.protocol import ExpectedClaim
from analysis.uncertainty.budget import combine, scatter_line
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate
from daq.documents.classes import built


def result(W, a=5.0, *, W_T=None, still=False, scale=0.0, name="c", refills=()):
    """A condition from its runs' W (J). still: nothing can slide; scale: relative standard u common
    to all.
    """
    W = [float(w) for w in W]
    a = np.broadcast_to(a, len(W))
    mean = math.fsum(W) / len(W)
    lines = (*scatter_line(W), Line("scale", "1", scale, math.inf, mean))
    found = SimpleNamespace(
        setting=SimpleNamespace(id=name, is_empty=still, is_bonded=False, is_still=still),
        runs=tuple(
            SimpleNamespace(energy=SimpleNamespace(W=w, level=float(x)), u_noise=1e-7)
            for w, x in zip(W, a, strict=True)
        ),
        lines=lines,
        W_exp=combine(mean, [(line.part, line.nu) for line in lines]),
        W_T=None if W_T is None else Estimate(W_T, 0.0, math.inf),
        pairs=() if W_T is None else tuple((w, W_T) for w in W),
        detect=1e-6,
        refills=tuple(refills),
        predicted=Predicted(),
        inside=None,
    )
    # the rules of a real condition, which need no more than these fields
    found.is_seen = Result.is_seen.fget(found)
    found.log_energy = Result.log_energy.fget(found)
    return found


def entry(kind, values=(), limits=(), cases=1, **more):
    """An entry of the session's claims; conditions of case k are named by it and by the level:
    "1a".
    """
    places = [
        {
            "at": {"drive.acceleration": f"{k} m/s^2"} if cases > 1 else {},
            "levels": [
                {"value": value, "conditions": [f"{k}{value}"]}
                for value in more.get("levels", values)
            ],
        }
        for k in range(1, cases + 1)
    ]
    return {
        "claim": "it is so",
        "kind": kind,
        "about": "scene.grains.fill",
        "over": "",
        "values": list(values),
        "limits": list(limits),
        "imposed": more.get("imposed", ""),
        "cases": places,
    }


def judged(entries, results):
    """The claims of a session's document, judged."""
    return judge([built(ExpectedClaim, each) for each in entries], results)
