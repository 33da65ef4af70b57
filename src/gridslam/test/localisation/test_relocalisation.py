"""A lost vehicle is found on the whole map, and only where nothing else fits as well."""

import dataclasses

import numpy as np
import pytest
from planar_world import UST, Drift, along, drive, hold, rectangle_route
from rooms import WALLS

from gridslam import PoseError, SlamParameters, se2
from gridslam.evaluation import Walls
from gridslam.localisation import relocaliser
from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession

LIDAR = dataclasses.replace(UST, beams=91)
PARAMETERS = SlamParameters(particles=5, linearUpdate=0.5, angularUpdate=0.3, srr=0.05, srt=0.05, seed=1)
DRIFT = Drift()
HOLD_WAY = rectangle_route(11.0, 6.5, 0.3)
ROOM_WAY = rectangle_route(2.0, 1.5, 0.5)


def mapped(walls, route):
    """The map of a way round a route."""
    log = drive(walls, along(route, 0.25), LIDAR, 0)
    session = SlamSession(PARAMETERS)
    for pair in zip(log.scans, log.odometry):
        session.process(*pair)
    return session.grid()


@pytest.fixture(scope="module")
def room():
    return mapped(WALLS, ROOM_WAY)


def localised(walls, grid, route, off, only=True, drift=DRIFT, seed=1):
    """Start a vehicle on a known map, ``off`` its true pose; return (states, session, error, sentences)."""
    log = drive(walls, along(route, 0.25), LIDAR, seed, drift)
    said = []
    session = SlamSession(
        PARAMETERS,
        starting_map=grid,
        starting_pose=tuple(log.truth.poses_in_map[0] + off),
        localisation_only=only,
        say=said.append,
    )
    states = []
    for scan, base in zip(log.scans, log.odometry):
        session.process(scan, base)
        states.append(session.tracking.state)
    error = se2.between(se2.compose(session.map_to_odom, log.odometry[-1]), log.truth.poses_in_map[-1])
    return states, session, error, said


@pytest.mark.table("only", [True, False])
def test_a_wrong_start_is_lost_and_then_found(room, only):
    states, _, error, said = localised(WALLS, room, ROOM_WAY, (2.5, 2.5, 0.7), only)
    assert "lost" in states[: int(10.0 / 0.25)]
    assert states[-1] == "tracking"
    assert np.hypot(*error[:2]) < 0.1
    assert [sentence.split(":")[0].split(" at ")[0] for sentence in said] == [
        "The vehicle is lost",
        "The vehicle is found again",
    ]


@pytest.mark.table("seed", range(1, 5))
def test_odometry_that_turns_badly_finds_the_place_all_the_same(room, seed):
    # Given wheels that measure turns to a tenth of a radian a metre, and a wrong start
    poor = Drift(heading_rad_per_sqrt_m=0.1, heading_rad_per_sqrt_rad=0.15)
    states, _, error, said = localised(WALLS, room, ROOM_WAY, (2.5, 2.5, 0.7), drift=poor, seed=seed)
    # Then the vehicle is found within 10 m, and nowhere else
    assert "lost" in states
    assert "tracking" in states[states.index("lost") : int(10.0 / 0.25)]
    assert np.hypot(*error[:2]) < 0.1
    assert sum("found again" in sentence for sentence in said) == 1


SMALL = Walls.from_polygons(
    [
        np.array([(-1.3, -1.1), (1.3, -1.1), (1.3, 0.4), (0.9, 0.4), (0.9, 1.1), (-1.3, 1.1)]),
        np.array([(-1.1, 0.7), (-0.8, 0.7), (-0.8, 0.95), (-1.1, 0.95)]),
    ]
)


