"""How much of each effect a photograph shows: numbers, checked."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Mapping

from flight_basics.checks import check_limits, limited
from simulation_tools.camera.errors import PhotographError

MOST_SEED = 2**31 - 1


@dataclass(frozen=True)
class Effects:
    """How much of each effect, 0 (none) to 1. They lie on the world: each photograph shows the same ones.

    welds: beads along the seams of the plates. waviness: plates that are dished between their frames. scale:
    flakes of mill scale. dirt: dust, and what water has washed down. patches: of older paint, some of red
    oxide primer. runs: of rust below upper edges and seams. pitting: small round holes. coatings: other
    colours low, high, and on decks. wet: a film of water. condensation: drops and fog on the lens. seed: of
    all their places.

    Raises:
        PhotographError: an amount is out of range.
    """

    welds: float = limited(0.0, 0.0, 1.0)
    waviness: float = limited(0.0, 0.0, 1.0)
    scale: float = limited(0.0, 0.0, 1.0)
    dirt: float = limited(0.0, 0.0, 1.0)
    patches: float = limited(0.0, 0.0, 1.0)
    runs: float = limited(0.0, 0.0, 1.0)
    pitting: float = limited(0.0, 0.0, 1.0)
    coatings: float = limited(0.0, 0.0, 1.0)
    wet: float = limited(0.0, 0.0, 1.0)
    condensation: float = limited(0.0, 0.0, 1.0)
    seed: int = limited(0, 0, MOST_SEED)

    def __post_init__(self) -> None:
        check_limits(self, PhotographError, "The effect {}")

    @property
    def is_any(self) -> bool:
        """Whether a photograph shows one of them."""
        return any(getattr(self, name) > 0.0 for name in EFFECTS)

    def __str__(self) -> str:
        """Return them as `effects_in` reads them."""
        return " ".join(f"{name}={value}" for name, value in asdict(self).items() if value)


EFFECTS = tuple(each.name for each in fields(Effects) if each.name != "seed")


def effects_of(amounts: Mapping[str, Any]) -> Effects:
    """Return the effects of a mapping from their names.

    Raises:
        PhotographError: a name is unknown, or an amount makes no sense.
    """
    unknown = sorted(map(str, set(amounts) - {*EFFECTS, "seed"}))
    if unknown:
        raise PhotographError(f'There is no effect "{unknown[0]}"; there are {", ".join(EFFECTS)}, and seed.')
    try:
        numbers = {name: float(value) for name, value in amounts.items()}
    except (TypeError, ValueError) as error:
        raise PhotographError(f"An effect has no number: {error}. Give 0 to 1 for each.") from None
    seed = numbers.pop("seed", 0.0)
    return Effects(**numbers, seed=int(seed) if seed.is_integer() else seed)  # type: ignore[arg-type]


def effects_in(text: str) -> Effects:
    """Return the effects of words: `dirt`, `dirt=0.5`, `all` or `all=0.5`, and `seed=3`. The last one counts.

    Raises:
        PhotographError: as `effects_of`.
    """
    amounts: dict[str, str] = {}
    for word in text.replace(",", " ").split():
        name, _, value = word.partition("=")
        value = value or "1"
        amounts.update(dict.fromkeys(EFFECTS, value) if name == "all" else {name: value})
    return effects_of(amounts)
