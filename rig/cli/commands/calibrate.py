"""`rig calibrate`: write a rig file with the parasitic losses that cause a target offset."""

from pathlib import Path

from rig.campaign.campaign import Campaign
from rig.campaign.loss_calibration import calibrated
from rig.catalog.rig_file import dump_rig
from rig.cli.terminal.files import write_new
from rig.cli.terminal.output import cores, print_json
from rig.cli.terminal.progress import progress
from rig.cli.terminal.tables import number, terminal
from rig.errors import InputError, Mistake


def calibrate_rig(campaign: Campaign, target: float, out: Path, force: bool, as_json: bool) -> None:
    """Write a rig file with the losses that cause the target offset of the weighted ratio."""
    if out.exists() and not force:
        raise InputError(
            Mistake(str(out), "", "a file that exists", "a new path, or --force to replace it")
        )
    with progress("runs", as_json) as watch:
        rig = calibrated(campaign, target, cores(), watch)
    write_new(out, dump_rig(rig), force)
    facts = {
        "loss_noise": rig.loss_noise,
        "loss_air": rig.loss_air,
        "provenance": dict(rig.provenance),
    }
    if as_json:
        print_json(facts)
        return
    console = terminal()
    console.print(
        f"viscous loss (the paper's noise) {number(rig.loss_noise, 6)} N s/m, quadratic loss (the paper's air) "
        f"{number(rig.loss_air, 6)} N s^2/m^2 -> {out}"
    )
    for name, value in rig.provenance.items():
        console.print(f"  {name}: {number(value)}", highlight=False)
