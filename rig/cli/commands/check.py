"""`rig check`: predict the demand of a campaign on the rig, and the differences that its repeats
can resolve.
"""

from collections.abc import Mapping, Sequence, Set
from dataclasses import asdict, replace

from rig.campaign.campaign import Campaign
from rig.campaign.open_settings import material_values
from rig.campaign.preflight.decisions import MOST, Decision
from rig.campaign.preflight.outlook import Outlook, decided, disk, preflight
from rig.cli.terminal.output import cores, print_json, say
from rig.cli.terminal.tables import millijoules, number, table, terminal


def check_protocol(campaign: Campaign, strict: bool, as_json: bool) -> int:
    """Print one line per condition and return the exit code.

    0 where the plan holds; 1 where it does not: a level that is not reached, a channel that
    overloads, a tolerance of `fidelity: auto` that is not met. With --strict 2 where any limit is
    exceeded.
    """
    outlooks = list(preflight(campaign, cores()))
    cycles = {c.id: c.acquire.settle + c.acquire.record for c in campaign.conditions}
    repeats = campaign.protocol.repeats.n
    seconds = sum(o.seconds_per_cycle * cycles[o.id] for o in outlooks) * repeats / cores()
    totals = {
        "runs": len(campaign.runs),
        "rig_time_s": campaign.rig_time,
        "stand_time_s": seconds,
        "disk_bytes": disk(campaign),
    }
    claims = decided(campaign, outlooks)
    materials = material_values(campaign.conditions, campaign.rig)
    unmet = [f"{o.id}: {flag}" for o in outlooks for flag in o.fails]
    unmet += [
        f"{c}: the tolerance is not met: {found.why}"
        for c, found in campaign.choices.items()
        if not found.met
    ]
    if as_json:
        rows = [{**asdict(replace(o, expected=None)), "flags": list(o.flags)} for o in outlooks]
        for row in rows:
            del row["expected"]
        if campaign.choices:
            rows = [{**row, "fidelity": campaign.choices[row["id"]].document()} for row in rows]
        # The JSON output is the same on every machine: the computing time is left out.
        shown = {key: value for key, value in totals.items() if key != "stand_time_s"}
        print_json(
            {
                "conditions": rows,
                "claims": [asdict(one) for one in claims],
                "materials": [asdict(value) for value in materials],
                **shown,
                "unmet": unmet,
            }
        )
    else:
        swept = {c.id for c in campaign.conditions if c.drive.sweep_to is not None}
        _print_outlook(outlooks, totals, swept)
        _print_decisions(claims, repeats)
        used = {
            "force": max(o.range_force for o in outlooks),
            "acceleration": max(o.range_acceleration for o in outlooks),
        }
        ranges = []
        for c in campaign.instruments.channels:
            utilisation = f" ({used[c.name]:.2f} used)" if c.name in used else ""
            ranges.append(f"{c.name} {c.range_V:g} V{utilisation}")
        terminal().print(f"ranges: {', '.join(ranges)}")
        for value in materials:
            told = f"{value.path} {number(value.value, 6)} {value.unit}".rstrip()
            terminal().print(f"{told}: {value.status}, {value.source}")
        if campaign.choices:
            _print_choices(campaign)
    refused = [f"{o.id}: {flag}" for o in outlooks for flag in o.beyond] if strict else []
    for line in refused:
        say(f"rig: --strict: {line}", to_stderr=True)
    if unmet:
        say(
            f"rig: the plan does not hold in {len(unmet)} place(s); the first: {unmet[0]}",
            to_stderr=True,
        )
    if refused:
        return 2
    return 1 if unmet else 0


def _print_decisions(found: Sequence[Decision], repeats: int) -> None:
    """Print the expected verdict of each claim, and the number of repeats that decides it."""
    lines = [
        (
            str(place),
            one.claim,
            one.verdict,
            str(one.repeats) if one.repeats is not None else f"not by {MOST}",
            f"{one.found}: {one.why}",
        )
        for place, one in enumerate(found, 1)
    ]
    if lines:
        title = f"Claims: what {repeats} repeats of the expected energies say, and how many decide"
        columns = ("no.", "claim", "expected", "repeats", "found then, and why")
        terminal().print(table(title, columns, lines, ("claim", "expected", "found then, and why")))


def _print_choices(campaign: Campaign) -> None:
    """Print the choices of `fidelity: auto` for each condition, and the reason where the tolerance
    is out of reach.
    """
    console = terminal()
    lines = []
    for name, c in campaign.choices.items():
        errors = (c.error, c.error_rows, c.error_window, c.error_noise)
        percents = [f"{100 * error:.2g}" for error in errors]
        met = "yes" if c.met else "no"
        lines.append((name, number(c.rows), str(c.settle), str(c.record), *percents, met))
    tolerance = next(iter(campaign.choices.values())).tolerance
    title = f"Fidelity auto, tolerance {100 * tolerance:g} % of W per cycle: rows per layer, cycles, predicted error in %"
    columns = ("id", "rows", "settle", "record", "error", "of rows", "of window", "of noise", "met")
    console.print(table(title, columns, lines, ("id",)))
    for name, choice in campaign.choices.items():
        if not choice.met:
            console.print(f"{name}: the tolerance is not met: {choice.why}")


def _print_outlook(
    outlooks: Sequence[Outlook], totals: Mapping[str, float], swept: Set[str]
) -> None:
    """Print the utilisation of the limits and the expected energies. swept: conditions without a
    level or an energy.
    """
    console = terminal()
    rows = []
    for o in outlooks:
        level = "-" if o.id in swept else number(o.acceleration)
        use = o.exciter
        largest_range = max(o.range_force, o.range_acceleration)
        limits = (use.force, use.current, use.voltage, use.stroke, use.peak, largest_range)
        settings = (
            o.id,
            o.material,
            o.bed,
            f"{100 * o.fill:g}",
            level,
            f"{o.samples_per_cycle:.0f}",
        )
        rows.append((*settings, *(f"{value:.2f}" for value in limits)))
    columns = (
        "id",
        "grains",
        "bed",
        "fill",
        "a",
        "S/cyc",
        "force",
        "curr.",
        "volt.",
        "stroke",
        "peak",
        "range",
    )
    console.print(table("Utilisation of the limits of exciter and front end: 1 is the limit", columns, rows,
                        ("id", "grains", "bed")))  # fmt: skip
    lines = []
    for o in outlooks:
        if o.id in swept:
            continue  # a sweep has no single level, so no energy is predicted
        energy = (millijoules(o.W_T), millijoules(o.W_exp))
        resolution = [
            millijoules(value, 2) for value in (o.U_W_exp, o.W_detect, o.smallest_difference)
        ]
        needed = "-" if o.repeats_needed is None else str(o.repeats_needed)
        lines.append((o.id, *energy, *resolution, needed))
    energies = ("id", "W_T", "W_exp", "U", "W_detect", "least difference", "repeats for 7 %")
    if lines:
        console.print(
            table(
                "Plan, mJ per cycle: resolution of the repeats (95 %), - for one repeat; repeats for U of 7 %",
                energies,
                lines,
                ("id",),
            )
        )
    if swept:
        console.print(f"No energy is stated for sweeps: {', '.join(sorted(swept))}")
    for o in outlooks:
        for flag in o.flags:
            console.print(f"{o.id}: {flag}")
    console.print(
        f"{totals['runs']} runs, {totals['rig_time_s']:.0f} s of rig time, "
        f"about {totals['stand_time_s']:.1f} s on the stand, {totals['disk_bytes'] / 1e6:.1f} MB"
    )
