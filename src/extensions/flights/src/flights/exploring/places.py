"""Places to explore without ROS: worlds, and what the UAV is told to be there, as explore.launch has it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cepa import CepaParameters
from exploration.next_view import ExplorationParameters, ExplorerParameters
from exploration.planning import PlannerParameters
from flights.flight.course import PhaseLimits
from flights.flight.parameters import LED_CEPA, ClosedLoopParameters
from flights.launch_arguments.free_places import check_course
from flights.worlds.ballast_tank import THICK_M, BallastTankParameters
from flights.worlds.drawn.rooms import SMALL, TRAPS, Rooms, rooms_world, trap_world
from flights.worlds.scenario import Scenario
from gridslam.volume import FLAT_MISS, VolumeParameters
from inspection_tools import PositionControllerParameters
from simulation_tools.geometry import Pose
from simulation_tools.publisher import PublisherParameters
from simulation_tools.simulation import SimulationParameters

WORLDS = Path(__file__).resolve().parents[3] / "worlds"
HOLD, ROOMS, SMALL_ROOMS, TANK = "hold_3d", "rooms", "small_rooms", "ballast_tank"
ROWS = (HOLD, TANK, ROOMS, *TRAPS)
HOLD_START_M, TANK_START_M = (-9.0, 5.0, 0.0), (0.0, 0.375, 0.0)
SPEED_M_S, HOLD_SPEED_M_S = 1.5, 2.0
AHEAD_M, HOLD_AHEAD_M = 1.5, 2.5
"""A hold is wide. A faster UAV needs a longer way to brake, and so aims farther ahead."""
PLANNER = PlannerParameters(radius=0.35, margin=0.15)
EXPLORER = ExplorerParameters(
    speed=SPEED_M_S, spacing=0.6, reach=12.0, cell=1.0, worth_min=0.8, rate_min=0.5, room_min=0.5
)
HOLD_EXPLORER = replace(EXPLORER, speed=HOLD_SPEED_M_S)
SMALL_EXPLORER = replace(EXPLORER, spacing=0.4)
SMALL_PLANNER = replace(PLANNER, margin=0.1)
"""For rooms, whose doors are a few voxels wide: half a voxel less than the judge asks for."""


@dataclass(frozen=True)
class Uav:
    """model: of the UAV. lidar: on it. algorithm: of CEPA. cepa: its parameters."""

    model: str = "iris"
    lidar: str = "puck"
    algorithm: str = "dynamic"
    cepa: CepaParameters = LED_CEPA


TANK_RADIUS_M = 0.2
TANK_CEPA = replace(
    LED_CEPA,
    body_radius=TANK_RADIUS_M,
    r_lb=0.22,
    r_ub=0.4,
    emergency_lookahead=0.4,
    body_below=0.17,
    body_above=0.05,
    response_error=0.2,
)
"""As led_flight.launch has it for this radius."""
TANK_UAV = Uav("small_quad", "qt64", cepa=TANK_CEPA)
TANK_PLANNER = PlannerParameters(
    radius=TANK_RADIUS_M, margin=0.0, comfort=0.2, preference=3.0, closed_radius=0.5
)
"""It leads through the middle of a manhole: no margin is kept from the rim."""
TANK_ARRIVED_M = 0.15
TANK_EXPLORER = replace(
    EXPLORER,
    elevation_min=-0.707,
    elevation_max=0.909,
    speed=0.8,
    spacing=0.4,
    way_spacing=0.2,
    view_choice="volume",
)


@dataclass(frozen=True)
class Place:
    """A world, where the UAV starts in it, and how it explores.

    world: the text of its file, or its path. box_m: lowest and highest corner of what is judged. clearance_m:
    of what the judge counts as reachable. arrived_m, ahead_m: see ExplorationParameters.
    """

    world: str | Path
    start_m: tuple[float, float, float]
    box_m: tuple[tuple[float, float, float], tuple[float, float, float]]
    volume: VolumeParameters
    planner: PlannerParameters = PLANNER
    explorer: ExplorerParameters = EXPLORER
    clearance_m: float = PLANNER.clearance_m
    uav: Uav = Uav()
    arrived_m: float = 0.3
    ahead_m: float = AHEAD_M

    def asked(self, time_s: float) -> ExplorationParameters:
        """Return how it is explored for so long at most."""
        return ExplorationParameters(
            time_max=time_s,
            arrived=self.arrived_m,
            ahead=self.ahead_m,
            climbs_first=self.uav.algorithm != "dynamic",
            steep=True,
        )

    def written_to(self, folder: Path) -> Path:
        """Return the path of the world's file, which is written if need be."""
        if isinstance(self.world, Path):
            return self.world
        path = folder / "drawn.world"
        path.write_text(self.world)
        return path

    def loop_parameters(self, world: Path, seed: int, longest_s: float) -> ClosedLoopParameters:
        """Return the parameters of a flight without GNSS. longest_s: after it the UAV lands where it is."""
        simulation = SimulationParameters(
            str(world),
            model=self.uav.model,
            lidar=self.uav.lidar,
            sensors=("range_finder", "range_finder_up"),
            gnss=False,
            seed=seed,
            spawn_pose=Pose(self.start_m),
        )
        return ClosedLoopParameters(
            simulation,
            goal_xyz_m=None,
            algorithm=self.uav.algorithm,
            cepa=self.uav.cepa,
            range_finders=True,
            pose_source="odometry",
            limits=PhaseLimits(flight_timeout_s=longest_s),
            position_controller=PositionControllerParameters(max_speed=self.explorer.speed),
            publisher=PublisherParameters(hover_height_m=self.hover_m(world)),
        )

    def hover_m(self, world: Path) -> float:
        """Return the height over the ground to which explore.launch takes off in the place's file.

        Raises:
            ScenarioError: there is no room for the UAV.
        """
        x, y, z = self.start_m
        flown = Scenario(world.stem, world, (x, y, z, 0.0), (x, y, z), comes_home=True)
        return check_course(flown, self.uav.model, self.uav.lidar, [], self.uav.cepa.r_lb, None)


