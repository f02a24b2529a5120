"""What the report says in sentences: the same in every form of it."""

import re
from typing import Any

from analysis.report.tables import significant, with_U

__all__ = ["again", "headline", "reasons", "tested", "verdict_line", "waveform"]

Report = dict[str, Any]


def tested(report: Report) -> str:
    """The report's first sentence: what a run like this can show."""
    beds = sorted({row["bed"] for row in report["conditions"]})
    listed = " and ".join(filter(None, [", ".join(beds[:-1]), *beds[-1:]])) or "none"
    word = "bed" if len(beds) < 2 else "beds"
    if report["tests"] == "chain":
        if not any(row["W_T"] for row in report["conditions"]):
            return f"This run checks the measurement chain: nothing is predicted for the {word} {listed}."
        return (
            f"This run checks the measurement chain, not the damper model: the {word} {listed} and the prediction W_T "
            "share one mechanism."
        )
    return f"This run tests the damper model: what the {word} {listed} dissipated does not come from the model of W_T."


def waveform(report: Report) -> str:
    """Where the signals come from, and which waveform was assumed."""
    origin = "All signals are synthetic." if report["synthetic"] else "The signals were measured."
    shaken = [row["thd_acceleration"] for row in report["conditions"] if row["drive"] == "coupled"]
    told = [value for value in shaken if value is not None]
    if told:
        low, high = (significant(100 * edge(told), 2) for edge in (min, max))
        return (
            f"{origin} The box moves as exciter and bed let it: its acceleration is distorted by {low} % to {high} % "
            "(harmonics over fundamental). W_T is given on a sine of the same fundamental and on the recorded waveform."
        )
    if report["waveform"] != "ideal":
        return origin
    found = [row["thd_box"] for row in report["conditions"] if row["thd_box"] is not None]
    low, high = (significant(100 * edge(found), 2) if found else "" for edge in (min, max))
    spread = f"{low} % to {high} %" if found else "an unknown amount"
    return (
        f"{origin} An ideal waveform is assumed: the box follows the programmed motion exactly, where the bed's force "
        f"would distort a real exciter's acceleration by {spread} (harmonics over fundamental)."
    )


def verdict_line(report: Report) -> str:
    """The verdict in a word."""
    return "Passes" if report["verdict"] == "passes" else "Fails"


def reasons(report: Report) -> tuple[str, ...]:
    """One sentence per check behind the verdict."""
    return tuple(report["reasons"])


def headline(report: Report) -> str:
    """How far measurement and prediction are apart."""
    found = report["agreement"]
    if found["ratio"] is None:
        return "There is no predicted energy to compare with."
    offset, U, count = found["ratio"] - 1, found["U_ratio"], found["n"]
    nu = "unlimited" if found["nu"] is None else f"{found['nu']:.0f}"
    amount = with_U(abs(offset), U, 100.0).text.split(" ± ")
    relation = "exceeds" if offset >= 0 else "falls short of"
    margin = f" ± {amount[1]} %" if len(amount) > 1 else ""
    text = (
        f"W_exp {relation} W_T by {amount[0]} %{margin} (k = {found['k']:.2f}, {nu} degrees of freedom), weighted with "
        "energy"
    )
    slope = f"; slope through the origin {with_U(found['slope'], found['U_slope']).text}" if found["slope"] else ""
    text += f"{slope}."
    if found["put_in"] is not None:
        text += f" The rig file put in {significant(100 * found['put_in'], 2)} % of W_T as losses of the box."
    if found["mean_offset"] is not None:
        mean = f"{significant(100 * found['mean_offset'], 2)} %"
        text += f" The mean offset of the {count} conditions above the detection limit is {mean}."
    return text


def again(report: Report) -> tuple[tuple[str, str], ...]:
    """Commands that make this report again, with what each does."""
    name = re.sub(r"[^\w.-]", "_", report["protocol"]) or "protocol"
    again = ("rig report session.h5", "makes this report again from the record alone.")
    if not report["synthetic"]:
        return (again,)
    run = "repeats the whole session from its protocol, which the session file holds word for word (seed included)."
    return ((f"rig run {name}.yaml", run), again)
