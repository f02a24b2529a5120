"""Predictions that are reported beside W_T, each with its own uncertainty."""

import math
from collections.abc import Mapping, Sequence

from analysis.session.prediction import SessionPrediction
from analysis.session.record import ChannelFacts
from analysis.uncertainty.budget import certificate_lines, combine, prediction_lines
from analysis.uncertainty.estimate import Estimate

__all__ = ["other_predictions"]


def other_predictions(
    predictions: Mapping[str, SessionPrediction],
    levels: Sequence[float],
    channels: tuple[ChannelFacts, ChannelFacts],
    frequency: float,
) -> Mapping[str, Estimate]:
    """Return predictions by name, means over the runs at their measured accelerations `levels`
    (m/s^2), J per cycle; without those whose levels end before.

    channels: force and acceleration; frequency: Hz. The accelerometer's errors move each variant
    with its own exponent dlnW/dlna.
    """
    found: dict[str, Estimate] = {}
    for name, curves in predictions.items():
        if not all(curves.total.reaches(level) for level in levels):
            continue
        W = math.fsum(map(curves.total, levels)) / len(levels)
        exponent = curves.total.exponent(math.fsum(levels) / len(levels)) or 0.0
        lines = (
            *certificate_lines(*channels, frequency, 0.0, 0.0, W, exponent),
            *prediction_lines(curves, W),
        )
        found[name] = combine(W, [(line.part_T, line.nu) for line in lines])
    return found
