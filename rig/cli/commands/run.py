"""`rig run`: run a campaign on the stand with a live view; errors are found before anything is
computed.
"""

import os
from pathlib import Path

from rig.campaign.campaign import Campaign
from rig.campaign.runner import run as run_campaign
from rig.cli.terminal.live import lines_of, live_view, timing
from rig.cli.terminal.output import cores, print_json, print_result
from rig.cli.terminal.tables import terminal
from rig.errors import InputError, Mistake


def run_protocol(
    campaign: Campaign,
    out: Path,
    workers: int | None,
    speed: float | None,
    resume: bool,
    force: bool,
    strict: bool,
    as_json: bool,
) -> int:
    """Run a campaign; return the exit code 0 where the verdict passes, 1 where it does not."""
    check_folder(out, resume, force)
    count = workers or cores()
    console = terminal(stderr=True, quiet=as_json)
    if strict:
        _refuse_beyond(campaign, count)
    with live_view(lines_of(campaign), console) as view:
        look = view.look if view.looks else None
        report = run_campaign(campaign, out, count, speed, resume, force, view.step, look)
    if timing(view):
        console.print(timing(view))
    if as_json:
        print_json(report.document())
    else:
        print_result(report, out)
    return 0 if report.passes else 1


def _refuse_beyond(campaign: Campaign, workers: int) -> None:
    """Raise InputError where a condition exceeds a limit; only --strict needs the dry run."""
    from rig.campaign.preflight.outlook import preflight

    mistakes = [
        Mistake(
            outlook.id,
            "drive.acceleration",
            flag,
            "within the exciter's and the front end's limits (--strict)",
        )
        for outlook in preflight(campaign, workers)
        for flag in outlook.beyond
    ]
    if mistakes:
        raise InputError(*mistakes)


def check_folder(out: Path, resume: bool, force: bool) -> None:
    """Raise InputError for an existing session, or a folder that cannot be written, before anything
    is computed.
    """
    if (out / "session.h5").exists() and not (resume or force):
        raise InputError(
            Mistake(
                str(out / "session.h5"),
                "",
                "a session that exists",
                "--resume to continue it, --force to replace it",
            )
        )
    # The nearest existing folder decides: the rest is created on writing.
    place = out
    while not place.exists():
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK):
        raise InputError(Mistake(str(out), "", f"{place} cannot be written", "a writable folder"))
