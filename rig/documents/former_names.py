"""Names of the first edition -> names of today. An old name in a user's file is an error that states
the new one.
"""

from collections.abc import Mapping

__all__ = ["FORMER_NAMES", "FORMER_PROTOCOLS", "FORMER_RIGS"]

FORMER_NAMES: Mapping[str, str] = {
    "servo": "prescribed",
    "coupled": "shaker",
    "slug": "single_mass",
    "play": "clearance",
    "refill_play": "refill_clearance",
    "mistake": "deliberate_error",
    "allow_undersampled": "paper_rule with the opposite value",
}
"""Keys and words of protocols, rig files and mappings; after the new name a note for the user."""

FORMER_PROTOCOLS: Mapping[str, str] = {
    "coupled_fill": "shaker_fill",
    "slug_vertical": "single_mass_vertical",
    "slug_zero_gravity": "single_mass_zero_gravity",
}
"""Shipped protocols."""

FORMER_RIGS: Mapping[str, str] = {"default": "paper"}
"""Rigs of the catalog."""