def test_in_a_room_of_two_metres_nobody_drives_a_metre_for_each_scan():
    # Given a map of a room of 2.6 x 2.2 m, scans a metre apart, and a start 0.7 m and a radian off
    square = np.array([(-0.5, -0.5), (0.4, -0.5), (0.4, 0.3), (-0.5, 0.3), (-0.5, -0.5), (0.4, -0.5)])
    truth = along(square, 0.1)
    log = drive(SMALL, truth, LIDAR, 0)
    parameters = dataclasses.replace(PARAMETERS, linearUpdate=0.3, angularUpdate=0.5)
    mapping = SlamSession(parameters, starting_pose=tuple(truth[0]))
    for pair in zip(log.scans, log.odometry):
        mapping.process(*pair)
    parameters = dataclasses.replace(PARAMETERS, linearUpdate=1.0, angularUpdate=7.0)
    session = SlamSession(
        parameters,
        starting_map=mapping.grid(),
        starting_pose=tuple(truth[0] + (0.4, 0.6, 1.0)),
        localisation_only=True,
        say=lambda sentence: None,
    )
    # When it is lost
    session.process(log.scans[0], log.odometry[0])
    session.tracking.lose("the test says so")
    lost = []
    for pair in zip(log.scans[1:], log.odometry[1:]):
        session.process(*pair)
        lost.append(session.tracking.is_lost)
    # Then it is found where it is before it has driven 1.5 m
    way_m = np.cumsum(np.hypot(*np.diff(truth[:, :2], axis=0).T))
    assert way_m[lost.index(False)] < 1.5
    found = se2.compose(session.map_to_odom, log.odometry[-1])
    assert np.hypot(*(found - truth[-1])[:2]) < 0.1


def blocked(scan):
    """A scan before which people stand: most beams end at 0.8 m."""
    return dataclasses.replace(scan, ranges_m=np.where(np.arange(len(scan.ranges_m)) % 4, 0.8, scan.ranges_m))


@pytest.mark.table(("which", "is_found"), [((), True), ((2,), True), ((2, 3), False)])
def test_of_four_scans_one_may_contradict_the_place(room, which, is_found):
    # Given a filter on the map, and scans of a known way, of which people stand before some
    log = drive(WALLS, along(ROOM_WAY, 0.5), LIDAR, 1)
    session = SlamSession(
        PARAMETERS, starting_map=room, starting_pose=tuple(log.truth.poses_in_map[0]), localisation_only=True
    )
    session.process(log.scans[0], log.odometry[0])
    search = relocaliser.Relocaliser()
    for k in range(4):
        search.add(blocked(log.scans[k]) if k in which else log.scans[k], log.odometry[k])
    # Then the search finds the place of the newest scan if at most one contradicts it
    frame = search._unique(session.slam, log.truth.poses_in_map[3, 2])
    assert (frame is not None) == is_found
    if is_found:
        found = se2.compose(frame, search._joined.scans[-1].base)
        assert np.hypot(*(found - log.truth.poses_in_map[3])[:2]) < 0.1


def test_a_right_start_is_never_doubted(room):
    states, _, _, said = localised(WALLS, room, ROOM_WAY, (0.1, -0.05, 0.02))
    assert said == []
    assert set(states[:4]) == {"uncertain", "tracking"}
    assert set(states[4:]) == {"tracking"}


@pytest.fixture(scope="module")
def bare_hold():
    """The map of a hold that looks the same when it is turned by half a turn."""
    return mapped(hold(), HOLD_WAY)


def test_heading_tells_the_ends_of_a_hall_apart(bare_hold):
    states, _, error, _ = localised(hold(), bare_hold, HOLD_WAY[:3], (5.0, 4.9, 0.3))
    assert "lost" in states
    assert states[-1] == "tracking"
    assert np.hypot(*error[:2]) < 0.2


def test_repeating_beams_give_no_false_place(bare_hold):
    # Given a heading that does not tell the two ends apart
    states, session, _, said = localised(hold(), bare_hold, HOLD_WAY[:4], (5.0, 4.9, np.pi / 2))
    # Then the vehicle stays lost, and the search says why
    assert states[-1] == "lost"
    assert "places of the map fit the scans alike" in session.search
    assert not any("found again" in sentence for sentence in said)


@pytest.mark.table(("share", "is_rival"), [(0.95, True), (0.86, True), (0.84, False), (0.5, False)])
def test_a_place_that_fits_clearly_worse_is_no_rival(share, is_rival):
    """5 % of the beams contradict the best place, so at most 5 % + 2 x 5 % contradict a rival."""
    assert bool(relocaliser._rivals(np.array(share), 0.95)) == is_rival