def place_of(row: str, seed: int) -> Place:
    """Return the place of a row, of `ROWS`; but for the hold it is drawn by the seed."""
    if row == HOLD:
        # With its coaming
        box_m = (-15.3, -10.3, -0.3), (15.3, 10.3, 11.4)
        return Place(
            WORLDS / "hold_3d.world",
            HOLD_START_M,
            box_m,
            VolumeParameters(resolution_m=0.2, max_range_m=20.0, miss=FLAT_MISS),
            explorer=HOLD_EXPLORER,
            ahead_m=HOLD_AHEAD_M,
        )
    fine = VolumeParameters(resolution_m=0.1, max_range_m=20.0, miss=FLAT_MISS)
    if row == TANK:
        return _ballast_tank(fine)
    rng = np.random.default_rng(seed)
    drawn = _drawn(row, rng)
    start_m = (0.0, 0.0, 0.0)
    return Place(drawn.sdf, start_m, (drawn.low_m, drawn.high_m), fine, SMALL_PLANNER, SMALL_EXPLORER)


def _drawn(row: str, rng: np.random.Generator) -> Rooms:
    if row in (ROOMS, SMALL_ROOMS):
        return rooms_world(rng, SMALL if row == SMALL_ROOMS else None)
    return trap_world(rng, row)


def _ballast_tank(volume: VolumeParameters) -> Place:
    tank, world = BallastTankParameters(), WORLDS / "ballast_tank.world"
    x_m, y_m = tank.length_m / 2 + THICK_M, tank.breadth_m / 2 + THICK_M
    box_m = (-x_m, -y_m, -THICK_M), (x_m, y_m, tank.height_m + THICK_M)
    return Place(
        world,
        TANK_START_M,
        box_m,
        volume,
        TANK_PLANNER,
        TANK_EXPLORER,
        TANK_PLANNER.clearance_m,
        TANK_UAV,
        TANK_ARRIVED_M,
    )
