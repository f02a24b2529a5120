"""Names of columns in a simulated session's ledger."""

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
"""Ledger columns that add up to what the gauge should see over whole cycles, J per cycle."""
STINGER = "W_stinger"  # ledger column: what the stinger loses
EXACT = "W_exact"  # ledger column: what the same bed takes in the exact waveform of the level reached (ablation)
CLOSURE = "closure"  # ledger column: relative error of the account
