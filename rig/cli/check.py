"""`rig check`: what a campaign will ask of the rig, and what its repeats will be able to tell."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from rich.console import Console

from rig.campaign import Campaign
from rig.campaign.preflight import Outlook, disk, preflight
from rig.cli.output import cores, print_json
from rig.cli.tables import number, table


def check_protocol(campaign: Campaign, strict: bool, as_json: bool) -> int:
    """`rig check`: a line per condition; with --strict 2 where a limit is exceeded."""
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
    if as_json:
        rows = [{**asdict(o), "flags": list(o.flags)} for o in outlooks]
        print_json({"conditions": rows, **{k: v for k, v in totals.items() if k != "stand_time_s"}})
    else:
        _print_outlook(outlooks, totals)
    return 2 if strict and any(o.beyond for o in outlooks) else 0


def _print_outlook(outlooks: Sequence[Outlook], totals: Mapping[str, float]) -> None:
    console = Console()
    rows = [
        (
            o.id, o.bed, f"{o.fill:.0%}", number(o.diameter * 1e3), number(o.acceleration),
            f"{o.samples_per_cycle:.0f}",
            *(f"{share:.2f}" for share in (o.exciter.force, o.exciter.current, o.exciter.voltage, o.exciter.stroke)),
            f"{o.exciter.peak:.2f}", f"{max(o.range_force, o.range_acceleration):.2f}",
        )
        for o in outlooks
    ]  # fmt: skip
    columns = ("id", "bed", "fill", "d/mm", "a", "S/cycle", "force", "current", "voltage", "stroke", "peak", "range")
    console.print(table("Shares of the exciter's and the front end's limits", columns, rows, ("id", "bed")))
    lines = [
        (
            o.id, number(o.W_T), number(o.W_exp), number(o.U_W_exp, 2), number(o.W_detect, 2),
            number(o.smallest_difference, 2),
        )
        for o in outlooks
    ]  # fmt: skip
    energies = ("id", "W_T/J", "W_exp/J", "U/J", "W_detect/J", "least difference/J")
    console.print(table("Plan: what the repeats will be able to tell (95 %)", energies, lines, ("id",)))
    for o in outlooks:
        for flag in o.flags:
            console.print(f"{o.id}: {flag}")
    console.print(
        f"{totals['runs']} runs, {totals['rig_time_s']:.0f} s of rig time, "
        f"about {totals['stand_time_s']:.1f} s on the stand, {totals['disk_bytes'] / 1e6:.1f} MB"
    )
