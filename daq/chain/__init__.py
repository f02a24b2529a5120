"""The measurement chain: from physical quantities over volts to blocks of codes."""