def carried_away(loop_closure, said):
    """A session that has mapped a room, and the scans of another building to which the vehicle is carried."""
    flight = drive(WALLS, along(ROOM_WAY[:3], 0.25), LIDAR, 0)
    session = SlamSession(PARAMETERS, loop_closure, say=said.append)
    for pair in zip(flight.scans, flight.odometry):
        session.process(*pair)
    away = drive(hold(), along(HOLD_WAY[:3], 0.25), LIDAR, 1)
    there = se2.compose(flight.odometry[-1], se2.between(away.odometry[0], away.odometry))
    return session, [
        (dataclasses.replace(scan, stamp_s=flight.scans[-1].stamp_s + 0.5 + scan.stamp_s), base)
        for scan, base in zip(away.scans, there)
    ]


@pytest.mark.table("loop_closure", [True, False])
def test_where_a_search_is_in_vain_a_map_of_its_own_begins(loop_closure, tmp_path):
    # Given a room that was mapped, and a vehicle that is carried to another building
    said = []
    session, scans = carried_away(loop_closure, said)
    before = session.grid()
    again = None
    for index, pair in enumerate(scans):
        session.process(*pair)
        if again is not None:
            again.process(*pair)
        if index == len(scans) - 20:
            save_session(session, tmp_path / "state")
            again = load_session(tmp_path / "state", say=lambda sentence: None)
            assert session.slam.earlier is not None
    # Then it says so, and no place counts as tracked, however well the scans agree with the new map
    assert sum("not found on the map" in sentence for sentence in said) == 1
    assert not any("recognised" in sentence.split(". ")[0] for sentence in said)
    assert session.tracking.state == "uncertain"
    assert session.tracking.smoothed_share > 0.9
    # And the map of the room is as it was; it stands until the other one holds more scans
    np.testing.assert_array_equal(session.slam.earlier.grid().cells, before.cells)
    own = len(session.trajectory().stamps_s) - session.slam.earlier.scans
    assert (session.grid().size_m == before.size_m) == (session.slam.earlier.scans >= own)
    # And a state that was saved meanwhile goes on the same
    assert again.map_to_odom == session.map_to_odom
    np.testing.assert_array_equal(again.grid().cells, session.grid().cells)
    np.testing.assert_array_equal(again.slam.earlier.grid().cells, before.cells)


def test_a_given_pose_draws_the_particles_and_is_confirmed(room):
    # Given a vehicle that is tracked, and is then carried to a corner, which odometry does not see
    states, session, _, _ = localised(WALLS, room, ROOM_WAY[:2], (0.0, 0.0, 0.0))
    assert states[-1] == "tracking"
    log = drive(WALLS, along(ROOM_WAY[3:5], 0.25), LIDAR, 2)
    truth = log.truth.poses_in_map[0]
    session.place(np.add(truth, (0.1, 0.1, 0.05)), np.diag([0.04, 0.09, 0.01]))
    # Then the particles are as the covariance says
    assert session.tracking.state == "uncertain"
    spread = session.particle_poses.std(axis=0)
    assert 0.05 < spread[:2].min() < spread[:2].max() < 0.6
    # And scans bring them to the true pose
    before = se2.compose(se2.inverse(session.map_to_odom), session.slam.base_in_map)
    for i, (scan, base) in enumerate(zip(log.scans, log.odometry)):
        base = se2.compose(before, se2.between(log.odometry[0], base))
        session.process(dataclasses.replace(scan, stamp_s=1000.0 + i), base)
        assert session.tracking.state != "lost"
    assert session.tracking.state == "tracking"
    error = se2.between(se2.compose(session.map_to_odom, base), log.truth.poses_in_map[-1])
    assert np.hypot(*error[:2]) < 0.1


