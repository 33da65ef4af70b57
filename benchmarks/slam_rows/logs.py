"""Bags that `gridslam_replay` maps, as a user would, and the errors of the paths that it writes."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared.results import ROOT
from gridslam import se2
from gridslam.evaluation import trajectory_error
from gridslam.evaluation.relations import read_relations, relation_errors
from gridslam.files.tum import poses_at, read_tum
from gridslam.trajectory import Trajectory

REPLAY = ROOT / "src/gridslam/nodes/gridslam_replay"
Judge = Callable[[Trajectory, Path], dict]


@dataclass(frozen=True)
class Log:
    """A bag, the file that its path is judged by, and parameters that are not gridslam's defaults.

    of_part: judges the part of a path since the first closure.
    """

    bag: str
    truth: str
    judge: Judge
    settings: Mapping[str, Any] = field(default_factory=dict)
    of_part: Judge | None = None

    def missing(self, data: Path) -> list[str]:
        """Return the names of its files that a folder does not hold."""
        return [name for name in (self.bag, self.truth) if not (data / name).exists()]

    def measure(self, data: Path, seeds: Sequence[int], loop_closure: bool) -> dict:
        """Map the bag with every seed, each in a process of its own; return the metrics' summary."""
        words = f"{self.bag}, loop closure {'on' if loop_closure else 'off'}"
        return summary([self._run(data, seed, loop_closure) for seed in tqdm(seeds, words)])

    def given(self, seed: int, loop_closure: bool) -> dict[str, Any]:
        """Return the parameters of a run by name."""
        ours = {"base_frame": "base_link", "seed": seed, "threads": 1, "loop_closure": loop_closure}
        return {**self.settings, **ours}

    def _run(self, data: Path, seed: int, loop_closure: bool) -> dict:
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, REPLAY, data / self.bag, "--output", folder]
            given = self.given(seed, loop_closure)
            command += [f"{name}:={json.dumps(value)}" for name, value in given.items()]
            subprocess.run(list(map(str, command)), check=True, capture_output=True)
            timing = json.loads(Path(folder, "timing.json").read_text(encoding="utf-8"))
            final, online = (read_tum(Path(folder, f"trajectory_{when}.tum")) for when in ("final", "online"))
        of_online = self.judge(online, data / self.truth)
        begun_s, of_part = timing["first_closure_s"] or 0.0, self.of_part or self.judge
        since = [of_part(_since(path, begun_s), data / self.truth)["ate_m"] for path in (online, final)]
        return {
            **self.judge(final, data / self.truth),
            "ate_online_since_closure_m": since[0],
            "ate_since_closure_m": since[1],
            "online_by_final_since_closure": since[0] / since[1],
            **{f"{name[:-2]}_online_m": of_online[name] for name in ("ate_m", "all_m") if name in of_online},
            "cpu_ms_per_scan": timing["cpu_ms_per_integrated_scan"],
            "cpu_ms_p95": timing["cpu_ms_per_integrated_scan_p95"],
            "peak_mb": timing["peak_mb"],
            "loops_closed": timing["loops_closed"],
        }


def summary(runs: Sequence[Mapping[str, Any]]) -> dict:
    """Return worst and median over the seeds of each length; the mean of times; the greatest memory."""
    found: dict = {"runs": len(runs)}
    for key in runs[0]:
        values = [run[key] for run in runs]
        if key.endswith("_m"):
            found[f"{key[:-2]}_worst_m"] = max(values)
            found[f"{key[:-2]}_median_m"] = float(np.median(values))
        else:
            found[key] = max(values) if key == "peak_mb" else float(np.mean(values))
    return found


def by_poses(path: Trajectory, truth: Path) -> dict:
    """Return the ATE after the best rigid alignment with lines ``t x y yaw``."""
    return {"ate_m": trajectory_error(path, _poses_of(truth), align="all").ate_rmse_m}


def by_relations(path: Trajectory, truth: Path) -> dict:
    """Return the mean errors of relations: `ate_m` of those between stamps of scans, `all_m` of all."""
    relations = read_relations(truth)
    exact = relation_errors(path, relations.exact(path.stamps_s))
    return {"ate_m": exact.translation_mean_m, "all_m": relation_errors(path, relations).translation_mean_m}


def by_the_corridor(path: Trajectory, truth: Path) -> dict:
    """Return also how wrong the way to the farthest place is, and the end's distance from its true place.

    `length_excess_m` is by how much the error of that length exceeds odometry's. `gap_m` sees the path from
    its first pose.
    """
    true = _poses_of(truth)
    way = np.hypot(*(true.poses_in_map[:, :2] - true.poses_in_map[0, :2]).T)
    far = int(way.argmax())
    found = poses_at(path, true.stamps_s[[0, far, -1]])
    error_m = abs(float(np.hypot(*(found[1] - found[0])[:2])) - float(way[far]))
    end = se2.between(found[0], found[2]) - se2.between(true.poses_in_map[0], true.poses_in_map[-1])
    return {
        **by_poses(path, truth),
        "length_error_m": error_m,
        "length_excess_m": error_m - CORRIDOR_ODOMETRY_ERROR_M,
        "gap_m": float(np.hypot(*end[:2])),
    }


def _since(path: Trajectory, begun_s: float) -> Trajectory:
    kept = path.stamps_s >= begun_s
    return Trajectory(path.stamps_s[kept], path.poses_in_map[kept])


def _poses_of(truth: Path) -> Trajectory:
    rows = np.loadtxt(truth)
    return Trajectory(rows[:, 0], rows[:, 1:])


CORRIDOR_ODOMETRY_ERROR_M = 0.69
"""m: by `corridor.bag`, odometry travels 69.69 m to the farthest place, instead of 69.00 m."""
LOGS = {
    "csail": Log("csail.bag", "csail.ref.txt.gz", by_poses),
    "aces": Log("aces.bag", "aces.ref.txt.gz", by_poses),
    "intel": Log("intel_dense.bag", "intel.relations.gz", by_relations, {"maxUrange": 40.0}),
    "corridor": Log("corridor.bag", "corridor.ref.txt.gz", by_the_corridor, of_part=by_poses),
}
"""By the name in the keys."""
