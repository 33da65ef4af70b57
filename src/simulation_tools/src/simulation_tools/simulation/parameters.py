"""What is simulated: the parameters of a `Simulation`, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Mapping

from flight_basics.checks import check_limits, limited
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.geometry import Pose
from simulation_tools.px4.estimation.choice import ESTIMATORS, STEADY
from simulation_tools.sdf.parser import PathLike
from simulation_tools.sensors.odometry import OdometryParameters
from simulation_tools.vehicle.energy.battery import BatteryStart
from simulation_tools.vehicle.wind import AirStream


class SimulationError(SimulationToolsError):
    """The simulation cannot be built or cannot go on."""


class PhysicsDivergedError(SimulationError):
    """A body's place or speed is not finite, or absurd; only a reset helps."""


WITHOUT_GNSS: Mapping[str, float] = {
    "SYS_HAS_GPS": 0,
    "SYS_HAS_MAG": 0,
    "EKF2_AID_MASK": 24,
    "EKF2_HGT_MODE": 3,
    "EKF2_EV_DELAY": 0.0,
}
"""PX4 parameters of a UAV that flies by external vision alone: position, yaw and height."""


@dataclass(frozen=True)
class SimulationParameters:
    """What is simulated.

    Raises:
        SimulationError: a value makes no sense.
    """

    world: str
    """SDF file."""
    model: str = "iris"
    """The UAV: model://name, bare name, folder or file."""
    lidar: str | None = "ust"
    """urg, ust, utm, puck, tim, m8, or None for the model as it is."""
    model_path: tuple[PathLike, ...] | None = None
    """Folders that model:// is looked up in. None: GAZEBO_MODEL_PATH."""
    spawn_pose: Pose = field(default_factory=Pose.identity)
    """Where the UAV stands in the world. Its lowest point, not its model frame, is at this height."""
    seed: int = limited(1, 0)
    """Of every random stream."""
    lidar_range_max_m: float = 0.0
    """Replaces the lidar's own greatest range when positive, m."""
    odometry: OdometryParameters = field(default_factory=OdometryParameters)
    """How odometry drifts."""
    px4_parameters: Mapping[str, float] = field(default_factory=dict)
    """Those that differ from PX4's defaults, by name."""
    time_step_s: float = 0.004
    """Of physics and flight controller, s: whole milliseconds, 1 to 8."""
    gui: bool = False
    """Show the simulator's own window."""
    level_lidar: bool = False
    """Start with the lidar's gimbal levelling."""
    static_models: bool = False
    """Models of the world file do not move, even if the file says so. Models that are spawned later may."""
    sensors: tuple[str, ...] = ()
    """Models of further sensors on the UAV."""
    origin: GeodeticOrigin = field(default_factory=GeodeticOrigin)
    """Where the world's origin lies on earth."""
    wind: tuple[AirStream, ...] = ()
    """Air streams beside those of the world."""
    lidar_noise_factor: float = limited(1.0, 0.0)
    """Times the noise of the UAV's lidar."""
    estimator: str = STEADY
    """Of the flight controller's stand-in: `steady` (the truth with small errors) or `ekf2` (a Kalman filter
    on simulated sensors).
    """
    gnss: bool = True
    """False: neither GNSS nor compass, as inside a steel hull. The stand-in then flies by external vision,
    always with `ekf2` (see `WITHOUT_GNSS`).
    """
    battery: BatteryStart | None = None
    """How the model's battery starts. None: it never gets empty, and the flight controller simulates one of
    its own, as PX4 SITL.
    """

    def __post_init__(self) -> None:
        step_us_from(self.time_step_s)
        check_limits(self, SimulationError)
        if self.estimator not in ESTIMATORS:
            known = ", ".join(ESTIMATORS)
            raise SimulationError(f'estimator must be one of {known}, but is "{self.estimator}".')


def step_us_from(time_step_s: float) -> int:
    """Return a time step in microseconds; SimulationError unless it is 1 to 8 ms in whole milliseconds."""
    step_ms = 1000.0 * time_step_s
    if not (0.999 <= step_ms <= 8.001 and math.isclose(step_ms, round(step_ms))):
        raise SimulationError(f"The time step must be 1 to 8 ms in whole milliseconds, not {step_ms:g} ms.")
    return 1000 * round(step_ms)
