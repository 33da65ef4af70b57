"""Independent streams of random numbers, spawned from one seed."""

from __future__ import annotations

from typing import Sequence

import numpy as np


class RandomStreams:
    """Independent random generators by name, spawned from one seed.

    `rewind` makes them repeat. A new name at the end of the list does not change the streams before it.
    """

    def __init__(self, seed: int, names: Sequence[str]):
        children = np.random.SeedSequence(seed).spawn(len(names))
        self._generators = {name: np.random.default_rng(child) for name, child in zip(names, children)}
        self._starts = {name: rng.bit_generator.state for name, rng in self._generators.items()}

    def __getitem__(self, name: str) -> np.random.Generator:
        return self._generators[name]

    def rewind(self) -> None:
        """Put every generator back to its start. The generators themselves stay the same objects."""
        for name, generator in self._generators.items():
            generator.bit_generator.state = self._starts[name]
