"""The paper itself: its equations as printed, its errata, its parameter studies."""
