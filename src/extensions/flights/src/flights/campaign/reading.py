"""Reads a campaign's YAML file. An error says in one sentence what is wrong with it."""

from __future__ import annotations

import dataclasses
import difflib
from pathlib import Path
from typing import Any, Iterable, Mapping

import numpy as np

from cepa import CepaParameters
from flights.campaign.axes import CEPA_PREFIX, KINDS, SLAM_PREFIX, Axis, Value, axes_of
from flights.campaign.campaign import PATIENCE, SEEDS_MAX, Block, Campaign, Tuning
from flights.errors import CampaignError
from input_schemas import read_made

SHIPPED = Path(__file__).resolve().parents[3] / "config" / "campaigns"
_KEYS = ("kind", "seed", "seeds", "trials", "smallest", "tune")
_RANGE_KEYS = ("from", "to", "steps")
_TUNE_KEYS = ("parameters", "trials", "collision_cost", "stuck_cost")
_STEPS_MAX = 1000


def read_campaign(path: Path, smallest: bool = False, seeds: int | None = None) -> Campaign:
    """Return the campaign of a file; a bare name is one of the shipped ones.

    smallest: with what the file says under `smallest:`. seeds: replaces the file's number of seeds.

    Raises:
        CampaignError: a sentence that says what is wrong with the file.
    """
    path = located(path)
    campaign = read_made(
        path, "The campaign", lambda content: campaign_of(content, path.stem, smallest), CampaignError
    )
    return campaign if seeds is None else dataclasses.replace(campaign, seeds=seeds)


def located(path: Path) -> Path:
    """Return the file: as given, or of the shipped ones by its bare name. Raises CampaignError."""
    path = Path(path).expanduser()
    if path.is_file():
        return path
    shipped = SHIPPED / f"{path.stem}.yaml"
    if path.parent == Path(".") and shipped.is_file():
        return shipped
    names = ", ".join(sorted(file.stem for file in SHIPPED.glob("*.yaml")))
    raise CampaignError(f"There is no campaign file {path}; give a YAML file, or one of {names}.")


def campaign_of(content: Any, name: str, smallest: bool = False) -> Campaign:
    """Return the campaign that a file's content describes; raises CampaignError."""
    _mapping(content, "a campaign", _KEYS)
    content = dict(content)
    smaller = content.pop("smallest", None) or {}
    _mapping(smaller, "smallest", ("seeds", "trials", "tune"))
    if smallest:
        content = _merged(content, smaller)
    kind = content.get("kind", "flight")
    if kind not in KINDS:
        raise CampaignError(f"there is no kind {kind!r}; choose from {', '.join(KINDS)}.")
    seed, seeds = (
        _whole(key, content.get(key, default), *bounds)
        for key, default, bounds in (("seed", 1, (0, 2**63)), ("seeds", 10, (1, SEEDS_MAX)))
    )
    blocks = _blocks(content.get("trials"), axes_of(kind))
    tuning = _tuning(content["tune"]) if content.get("tune") is not None else None
    if tuning and kind != "flight":
        raise CampaignError("tune needs a campaign of the kind flight.")
    return Campaign(name, kind, blocks, seed, seeds, tuning)


def _merged(content: dict, smaller: Mapping) -> dict:
    """Let what stands in `smallest` replace seeds, single entries of each block of trials, and of tune."""
    merged = dict(content)
    for key, value in smaller.items():
        whole = content.get(key)
        if isinstance(whole, list) and isinstance(value, Mapping):
            merged[key] = [{**block, **value} if isinstance(block, Mapping) else block for block in whole]
        else:
            both = isinstance(whole, Mapping) and isinstance(value, Mapping)
            merged[key] = {**dict(whole or {}), **value} if both else value
    return merged


