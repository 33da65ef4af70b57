"""A campaign: what varies and how often. Its seed and a case's index fix each case."""

from __future__ import annotations

import itertools
import math
from dataclasses import MISSING, dataclass, field

import numpy as np

from flight_basics.checks import check_limits, limited
from flights.campaign.axes import Settings, Value, with_defaults
from flights.errors import CampaignError
from flights.trials.trial import digest

SEEDS_MAX = 100_000
COMBINATIONS_MAX = 100_000
FORMAT = 2
"""Of a campaign's folder. A folder of another format is refused."""
PATIENCE = 10.0
"""A flight is ended after this many times the duration of its straight way at full speed."""


@dataclass(frozen=True)
class Case:
    """One trial of a campaign. replicate: which of the seeds.

    place_seed, noise_seed: of a world drawn at random, and of every random stream of the flight. All
    combinations of a replicate share them, so that they are compared in the same places.
    """

    kind: str
    index: int
    replicate: int
    settings: Settings
    place_seed: int
    noise_seed: int


@dataclass(frozen=True)
class Block:
    """Axes, (name, values) as the file has them, whose product is flown. times: so many times the seeds."""

    axes: tuple[tuple[str, tuple[Value, ...]], ...]
    times: int = 1

    def __len__(self) -> int:
        return math.prod(len(values) for _, values in self.axes)


@dataclass(frozen=True)
class Tuning:
    """What `campaign tune` searches. parameters: (name, low, high, whether on a logarithmic scale) of CEPA's.

    trials: sets of parameters that are tried. A flight that arrives counts its time divided by that of the
    straight way at full speed. collision_cost, stuck_cost: what another one counts, PATIENCE at least, so
    that a late arrival is better than none.
    """

    parameters: tuple[tuple[str, float, float, bool], ...]
    trials: int = 40
    collision_cost: float = 20.0
    stuck_cost: float = PATIENCE


@dataclass(frozen=True)
class Campaign:
    """What varies. The combinations are those of all blocks; one that several blocks name is flown once.

    Case `index` is combination `index % combinations` of replicate `index // combinations`. So more seeds
    change no case that there was. repeats: of each combination, how many times the seeds.
    Raises CampaignError when settings do not go together.
    """

    name: str
    kind: str
    blocks: tuple[Block, ...]
    seed: int = limited(MISSING, 0)
    seeds: int = limited(MISSING, 1, SEEDS_MAX)
    tuning: Tuning | None = None
    combinations: tuple[Settings, ...] = field(init=False, compare=False, repr=False)
    repeats: tuple[int, ...] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        check_limits(self, CampaignError)
        number = sum(map(len, self.blocks))
        if number > COMBINATIONS_MAX:
            raise CampaignError(f"trials has {number} combinations; at most {COMBINATIONS_MAX} can be flown.")
        combinations: dict[frozenset, Settings] = {}
        repeats: dict[frozenset, int] = {}
        for block in self.blocks:
            names = [name for name, _ in block.axes]
            for values in itertools.product(*(values for _, values in block.axes)):
                settings = with_defaults(self.kind, dict(zip(names, values)))
                key = frozenset(settings.items())
                combinations.setdefault(key, settings)
                repeats[key] = max(block.times, repeats.get(key, 1))
        object.__setattr__(self, "combinations", tuple(combinations.values()))
        object.__setattr__(self, "repeats", tuple(repeats.values()))

    def __len__(self) -> int:
        return self.seeds * sum(self.repeats)

    @property
    def cases(self) -> list[Case]:
        """All cases, in the order of their indices."""
        of = range(self.seeds * max(self.repeats))
        return [
            self.case(replicate * len(self.combinations) + number)
            for replicate in of
            for number, times in enumerate(self.repeats)
            if replicate < self.seeds * times
        ]

    def case(self, index: int) -> Case:
        """Return a case by its index."""
        replicate, combination = divmod(index, len(self.combinations))
        entropy = np.random.SeedSequence((self.seed, replicate)).generate_state(2)
        place_seed, noise_seed = (int(word) for word in entropy)
        return Case(self.kind, index, replicate, self.combinations[combination], place_seed, noise_seed)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the axes, in the order of the file."""
        return tuple(dict.fromkeys(name for block in self.blocks for name, _ in block.axes))

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the axes that have more than one value."""
        return tuple(n for n in self.names if len({settings.get(n) for settings in self.combinations}) > 1)

    def values(self, name: str) -> tuple[Value, ...]:
        """Return the values of an axis, in the order of the file."""
        found = (settings.get(name) for settings in self.combinations)
        return tuple(dict.fromkeys(value for value in found if value is not None))

    @property
    def digest(self) -> str:
        """What tells this campaign's cases from another's; the number of seeds and the name do not count."""
        return digest({"format": FORMAT, "kind": self.kind, "seed": self.seed, "blocks": self.blocks})[:16]