def test_a_search_goes_on_from_a_saved_state(room, tmp_path):
    # Given a vehicle that starts at a wrong pose of the map
    log = drive(WALLS, along(ROOM_WAY, 0.25), LIDAR, 1)
    start = {"starting_map": room, "starting_pose": tuple(log.truth.poses_in_map[0] + (2.5, 2.5, 0.7))}
    pairs, said = list(zip(log.scans, log.odometry)), []
    whole = SlamSession(PARAMETERS, localisation_only=True, say=said.append, **start)
    states, saved = [], []
    for pair in pairs:
        whole.process(*pair)
        states.append(whole.tracking.state)
        if states[-1] == "lost":  # while scans are gathered, and while a found place is being confirmed
            saved.append((len(states), tmp_path / str(len(states))))
            save_session(whole, saved[-1][1])
    assert len(saved) > 2
    # When it goes on from any state in which it is lost
    for count, path in saved:
        continued = load_session(path, say=lambda sentence: None)
        for pair, state in zip(pairs[count:], states[count:]):
            continued.process(*pair)
            # Then it is found at the same scan, and at the same place, as if it was never interrupted
            assert continued.tracking.state == state
        np.testing.assert_array_equal(continued.particle_poses, whole.particle_poses)


def test_a_new_flight_goes_on_with_a_saved_map_from_elsewhere(tmp_path):
    # Given the state of a flight round three sides of the room
    flight = drive(WALLS, along(ROOM_WAY[:4], 0.25), LIDAR, 0)
    session = SlamSession(PARAMETERS)
    for pair in zip(flight.scans, flight.odometry):
        session.process(*pair)
    save_session(session, tmp_path / "state")
    before = session.grid()
    # And a new flight, with a clock and odometry of its own, that starts at another place on that map
    said = []
    session = load_session(tmp_path / "state", said.append)
    log = drive(WALLS, along(ROOM_WAY[1:], 0.25), LIDAR, 1)
    own = se2.between(log.odometry[0], log.odometry)
    for scan, base in zip(log.scans, own):
        session.process(scan, base)
    # Then it finds itself, and both flights are in one map
    assert session.tracking.state == "tracking"
    error = se2.between(se2.compose(session.map_to_odom, own[-1]), log.truth.poses_in_map[-1])
    assert np.hypot(*error[:2]) < 0.1
    assert len(session.trajectory().stamps_s) > len(flight.scans) // 4
    assert (session.grid().cells >= 0).sum() > (before.cells >= 0).sum()


def test_poses_that_make_no_sense_are_refused_in_a_sentence(room):
    session = SlamSession(PARAMETERS, starting_map=room, localisation_only=True)
    good = np.diag([0.1, 0.1, 0.1])
    for pose, covariance, sentence in (
        ((np.nan, 0.0, 0.0), good, "finite x, y and yaw"),
        ((99.0, 0.0, 0.0), good, "outside the map"),
        ((0.0, 0.0, 0.0), -good, "negative variance"),
        ((0.0, 0.0, 0.0), np.full((3, 3), np.inf), "finite numbers"),
        ((0.0, 0.0, 0.0), np.arange(9.0).reshape(3, 3), "symmetric"),
        ((0.0, 0.0, 0.0), np.eye(2), "covariance"),
    ):
        with pytest.raises(PoseError, match=sentence):
            session.place(pose, covariance)
    with pytest.raises(PoseError, match="no map yet"):
        SlamSession(PARAMETERS).place((0.0, 0.0, 0.0), good)


def test_a_pose_given_before_the_first_scan_is_the_start(room):
    log = drive(WALLS, along(ROOM_WAY, 0.25), LIDAR, 3)
    session = SlamSession(PARAMETERS, starting_map=room, localisation_only=True)
    session.place(log.truth.poses_in_map[0] + (0.1, 0.05, 0.02), np.diag([0.04, 0.04, 0.01]))
    for scan, base in zip(log.scans[:15], log.odometry):
        session.process(scan, se2.compose((5.0, 5.0, 1.0), base))
    assert session.tracking.state == "tracking"
    here = se2.compose(session.map_to_odom, se2.compose((5.0, 5.0, 1.0), log.odometry[14]))
    assert np.hypot(*(here - log.truth.poses_in_map[14])[:2]) < 0.1
