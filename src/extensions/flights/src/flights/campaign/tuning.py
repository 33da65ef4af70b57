"""Searches CEPA's parameters for the best trade-off of safety and speed, over a campaign's flights.

Every set of parameters is a campaign of its own in a folder of its own, and what is tried next follows from
the campaign's seed and the values so far. So an interrupted search repeats itself from what is on disk, and
then goes on.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Mapping

import numpy as np
import optuna
import pandas as pd
import yaml
from tqdm import tqdm

from cepa import CepaError, CepaParameters
from flights.campaign.axes import CEPA_PREFIX, parameters_in
from flights.campaign.campaign import Campaign, Tuning
from flights.campaign.folder import CampaignFolder
from flights.errors import CampaignError
from flights.files import replace_file
from flights.flight.parameters import CEPA
from flights.trials.workers import Workers

TUNED, HISTORY = "cepa_tuned.yaml", "tuning.csv"
DIGITS = 4
"""Parameters are tried to so many significant digits, as a person would write them."""


def tune(campaign: Campaign, path: Path, workers: Workers, quiet: bool = False) -> str:
    """Search, and write cepa_tuned.yaml and tuning.csv into a folder; return the outcome as text.

    Raises:
        CampaignError: the campaign is not for tuning, a flight failed, or no set of parameters goes together.
    """
    tuning = _tuning_of(campaign)
    path = Path(path).expanduser()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(direction="minimize")
    study.enqueue_trial(_shipped(tuning))  # so that the search never ends with worse
    tried: list[dict] = []
    for number in tqdm(range(tuning.trials), "sets of parameters", unit=" sets", disable=quiet):
        study.sampler = _sampler(campaign.seed, number)
        trial = study.ask()
        parameters = _suggested(trial, tuning)
        found = _evaluate(campaign, parameters, path / "sets" / f"{number:04d}", workers)
        study.tell(trial, found["objective"])
        tried.append({"set": number, **parameters, **found})
        _write(path, campaign, tried)
    best = _best(tried)
    if best is None:
        raise CampaignError(f"None of the {len(tried)} sets could be flown: {tried[0]['refused']}")
    commits = {commit for row in tried for commit in (row["commits"] or "").split()}
    mixed = "Different versions of the code flew these sets, see the column commits of tuning.csv."
    return "\n".join([_outcome_in_words(tried[0], best, path), *([mixed] if len(commits) > 1 else [])])


def _tuning_of(campaign: Campaign) -> Tuning:
    if campaign.tuning is None:
        raise CampaignError(f"The campaign {campaign.name} has no `tune:` that says what to search.")
    names = {name for name, *_ in campaign.tuning.parameters}
    algorithms = campaign.values("algorithm")
    if not set(algorithms) <= {"improved", "original"}:
        raise CampaignError("Only improved and original have CEPA's parameters; tune with one of them.")
    for name in campaign.names:
        searched = name[len(CEPA_PREFIX) :] in names
        if name.startswith(CEPA_PREFIX) and (name in campaign.varied or searched):
            raise CampaignError(f"{name} is searched or varied already; give it one value, or leave it out.")
    if len(algorithms) > 1:
        raise CampaignError("One algorithm can be tuned at a time; give one.")
    return campaign.tuning


def _sampler(seed: int, number: int) -> optuna.samplers.TPESampler:
    """Return the sampler of one set, which depends on nothing but the seed and the values so far."""
    word = int(np.random.SeedSequence((seed, number)).generate_state(1)[0])
    return optuna.samplers.TPESampler(seed=word, n_startup_trials=10, multivariate=False)


def _suggested(trial: optuna.Trial, tuning: Tuning) -> dict[str, float]:
    drawn = {
        name: trial.suggest_float(name, low, high, log=log) for name, low, high, log in tuning.parameters
    }
    return {name: float(f"{value:.{DIGITS}g}") for name, value in drawn.items()}


def _shipped(tuning: Tuning) -> dict[str, float]:
    """Return the shipped values, each moved into its range."""
    return {name: min(max(getattr(CEPA, name), low), high) for name, low, high, _ in tuning.parameters}


def _evaluate(campaign: Campaign, parameters: Mapping[str, float], path: Path, workers: Workers) -> dict:
    """Fly all of the campaign with a set of parameters; return the objective and what it is made of."""
    tuning = _tuning_of(campaign)
    try:
        flown = _with(campaign, parameters)
    except CampaignError as error:  # r_lb above r_ub, ...: as bad as a collision in each flight
        worst = max(tuning.collision_cost, tuning.stuck_cost)
        rates = dict.fromkeys(("collision_rate", "stuck_rate", "time_over_straight", "commits"))
        return {"objective": worst, **rates, "refused": str(error)}
    with CampaignFolder(path, flown) as folder:
        finished = folder.fly(workers, quiet=True)
    if finished.failed:
        why = finished.failed[0].why
        raise CampaignError(
            f"A flight failed, and a search needs all flights: {why} Call again to try it anew."
        )
    trials = finished.trials
    return {
        "objective": objective(trials, tuning),
        "collision_rate": float(trials["collision"].mean()),
        "stuck_rate": float(trials["stuck"].mean()),
        "time_over_straight": float(trials.loc[trials["reached"], "time_over_straight"].mean()),
        "commits": " ".join(dict.fromkeys(trials["commit"])),
        "refused": None,
    }


def _best(tried: list[dict]) -> dict | None:
    """Return the best of the sets that could be flown, or None."""
    flown = [row for row in tried if row["refused"] is None]
    return min(flown, key=lambda row: row["objective"], default=None)


def _with(campaign: Campaign, parameters: Mapping[str, float]) -> Campaign:
    added = tuple((CEPA_PREFIX + name, (value,)) for name, value in parameters.items())
    blocks = (dataclasses.replace(block, axes=(*block.axes, *added)) for block in campaign.blocks)
    return dataclasses.replace(campaign, blocks=tuple(blocks))


def objective(trials: pd.DataFrame, tuning: Tuning) -> float:
    """Return the mean over flights of their time over the straight way's, or what a failure costs."""
    costs = np.where(trials["collision"], tuning.collision_cost, trials["time_over_straight"])
    return float(np.where(trials["stuck"], tuning.stuck_cost, costs).mean())


