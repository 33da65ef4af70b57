"""What is simulated: the parameters of a `Simulation`, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Mapping

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

    world: SDF file. model: the UAV (model://name, bare name, folder or file). lidar: urg, ust, utm, puck,
    tim, m8 or None for the model as it is. model_path: folders that model:// is looked up in; None:
    GAZEBO_MODEL_PATH. spawn_pose: where the UAV stands in the world; its lowest point, not its model frame,
    is at this height. seed: of every random stream.
    lidar_range_max_m: replaces the lidar's own greatest range when positive. px4_parameters: those that
    differ from PX4's defaults, by name. time_step_s: of physics and flight controller, whole milliseconds.
    level_lidar: start with the lidar's gimbal levelling. static_models: models of the world file do not
    move, even if the file says so; models that are spawned later may. sensors: models of further sensors on
    the UAV.
    origin: where the world's origin lies on earth. wind: air streams beside those of the world.
    lidar_noise_factor: times the noise of the UAV's lidar.
    estimator: of the flight controller's stand-in: `steady` (the truth with small errors) or `ekf2` (a Kalman
    filter on simulated sensors). gnss: False: neither GNSS nor compass, as inside a steel hull; the stand-in
    then flies by external vision, always with `ekf2` (see `WITHOUT_GNSS`).
    battery: how the model's battery starts; None: it never gets empty, and the flight controller simulates
    one of its own, as PX4 SITL.
    """

    world: str
    model: str = "iris"
    lidar: str | None = "ust"
    model_path: tuple[PathLike, ...] | None = None
    spawn_pose: Pose = field(default_factory=Pose.identity)
    seed: int = 1
    lidar_range_max_m: float = 0.0
    odometry: OdometryParameters = field(default_factory=OdometryParameters)
    px4_parameters: Mapping[str, float] = field(default_factory=dict)
    time_step_s: float = 0.004
    gui: bool = False
    level_lidar: bool = False
    static_models: bool = False
    sensors: tuple[str, ...] = ()
    origin: GeodeticOrigin = field(default_factory=GeodeticOrigin)
    wind: tuple[AirStream, ...] = ()
    lidar_noise_factor: float = 1.0
    estimator: str = STEADY
    gnss: bool = True
    battery: BatteryStart | None = None

    def __post_init__(self) -> None:
        step_us_from(self.time_step_s)
        if not 0.0 <= self.lidar_noise_factor < math.inf:
            raise SimulationError(
                f"lidar_noise_factor must be finite and not negative, but is {self.lidar_noise_factor}."
            )
        if self.estimator not in ESTIMATORS:
            known = ", ".join(ESTIMATORS)
            raise SimulationError(f'estimator must be one of {known}, but is "{self.estimator}".')
        if self.seed < 0:
            raise SimulationError(f"seed must not be negative, but is {self.seed}.")


def step_us_from(time_step_s: float) -> int:
    """Return a time step in microseconds; SimulationError unless it is 1 to 8 ms in whole milliseconds."""
    step_ms = 1000.0 * time_step_s
    if not (0.999 <= step_ms <= 8.001 and math.isclose(step_ms, round(step_ms))):
        raise SimulationError(f"The time step must be 1 to 8 ms in whole milliseconds, not {step_ms:g} ms.")
    return 1000 * round(step_ms)
