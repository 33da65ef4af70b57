"""The headline of a run of Experiment 3 or 4."""

from __future__ import annotations

from flights.mapping.slam_metrics import verdict
from flights.results import run_summary


def headline(content: dict) -> str:
    """Return the metrics of a run of Experiment 3 or 4 in a few lines for a terminal."""
    lines = run_summary.headline(content)
    slam = content.get("slam")
    if slam is None:
        return lines
    rows = {
        "ATE, at the end, online": "{ate_rmse_m:.3f} m, {ate_online_rmse_m:.3f} m".format(**slam),
        "map error, mean, 95 %": "{map_error_mean_m:.3f} m, {map_error_p95_m:.3f} m".format(**slam),
        "true wall seen": f"{100 * slam['wall_seen_share']:.0f} %",
        "odometry alone, ATE": f"{slam['odometry_ate_rmse_m']:.2f} m",
        "loops closed": slam["closures"],
        "SLAM's cores, memory": _costs(slam),
        "the map is": verdict(slam),
        **_volume(content.get("volume")),
    }
    return "\n".join([lines, *(f"  {name:<22} {value}" for name, value in rows.items())])


def _volume(volume: dict | None) -> dict[str, str]:
    """Return the rows of the map of voxels, if there is one."""
    if volume is None:
        return {}
    mapped = volume.get("visible_surface_mapped_share")
    return {
        "voxels' error, 95 %": f"{volume['volume_error_p95_m']:.3f} m",
        "visible surface mapped": "-" if mapped is None else f"{100 * mapped:.1f} %",
    }


def _costs(slam: dict) -> str:
    share, memory = slam.get("cpu_share"), slam.get("peak_memory_mb")
    if share is None or memory is None:
        return "-"
    return f"{share:.2f}, {memory:.0f} MB"