def _blocks(given: Any, known: Mapping[str, Axis]) -> tuple[Block, ...]:
    """Return the blocks of `trials:`: a mapping is one block, a list holds several."""
    if given == []:
        raise CampaignError("trials is an empty list.")
    blocks = tuple(_block(block, known) for block in (given if isinstance(given, list) else [given]))
    named = [{name for name, _ in b.axes if name.startswith((CEPA_PREFIX, SLAM_PREFIX))} for b in blocks]
    for name in sorted({name for names in named for name in names}):
        if not all(name in names for names in named):
            raise CampaignError(f"Only some blocks of trials name {name}; give it a value in each.")
    return blocks


def _block(given: Any, known: Mapping[str, Axis]) -> Block:
    _mapping(given, "trials", (*known, "times"))
    if "world" not in given:
        raise CampaignError("trials needs a world.")
    axes = tuple((name, _values(known[name], value)) for name, value in given.items() if name != "times")
    return Block(axes, _whole("times", given.get("times", 1), 1, SEEDS_MAX))


def _values(axis: Axis, given: Any) -> tuple[Value, ...]:
    """Return an axis's values: of one value, a list of them, or a range {from, to, steps}."""
    if isinstance(given, Mapping):
        given = _range(axis, given)
    if not isinstance(given, list):
        given = [given]
    if not given:
        raise CampaignError(f"{axis.name} has an empty list of values.")
    values = tuple(axis.checked(value) for value in given)
    if len(set(values)) < len(values):
        raise CampaignError(f"{axis.name} names a value twice.")
    return values


def _range(axis: Axis, given: Mapping) -> list:
    _mapping(given, f"the range of {axis.name}", _RANGE_KEYS)
    if set(given) != set(_RANGE_KEYS) or axis.kind not in (int, float):
        raise CampaignError(f"{axis.name} takes a value, a list, or of numbers {{from: , to: , steps: }}.")
    number = Axis(axis.name, float)
    low, high = number.checked(given["from"]), number.checked(given["to"])
    steps = _whole(f"steps of {axis.name}", given["steps"], 2, _STEPS_MAX)
    return [round(float(value), 9) for value in np.linspace(low, high, steps)]


def _tuning(given: Any) -> Tuning:
    _mapping(given, "tune", _TUNE_KEYS)
    known = axes_of("flight")
    parameters = given.get("parameters")
    tunable = [field.name for field in dataclasses.fields(CepaParameters) if isinstance(field.default, float)]
    _mapping(parameters, "parameters of tune", tuple(tunable))
    if not parameters:
        raise CampaignError("tune needs parameters to search.")
    spans = []
    for name, span in parameters.items():
        _mapping(span, f"the range of {name}", ("from", "to", "log"))
        if not {"from", "to"} <= set(span):
            raise CampaignError(f"{name} of tune needs a range, {{from: , to: }}.")
        low, high = (known[CEPA_PREFIX + name].checked(span[end]) for end in ("from", "to"))
        log = Axis("log", bool).checked(span.get("log", False))
        if not low < high or (log and low <= 0.0):
            raise CampaignError(f"The range of {name} must rise, and with log begin above 0.")
        spans.append((name, low, high, log))
    costs = {
        key: Axis(key, float, bounds=(PATIENCE, 1e6)).checked(given[key])
        for key in ("collision_cost", "stuck_cost")
        if key in given
    }
    if "trials" in given:
        costs["trials"] = _whole("trials of tune", given["trials"], 1, 100_000)
    return Tuning(tuple(spans), **costs)


def _mapping(given: Any, what: str, known: Iterable[str]) -> None:
    if not isinstance(given, Mapping):
        raise CampaignError(f"{what} must be a mapping of names to values, not {given!r}.")
    known = tuple(known)
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(str(key), known, 1)
            hint = f"did you mean {near[0]}?" if near else f"it knows {', '.join(known[:12])}."
            raise CampaignError(f"{what} knows no {key!r}; {hint}")


def _whole(what: str, given: Any, least: int, greatest: int) -> int:
    return int(Axis(what, int, bounds=(least, greatest)).checked(given))
