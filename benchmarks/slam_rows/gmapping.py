"""gmapping's row of a log: judged as our paths are, with three seeds at most."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping, Sequence

from tqdm import tqdm

from benchmarks.peers import gmapping
from benchmarks.peers.environments import PeerError
from benchmarks.shared.results import table
from benchmarks.slam_rows.logs import Log, summary

HEADER = ("log", "metric", "ours", "ours without loop closure", "gmapping")
COMPARED = ("ate_median_m", "ate_worst_m", "ate_online_worst_m", "cpu_ms_per_scan", "peak_mb")


def measure(program: Path, log: Log, data: Path, seeds: Sequence[int]) -> dict[str, Any]:
    """Let gmapping map a log's bag with each seed; return the summary, or why it is left out."""
    try:
        return summary([_judged(program, log, data, seed) for seed in tqdm(seeds, f"{log.bag}, gmapping")])
    except PeerError as error:
        return {"left_out": str(error)}


def _judged(program: Path, log: Log, data: Path, seed: int) -> dict[str, Any]:
    found = gmapping.map_bag(program, data / log.bag, log.settings, seed)
    online = log.judge(found.online, data / log.truth)
    return {
        **log.judge(found.final, data / log.truth),
        **{f"{name[:-2]}_online_m": online[name] for name in ("ate_m", "all_m") if name in online},
        "cpu_ms_per_scan": found.cpu_ms_per_scan,
        "peak_mb": found.peak_mb,
    }


def as_table(measured: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the table of the logs that gmapping has mapped, and the sentences of those that it has not."""
    rows, left_out = [], []
    for log, metrics in measured.items():
        theirs = metrics.get("gmapping", {})
        if "left_out" in theirs:
            left_out.append(f"{log}: {theirs['left_out']}")
        for metric in COMPARED if theirs else ():
            alone = metrics.get("without_loop_closure", {})
            values = (of.get(metric) for of in (metrics, alone, theirs))
            if metric in theirs:
                rows.append((log, metric, *("" if value is None else f"{value:.3g}" for value in values)))
    return "\n".join(filter(None, (table(HEADER, rows) if rows else "", *left_out)))
