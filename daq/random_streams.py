"""Independent random streams, each named by words, so that adding one changes no other."""

import hashlib
import json

import numpy as np

__all__ = ["stream"]


def stream(seed: int, *words: str) -> np.random.Generator:
    """Return the independent random generator named by `words` under the session seed.

    The words are hashed as a JSON list, so ("ab", "c") and ("a", "bc") are different streams. Known
    users: ("instrument", channel name) draws an instrument's actual state; (seed key of the
    condition, repeat, channel name) is a channel's noise in one run. SFC64 is the fastest of
    numpy's generators for Gaussian noise. Raises ValueError for a negative seed.
    """
    if seed < 0:
        raise ValueError(f"seed {seed} is negative; a seed is a whole number from 0 up")
    digest = hashlib.sha256(json.dumps(words).encode()).digest()
    entropy = [seed, *np.frombuffer(digest, dtype="<u4").tolist()]
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(entropy)))
