"""A campaign: what varies, how often; and each trial of it, fixed by campaign seed and trial index."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from dataclasses import dataclass, field
from typing import Mapping

import numpy as np

from master_thesis.campaign.axes import Value, with_defaults
from master_thesis.errors import CampaignError

SEEDS_MAX = 100_000
COMBINATIONS_MAX = 100_000


@dataclass(frozen=True)
class Trial:
    """One trial. index: in the campaign. replicate: which of the seeds. settings: by name, defaults included.

    place_seed, noise_seed: of a world drawn at random, and of every random stream of the flight. All
    combinations of a replicate share them, so that they are compared in the same places.
    """

    kind: str
    index: int
    replicate: int
    settings: Mapping[str, Value | None]
    place_seed: int
    noise_seed: int


@dataclass(frozen=True)
class Tuning:
    """What `campaign tune` searches. parameters: (name, low, high, whether on a logarithmic scale) of CEPA's.

    trials: sets of parameters that are tried. collision_cost, stuck_cost: what such a flight counts, where
    one that arrives counts its time over that of the straight way at full speed.
    """

    parameters: tuple[tuple[str, float, float, bool], ...]
    trials: int = 40
    collision_cost: float = 20.0
    stuck_cost: float = 5.0


@dataclass(frozen=True)
class Campaign:
    """What varies: axes holds (name, values) as the file has them; the trials are the product of all values.

    Trial `index` is combination `index % combinations` of replicate `index // combinations`, so that more
    seeds add trials at the end and change none. Raises CampaignError when settings do not go together.
    """

    name: str
    kind: str
    seed: int
    seeds: int
    axes: tuple[tuple[str, tuple[Value, ...]], ...]
    tuning: Tuning | None = None
    combinations: tuple[Mapping[str, Value | None], ...] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not 1 <= self.seeds <= SEEDS_MAX:
            raise CampaignError(f"seeds must be from 1 to {SEEDS_MAX}, not {self.seeds}.")
        if self.seed < 0:
            raise CampaignError(f"seed must not be negative, but is {self.seed}.")
        number = math.prod(len(values) for _, values in self.axes)
        if number > COMBINATIONS_MAX:
            raise CampaignError(f"trials has {number} combinations; at most {COMBINATIONS_MAX} can be flown.")
        names = [name for name, _ in self.axes]
        products = itertools.product(*(values for _, values in self.axes))
        combinations = tuple(with_defaults(self.kind, dict(zip(names, values))) for values in products)
        object.__setattr__(self, "combinations", combinations)

    def __len__(self) -> int:
        return self.seeds * len(self.combinations)

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the axes that have more than one value."""
        return tuple(name for name, values in self.axes if len(values) > 1)

    @property
    def digest(self) -> str:
        """What tells this campaign's trials from another's; the number of seeds and the name do not count."""
        content = json.dumps((self.kind, self.seed, self.axes))
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    def trial(self, index: int) -> Trial:
        """Return a trial by its index."""
        replicate, combination = divmod(index, len(self.combinations))
        entropy = np.random.SeedSequence((self.seed, replicate)).generate_state(2)
        place_seed, noise_seed = (int(word) for word in entropy)
        settings = self.combinations[combination]
        return Trial(self.kind, index, replicate, settings, place_seed, noise_seed)