def dynamic_parameters(campaign: Campaign, parameters: Mapping[str, float]) -> dict:
    """Return all of CEPA's parameters as `dynparam load` sets them: by their names in Cepa.cfg."""
    fixed = parameters_in(campaign.combinations[0], CEPA_PREFIX)
    try:
        cepa = dataclasses.replace(CEPA, **{**fixed, **parameters})
    except CepaError as error:
        raise CampaignError(f"These parameters do not go together: {error}") from None
    values = {field.name: getattr(cepa, field.name) for field in dataclasses.fields(CepaParameters)}
    values["speed_fractions"] = " ".join(f"{fraction:g}" for fraction in cepa.speed_fractions)
    return {"algorithm": campaign.combinations[0]["algorithm"], **values}


def _write(path: Path, campaign: Campaign, tried: list[dict]) -> None:
    """Write what came of every set. If one could be flown, write the best set's parameters, too."""
    path.mkdir(parents=True, exist_ok=True)
    files = {HISTORY: pd.DataFrame(tried).to_csv(index=False)}
    best = _best(tried)
    if best is not None:
        files[TUNED] = _tuned(campaign, tried, best)
    for name, content in files.items():
        replace_file(path / name, content)


def _tuned(campaign: Campaign, tried: list[dict], best: Mapping) -> str:
    names = [name for name, *_ in _tuning_of(campaign).parameters]
    values = dynamic_parameters(campaign, {name: best[name] for name in names})
    shipped = "not flown" if tried[0]["refused"] else f"{tried[0]['objective']:.3f}"
    return (
        f"# CEPA as tuned by the campaign {campaign.name}, set {best['set']} of {len(tried)}: objective "
        f"{best['objective']:.3f}, shipped {shipped}.\n"
        "# rosrun dynamic_reconfigure dynparam load /cepa FILE\n"
    ) + yaml.safe_dump(values, sort_keys=False)


def _outcome_in_words(shipped: Mapping, best: Mapping, path: Path) -> str:
    def line(name: str, row: Mapping) -> str:
        if row["refused"]:
            return f"{name}: not flown. {row['refused']}"
        return (
            f"{name}: objective {row['objective']:.3f}, collisions {row['collision_rate']:.1%}, "
            f"stuck {row['stuck_rate']:.1%}, time over straight {row['time_over_straight']:.2f}"
        )

    return "\n".join((line("shipped", shipped), line(f"best, set {best['set']}", best), str(path / TUNED)))
