"""Tests state laws and never time anything: no deadline, and the same examples in every run."""

from hypothesis import settings

settings.register_profile("laws", deadline=None, derandomize=True)
settings.load_profile("laws")
