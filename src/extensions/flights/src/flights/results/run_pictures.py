"""The pictures of a run's results folder: the world from above with the path, and the flight over time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flights.flight.course import Outcome, Phase
from flights.flight.description import RunDescription
from flights.flight.flight_log import HIT_THINNING, FlightLog
from flights.results import flight_pictures
from flights.results.clearance import least
from flights.results.metrics import flight_interval_s
from flights.results.picture_files import files
from flights.results.run_folder import RunFolder
from flights.results.run_summary import steering
from flights.worlds.floor_plan import Outline

FLOOR_MARGIN_M = 1.0


@dataclass(frozen=True)
class Run:
    """A flown run: its description, outcome, metrics, clearances (n, 2) and its world's outlines."""

    description: RunDescription
    log: FlightLog
    outcome: Outcome
    metrics: dict
    clearances: np.ndarray
    outlines: list[Outline]

    @property
    def interval_s(self) -> tuple[float, float]:
        """The interval from sending the goal to landing."""
        start_s, end_s = flight_interval_s(self.log, self.outcome)
        return start_s, self.outcome.times_s.get(Phase.LANDING, end_s)

    def within(self, rows: np.ndarray) -> np.ndarray:
        """Return those rows (n, k), time first, that lie within the interval."""
        start_s, end_s = self.interval_s
        return rows[(rows[:, 0] >= start_s) & (rows[:, 0] <= end_s)]


def write_pictures(folder: RunFolder, run: Run) -> None:
    """Write path_speed and path_computation (from above) and flight (over time), each as PNG, PDF and SVG.

    For a run that never flew nothing is written.
    """
    if len(run.log.between(*run.interval_s)) < 2:
        return
    speeds = run.within(run.log.speeds())
    computation = run.within(run.log.decisions.array("t_s", "computation_ms"))
    drawn = {"path_speed": flight_pictures.top_view_figure(top_view(run, speeds, "speed [m/s]"))}
    if len(computation):
        # A few slow answers of a busy machine must not use up most of the colours
        usual_ms = float(np.percentile(computation[:, 1], 98))
        view = replace(top_view(run, computation, "computation time [ms]"), value_range=(0.0, usual_ms))
        drawn["path_computation"] = flight_pictures.top_view_figure(view)
    reached_s = run.outcome.times_s.get(Phase.HOVERING)
    event = None if reached_s is None else ("goal reached", reached_s)
    drawn["flight"] = flight_pictures.time_series_figure(title(run), _panels(run, speeds, computation), event)
    for name, figure in drawn.items():
        folder.write_files(files(name, figure))


def top_view(run: Run, values: np.ndarray, label: str) -> flight_pictures.TopView:
    """Return the world from above with the path coloured by `values` (n, 2: time, value)."""
    poses = run.log.between(*run.interval_s)
    emergencies = run.within(run.log.decisions.array("t_s", "emergency"))
    times_s = emergencies[emergencies[:, 1] > 0, 0]
    scenario = run.description.scenario
    hits = run.within(run.log.hits(run.description.lidar_in_body_xyz_m))
    # When the UAV leans, beams that hit the floor would look like walls
    hits = hits[np.abs(hits[:, 3] - scenario.goal_xyz_m[2]) < FLOOR_MARGIN_M]
    return flight_pictures.TopView(
        title=title(run),
        outlines=run.outlines,
        path=np.column_stack((poses[:, 1:3], np.interp(poses[:, 0], values[:, 0], values[:, 1]))),
        value_label=label,
        start_xy=scenario.start_xyz_yaw[:2],
        goal_xy=scenario.goal_xyz_m[:2],
        hits_xy=hits[::HIT_THINNING, 1:3],
        emergencies_xy=np.column_stack([np.interp(times_s, poses[:, 0], poses[:, axis]) for axis in (1, 2)]),
        flight_height_m=scenario.goal_xyz_m[2],
    )


def _panels(run: Run, speeds: np.ndarray, computation: np.ndarray) -> tuple[flight_pictures.TimeSeries, ...]:
    reference = run.within(run.log.v_ref.array("t_s", "vx_m_s", "vy_m_s"))
    wanted = np.column_stack((reference[:, 0], np.hypot(reference[:, 1], reference[:, 2])))
    panels = [flight_pictures.TimeSeries("speed [m/s]", (("flown", speeds), ("reference", wanted)))]
    if least(run.clearances) is not None:
        panels.append(flight_pictures.TimeSeries("clearance [m]", (("nearest obstacle", run.clearances),)))
    if len(computation):
        panels.append(flight_pictures.TimeSeries("CEPA [ms]", (("computation time", computation),)))
    return tuple(panels)


def title(run: Run) -> str:
    """Return a run's metrics in one line."""
    what = run.description
    words = [f"{what.scenario.name}: {steering(what.algorithm)}, {what.lidar}, seed {what.seed}"]
    if run.metrics["flight_time_s"] is not None:
        words.append(f"{run.metrics['path_length_m']:.1f} m in {run.metrics['flight_time_s']:.1f} s")
    if least(run.clearances) is not None:
        words.append(f"least clearance {least(run.clearances):.2f} m")
    if run.metrics["collision"]:
        words.append("COLLISION")
    return " · ".join(words)
