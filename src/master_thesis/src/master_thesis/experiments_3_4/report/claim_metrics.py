"""The metrics of Experiments 3 and 4 that decide on the thesis's claims (`report/claims.yaml`)."""

from __future__ import annotations

import math
from typing import Sequence

from master_thesis.experiments_3_4.map_variants import medians
from master_thesis.experiments_3_4.report.maps import Maps, short_name
from master_thesis.report import thesis
from master_thesis.report.claims import Value
from master_thesis.report.content import listed

HOLD_LENGTH_M = 30.0
SHORT_M = 10.0
"""The range of a short-sighted lidar is at most this."""


def room_metrics(maps: Maps) -> dict[str, Value]:
    """Return the metrics of Experiment 3's maps."""
    if not maps.lidars:
        return {}
    metrics = {"flights": maps.fewest, **_truth(maps)}
    if "urg" in maps.lidars and len(maps.lidars) > 1:
        metrics.update(_seen(maps))
    if "tim" in maps.lidars:
        metrics.update(_corrected_by_the_tim(maps))
    return metrics


def _truth(maps: Maps) -> dict[str, Value]:
    untrue = [lidar for lidar in maps.lidars if not maps.is_true(lidar)]
    worst = max(maps.lidars, key=lambda lidar: maps.middle(lidar)["map_error_p95_m"])
    return {
        "maps": len(maps.lidars),
        "true_maps": len(maps.lidars) - len(untrue),
        "untrue_maps": len(untrue),
        "untrue_lidars": _named(untrue),
        "first_untrue_verdict": maps.verdict(untrue[0]) if untrue else None,
        "worst_lidar": short_name(worst),
        "worst_map_error_p95_m": maps.middle(worst)["map_error_p95_m"],
    }


def _seen(maps: Maps) -> dict[str, Value]:
    seen = {lidar: 100 * maps.middle(lidar)["wall_seen_share"] for lidar in maps.lidars}
    least = min(seen, key=seen.__getitem__)
    return {
        "urg_seen_percent": seen["urg"],
        "urg_seen_above_least_percent": seen["urg"] - seen[least],
        "most_seen_percent": max(value for lidar, value in seen.items() if lidar != "urg"),
        "least_seen_percent": seen[least],
        "least_seen_lidar": short_name(least),
    }


def _corrected_by_the_tim(maps: Maps) -> dict[str, Value]:
    middle = maps.middle("tim")
    half_way_m, end_m = middle["half_way_error_max_m"], middle["map_error_max_m"]
    return {
        "tim_half_way_error_m": half_way_m,
        "tim_end_error_m": end_m,
        "tim_end_over_half_way": _over(end_m, half_way_m),
        "tim_ate_online_m": middle["ate_online_rmse_m"],
        "tim_ate_m": middle["ate_rmse_m"],
    }


def hold_metrics(maps: Maps, tims_of_the_text: Sequence[dict] = ()) -> dict[str, Value]:
    """Return the metrics of Experiment 4's maps.

    tims_of_the_text: metrics of the maps by a TiM with the 15 m of the thesis's text.
    """
    metrics: dict[str, Value] = {"flights": maps.fewest}
    long = [lidar for lidar in maps.lidars if thesis.LIDARS[lidar].range_m >= HOLD_LENGTH_M]
    short = [lidar for lidar in maps.lidars if thesis.LIDARS[lidar].range_m <= SHORT_M]
    if long:
        metrics.update(_of_long_range(maps, long))
    if long and short:
        metrics.update(_range_compared(maps, long, short))
    if {"puck", "m8"} <= set(maps.lidars):
        metrics["puck_m8_apart_m"] = _apart_m(maps.middle("puck"), maps.middle("m8"))
    if {"tim", "utm"} <= set(maps.lidars):
        metrics.update(_bulge(maps, tims_of_the_text))
    for lidar in {"ust", "urg"} & set(maps.lidars):
        metrics.update({f"{lidar}_{name}": value for name, value in _closure(maps, lidar).items()})
    return metrics


def _of_long_range(maps: Maps, long: Sequence[str]) -> dict[str, Value]:
    untrue = [lidar for lidar in long if not maps.is_true(lidar)]
    return {
        "long_lidars": _named(long),
        "long_untrue_maps": len(untrue),
        "long_untrue_lidars": _named(untrue),
        "long_map_error_p95_m": max(maps.middle(lidar)["map_error_p95_m"] for lidar in long),
    }


def _range_compared(maps: Maps, long: Sequence[str], short: Sequence[str]) -> dict[str, Value]:
    best_short_m = min(maps.middle(lidar)["ate_rmse_m"] for lidar in short)
    worst_long_m = max(maps.middle(lidar)["ate_rmse_m"] for lidar in long)
    return {
        "short_lidars": _named(short),
        "best_short_ate_m": best_short_m,
        "worst_long_ate_m": worst_long_m,
        "best_short_over_worst_long": _over(best_short_m, worst_long_m),
    }


def _apart_m(first: dict, second: dict) -> float:
    keys = ("ate_rmse_m", "map_error_mean_m", "map_error_p95_m")
    return max(abs(first[key] - second[key]) for key in keys)


def _bulge(maps: Maps, of_text: Sequence[dict]) -> dict[str, Value]:
    tim_m, utm_m = (maps.middle(lidar)["wall_straightness_rms_m"] for lidar in ("tim", "utm"))
    of_text_m = medians(of_text)["wall_straightness_rms_m"] if of_text else None
    return {
        "tim_range_m": thesis.LIDARS["tim"].range_m,
        "tim_bent_m": tim_m,
        "utm_bent_m": utm_m,
        "tim_of_text_range_m": thesis.TIM_RANGE_IN_TEXT_M,
        "tim_of_text_bent_m": of_text_m,
        "tim_most_bent_m": max(tim_m, of_text_m or 0.0),
    }


def _closure(maps: Maps, lidar: str) -> dict[str, Value]:
    """Return a lidar's metrics without loop closure, and those with it as `closed_...`."""
    without, closed = maps.middle(lidar), maps.middle(lidar, closure=True)
    return {
        "true": maps.is_true(lidar),
        "verdict": maps.verdict(lidar),
        "ate_m": without["ate_rmse_m"],
        "map_error_p95_m": without["map_error_p95_m"],
        "closed_true": maps.is_true(lidar, closure=True),
        "closed_verdict": maps.verdict(lidar, closure=True),
        "closed_ate_m": closed["ate_rmse_m"],
        "closed_map_error_p95_m": closed["map_error_p95_m"],
        "closed_worst_ate_m": closed["ate_rmse_worst_m"],
        "closures": closed["closures"],
    }


def _over(value: float, other: float) -> float:
    return value / other if other else math.inf


def _named(lidars: Sequence[str]) -> str:
    return listed([short_name(lidar) for lidar in lidars])
