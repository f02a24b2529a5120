"""Names of columns in the ledger of a simulated session."""

DISSIPATED = (
    "W_f",
    "W_c",
    "W_viscous",
    "W_noise",
    "W_air",
    "W_gas",
    "W_mount",
    "dKE_bed",
    "dKE_box",
)
"""Ledger columns whose sum the gauge should read over whole cycles, J per cycle."""
STINGER = "W_stinger"  # energy that the stinger dissipates
EXACT = "W_exact"  # energy of the same bed in an exact sine of the level reached (ablation)
CLOSURE = "closure"  # relative error of the energy account
