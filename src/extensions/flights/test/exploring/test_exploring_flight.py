"""A UAV explores with dynamics, without GNSS. It comes home with its reserve, and when its time is over."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cepa import Reason
from exploration.energy import EnergyWatch
from exploration.next_view import End, ExplorationParameters, ExplorerParameters
from exploration.planning import PlannerParameters
from flights.errors import FlightError
from flights.exploring.flight import ExploringFlight
from flights.exploring.places import SMALL_ROOMS, place_of
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import PhaseLimits
from flights.mapping.mapping_flight import parameters_of
from gridslam.volume import VolumeParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

pytestmark = pytest.mark.flight

SETTINGS = (PlannerParameters(radius=0.35, margin=0.1), ExplorerParameters(), VolumeParameters(0.2))


def parameters(lidar, gnss=False):
    given = parameters_of("room", lidar, 2)
    return replace(
        given,
        simulation=replace(given.simulation, sensors=("range_finder",), gnss=gnss),
        mission=(),
        goal_xyz_m=None,
        pose_source="odometry",
        limits=PhaseLimits(flight_timeout_s=200.0),
    )


@pytest.mark.long
def test_between_closed_rooms_cepa_never_waits_for_a_way_that_the_planner_knows(tmp_path):
    place = place_of(SMALL_ROOMS, 3)
    with ClosedLoop(place.loop_parameters(place.written_to(tmp_path), 3, 200.0)) as loop:
        asked = ExplorationParameters(time_max=25.0, steep=True)
        ExploringFlight(loop, place.planner, place.explorer, place.volume, asked).run()
        outcome, reasons = loop.outcome, [row[5] for row in loop.log.decisions.rows]
    assert outcome.landed
    assert not outcome.collision
    assert len(reasons) > 300
    assert Reason.NO_WAY.value not in reasons


@pytest.fixture(scope="module", params=[0, pytest.param(1, marks=pytest.mark.long)])
def flown(request):
    """A flight that begins with a cold battery whose charge is hardly above the reserve.

    Returns (batteries that may be swapped, the flight, what the exploration told, outcome, true places).
    """
    swaps, given = request.param, parameters("puck")
    start = BatteryStart(charge=0.16, temperature_c=-20.0)
    given = replace(given, simulation=replace(given.simulation, battery=start))
    with ClosedLoop(given) as loop:
        asked = ExplorationParameters(time_max=8.0)
        flight = ExploringFlight(loop, *SETTINGS, asked, EnergyWatch(), swaps=swaps)
        told = flight.run()
        return swaps, flight, told, loop.outcome, loop.log.truth.array("t_s", "x_m", "y_m", "z_m")


@pytest.mark.timeout(900)  # up to two flights; on a busy machine they need long
def test_it_comes_home_with_its_reserve_and_when_its_time_is_over(flown):
    swaps, flight, told, outcome, truth = flown
    # Then it lands for want of energy, and again when its time is over
    ends = [End.BATTERY, End.TIME][: 1 + swaps]
    assert [each.end for each in flight.landings] == [end.value for end in ends]
    assert told.end is ends[-1]
    assert 0.10 < flight.landings[0].charge < 0.16
    assert outcome.success
    assert outcome.landed
    assert not outcome.collision
    for landing in flight.landings:
        assert math.dist(landing.place_m[:2], truth[0, 1:3]) < 0.8
    assert math.dist(truth[-1, 1:3], truth[0, 1:3]) < 0.8


@pytest.mark.timeout(900)
def test_it_knows_more_and_more_also_when_it_has_a_full_battery(flown):
    swaps, flight, told, _, truth = flown
    volumes = [volume for _, volume in told.known_m3]
    assert len(volumes) >= 2
    assert volumes[-1] > volumes[0] > 20.0
    if swaps:
        first, second = flight.landings
        assert second.charge > 0.9
        # It took off again and left home
        again = truth[truth[:, 0] > first.stamp_s]
        assert again[:, 3].max() > 1.0
        assert np.ptp(again[:, 1:3], axis=0).max() > 1.0
        volumes = [volume for stamp_s, volume in told.known_m3 if stamp_s > first.stamp_s]
        assert len(volumes) >= 2
        assert volumes[-1] > volumes[0] > 20.0
        assert told.views >= 2


@pytest.mark.table(("lidar", "gnss"), [("ust", False), ("puck", True)])
def test_without_clouds_or_with_gnss_it_is_refused(lidar, gnss):
    with ClosedLoop(parameters(lidar, gnss)) as loop, pytest.raises(FlightError, match="Exploration needs"):
        ExploringFlight(loop, *SETTINGS)
