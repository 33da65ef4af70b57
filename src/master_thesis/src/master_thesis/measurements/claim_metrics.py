"""The metrics of the measurements that decide on the thesis's claims (`report/claims.yaml`)."""

from __future__ import annotations

from typing import Mapping

from master_thesis.report import thesis
from master_thesis.report.claims import Value, threshold_of


def build_metrics(ours: Mapping[str, float], rounds: int) -> dict[str, Value]:
    """Return the metrics of build times (s, by what was altered)."""
    times = {"one file": ours["one file"], "many files": ours["many files"]}
    theirs = {name: thesis.TABLE_8_3_S[f"full, {name}"] or 0.0 for name in times}
    return {
        "rounds": rounds,
        "one_file_s": ours["one file"],
        "many_files_s": ours["many files"],
        "from_nothing_s": ours["from nothing"],
        "many_above_one_file_s": ours["many files"] - ours["one file"],
        "from_nothing_above_many_files_s": ours["from nothing"] - ours["many files"],
        **_factors("measurement_1", times, theirs),
    }


def launch_metrics(ours: Mapping[str, dict], launches: int) -> dict[str, Value]:
    """Return the metrics of launches (startup_s, shutdown_s by what was launched)."""
    metrics: dict[str, Value] = {"launches": launches}
    both = [what for what in thesis.TABLE_8_4 if what in ours]
    if both:
        theirs = {what: sum(thesis.TABLE_8_4[what]) for what in both}
        times = {what: ours[what]["startup_s"] + ours[what]["shutdown_s"] for what in both}
        metrics["their_times"] = ", ".join(f"{seconds:g} s ({what})" for what, seconds in theirs.items())
        metrics["our_times"] = ", ".join(f"{seconds:.1f} s" for seconds in times.values())
        metrics.update(_factors("measurement_2", times, theirs))
    if "Gazebo with PX4" in ours:
        startup_s, shutdown_s = (ours["Gazebo with PX4"][what] for what in ("startup_s", "shutdown_s"))
        metrics["px4_startup_s"], metrics["px4_shutdown_s"] = startup_s, shutdown_s
        metrics["px4_shutdown_above_startup_s"] = shutdown_s - startup_s
    if {"Gazebo", "Gazebo with Rviz"} <= set(ours):
        alone_s, with_rviz_s = (ours[what]["startup_s"] for what in ("Gazebo", "Gazebo with Rviz"))
        metrics["startup_s"], metrics["startup_with_rviz_s"] = alone_s, with_rviz_s
        metrics["startup_with_rviz_above_without_s"] = with_rviz_s - alone_s
    return metrics


def _factors(section: str, ours: Mapping[str, float], theirs: Mapping[str, float]) -> dict[str, Value]:
    """Return the greatest factor between our times and the thesis's, and the too great ones in words."""
    alike, words = threshold_of(section, "greatest_factor"), []
    ratios = {name: ours[name] / theirs[name] for name in ours}
    for name, ratio in ratios.items():
        if ratio > alike:
            words.append(f"{name} {ratio:.1f} times as long")
        elif ratio < 1.0 / alike:
            words.append(f"{name} {1.0 / ratio:.1f} times as fast")
    greatest = max(max(ratio, 1.0 / ratio) for ratio in ratios.values())
    return {"greatest_factor": greatest, "differing": ", ".join(words)}
