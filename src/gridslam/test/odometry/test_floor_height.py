"""Height over the floor of the start: boxes below are no climb."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gridslam.odometry.body_sensors import BodySensors
from gridslam.odometry.floor_height import RISEN_OFF_M, FloorHeight
from gridslam.odometry.parameters import LidarOdometryParameters

IMU_S, RANGE_EVERY = 0.01, 5
DOWN_XYZW = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def fly(height_at, floor_at, seconds: float, bias: float = 0.0, seed: int = 1, finder=lambda t, h: h):
    """Fly heights over floors; return (n, 4) time, estimated height, climb, and true height."""
    rng, floor, rows, d = np.random.default_rng(seed), FloorHeight(LidarOdometryParameters()), [], 1e-3
    for k in range(int(seconds / IMU_S)):
        t = k * IMU_S
        up = (height_at(t + d) - 2 * height_at(t) + height_at(t - d)) / d**2
        floor.on_acceleration(t, up + bias)
        if k % RANGE_EVERY == 0:
            reading = finder(t, height_at(t) - floor_at(t) + 0.01 * rng.standard_normal())
            if reading is not None:
                floor.on_range(t, round(reading, 2))
        rows.append((t, *floor.at(t)[:2], height_at(t)))
    return np.array(rows), floor


def hover(t: float) -> float:
    return 2.0


def climb(t: float) -> float:
    return 1.0 + 0.5 * math.sin(0.8 * t)


@pytest.mark.table("height_at", [hover, climb])
@pytest.mark.table("bias", [0.0, 0.15])
def test_it_follows_the_height_over_flat_ground(height_at, bias):
    rows, _ = fly(height_at, lambda t: 0.0, 15.0, bias)
    late = rows[rows[:, 0] > 5.0]
    assert np.percentile(np.abs(late[:, 1] - late[:, 3]), 95) < 0.025
    slope = np.gradient(late[:, 3], IMU_S)
    assert np.sqrt(np.mean((late[:, 2] - slope) ** 2)) < 0.05


@given(st.floats(0.3, 1.0), st.floats(0.3, 3.0))
@settings(max_examples=20)
def test_a_box_below_is_no_climb(box_m, width_s):
    rows, floor = fly(climb, lambda t: box_m if 4.0 <= t < 4.0 + width_s else 0.0, 9.0)
    late = rows[rows[:, 0] > 3.0]
    assert np.abs(late[:, 1] - late[:, 3]).max() < 0.08
    # A climb command of 1/s times the error stays below 0.3 m/s with a wide margin.
    assert np.abs(late[:, 2] - np.gradient(late[:, 3], IMU_S)).max() < 0.2
    assert floor.floor_m == 0.0  # the floor of before is recognised, without drift


def test_a_box_shows_as_another_floor():
    _, floor = fly(hover, lambda t: 0.5 if t >= 3.0 else 0.0, 5.0)
    assert floor.floor_m == pytest.approx(0.5, abs=0.04)


@pytest.mark.table("seed", range(4))
@pytest.mark.table(("rate_m_s", "sunk_m"), [(0.15, 1.0), (0.08, 0.8)])
def test_a_floor_that_sinks_too_slowly_for_a_step_is_found_out_by_clouds(seed, rate_m_s, sunk_m):
    """Over a slope the readings grow bit by bit, as in a climb. Clouds tell that the height stays."""
    rng, floor, told_m = np.random.default_rng(seed), FloorHeight(LidarOdometryParameters()), []
    for k in range(int(20.0 / IMU_S)):
        t = k * IMU_S
        floor.on_acceleration(t, 0.0)
        if k % RANGE_EVERY == 0:
            below_m = 2.0 + min(sunk_m, max(0.0, rate_m_s * (t - 3.0)))
            floor.on_range(t, round(below_m + 0.01 * rng.standard_normal(), 2))
            floor.on_height(t, 2.0 + 0.008 * rng.standard_normal(), 0.05**2)
        told_m.append(floor.at(t)[0])
    assert max(told_m) < 2.0 + 0.4 * sunk_m
    assert told_m[-1] == pytest.approx(2.0, abs=0.08)


@pytest.mark.table("seed", range(8))
def test_an_edge_whose_readings_slide_past_other_floors_is_no_climb(seed):
    """The beam of a tilted UAV slides down the side of a sill of 0.8 m, past the height of a stiffener."""
    rng = np.random.default_rng(seed)
    slide_m = np.sort(rng.uniform(0.02, 0.7, 4))[::-1]

    def height_at(t: float) -> float:
        return 1.36 - 0.1 * math.sin(1.3 * t)

    def floor_at(t: float) -> float:
        past = int((t - 6.2) / (RANGE_EVERY * IMU_S))
        if t >= 6.2:
            return float(slide_m[past]) if past < len(slide_m) else 0.0
        return 0.8 if t >= 6.0 else 0.14 * (3.0 <= t < 4.0)

    rows, floor = fly(height_at, floor_at, 9.0, seed=seed)
    after = rows[rows[:, 0] > 6.5]
    assert np.abs(after[:, 1] - after[:, 3]).max() < 0.05
    assert floor.floor_m == pytest.approx(0.0, abs=0.03)


def test_the_edge_of_a_box_that_comes_into_sight_little_by_little_is_no_climb():
    off_m = np.array([beside_a_box(seed) for seed in range(20)])
    assert off_m.max() < 0.12
    assert off_m[:, -200:].mean() < 0.018


def beside_a_box(seed: int, height_m: float = 2.0, box_m: float = 1.0) -> np.ndarray:
    """Return how far the height is off. Beams slide up a box's side; the UAV hovers and sways a little."""
    rng, floor, off_m = np.random.default_rng(seed), FloorHeight(LidarOdometryParameters()), []
    phases = rng.uniform(0.0, 2.0 * math.pi, 2)
    for k in range(int(12.0 / IMU_S)):
        t = k * IMU_S
        floor.on_acceleration(t, 0.0)
        if k % RANGE_EVERY == 0:
            apart_m = 0.06 - 0.01 * (t - 4.0) + 0.01 * math.sin(2.0 * t + phases[0])
            lean_rad = math.radians(0.3 * math.sin(1.7 * t + phases[1]) + 0.1 * rng.standard_normal())
            below_m = over_an_edge(apart_m, lean_rad, height_m, box_m)
            floor.on_range(t, round(below_m + 0.01 * rng.standard_normal(), 2))
            floor.on_height(t, height_m + 0.008 * rng.standard_normal(), 0.05**2)
        off_m.append(abs(floor.at(t)[0] - height_m))
    return np.array(off_m)


def over_an_edge(apart_m: float, lean_rad: float, height_m: float, box_m: float) -> float:
    """Return the least of three beams at a height, so far beside a box; it leans towards the box."""
    if apart_m <= 0.0:
        return height_m - box_m
    slopes = [math.tan(math.radians(angle) + lean_rad) for angle in (-1.0, 0.0, 1.0)]
    on_side_m = [apart_m / slope for slope in slopes if slope > 0.0]
    return float(np.clip(min(on_side_m, default=height_m), height_m - box_m, height_m))


def over_stiffeners(t: float, h: float) -> float:
    """Return the least of three beams that cross stiffeners of 0.15 x 0.03 m every 0.75 m, at 0.6 m/s."""
    beams_m = [0.6 * t + 0.375 + math.tan(math.radians(angle)) * h for angle in (-1.0, 0.0, 1.0)]
    return h - 0.15 * any(abs(math.remainder(beam_m, 0.75)) < 0.015 for beam_m in beams_m)


@pytest.mark.table("seed", [1, 2, 3])
def test_stiffeners_crossed_in_climb_and_descent_do_not_add_up(seed):
    def wave(t: float) -> float:
        return 2.2 - 1.5 * math.cos(0.6 * t)

    rows, floor = fly(wave, lambda t: 0.0, 40.0, seed=seed, finder=over_stiffeners)
    off_m = np.abs(rows[100:, 1] - rows[100:, 3])
    assert np.percentile(off_m, 95) < 0.05
    assert off_m.max() < 0.2
    assert floor.floor_m == pytest.approx(0.0, abs=0.2)


def test_a_floor_that_comes_into_sight_late_is_no_jump_of_a_height_that_is_known():
    # Given a height that something else has told, and a range finder that was silent since the start
    floor = FloorHeight(LidarOdometryParameters())
    for k in range(40):
        floor.on_height(0.05 * k, 0.0, 1e-6)
    # When the range finder begins to tell another one
    for k in range(40, 60):
        floor.on_range(0.05 * k, 0.3)
    # Then the floor lies that much below
    assert floor.at(3.0)[0] == pytest.approx(0.0, abs=0.03)
    assert floor.floor_m == pytest.approx(-0.3, abs=0.03)


def test_too_close_for_the_range_finder_is_a_height_too():
    sensors = BodySensors(LidarOdometryParameters())
    for k in range(20):
        sensors.on_range(0.05 * k, -math.inf, (0.05, 40.0), ((0.0, 0.0, -0.055), DOWN_XYZW))
    assert sensors.height.is_known_at(1.0)
    assert sensors.height.at(0.95)[0] == pytest.approx(0.08, abs=0.01)


def test_one_wrong_reading_changes_nothing():
    rows, floor = fly(hover, lambda t: 0.0, 5.0, finder=lambda t, h: 0.3 if abs(t - 3.0) < 1e-6 else h)
    assert np.abs(rows[300:, 1] - 2.0).max() < 0.03
    assert floor.floor_m == 0.0


@pytest.mark.table("silent_s", [0.0, 1.5])
@pytest.mark.table("shock", [50.0, -50.0])
def test_a_shock_is_no_step_of_the_floor(shock, silent_s):
    # Given a touchdown that the accelerometer sees as 50 m/s2 for 20 ms, and nothing to balance it
    floor, heights_m = FloorHeight(LidarOdometryParameters()), []
    for k in range(300):
        # When the IMU is silent from the shock on
        if not 102 <= k < 102 + silent_s / IMU_S:
            floor.on_acceleration(k * IMU_S, shock if 100 <= k < 102 else 0.0)
        if k % RANGE_EVERY == 0:
            floor.on_range(k * IMU_S, 0.12)
        heights_m.append(floor.at((k + 0.9) * IMU_S)[0])
    # Then the range finder holds the height. The shock counts for 0.05 s at most, which is 2.5 m/s, and a
    # reading comes every 0.05 s.
    assert np.abs(np.array(heights_m) - 0.12).max() < 0.25
    assert floor.at(3.0)[0] == pytest.approx(0.12, abs=0.02)
    assert floor.floor_m == 0.0


def test_an_edge_that_comes_into_the_cone_little_by_little_close_below_is_no_shock():
    """As over the sill of a manhole: each reading is nearer than the one before, the last below 0.5 m."""
    floor, heights_m = FloorHeight(LidarOdometryParameters()), []
    for k in range(300):
        floor.on_acceleration(k * IMU_S, 0.0)
        if k % RANGE_EVERY == 0:
            sill = (0.76, 0.485, 0.395)[min(k // RANGE_EVERY - 40, 2)] if k >= 40 * RANGE_EVERY else 1.06
            floor.on_range(k * IMU_S, sill)
        heights_m.append(floor.at(k * IMU_S)[0])
    assert np.abs(np.array(heights_m) - 1.06).max() < 0.05
    assert floor.floor_m == pytest.approx(1.06 - 0.395, abs=0.05)


def test_without_readings_the_height_is_not_known():
    _rows, floor = fly(hover, lambda t: 0.0, 6.0, finder=lambda t, h: None if t > 3.0 else h)
    assert not floor.is_known_at(6.0)
    floor.on_range(6.0, 1.7)
    assert floor.is_known_at(6.0)
    assert floor.at(6.0)[0] == pytest.approx(1.7)


@given(st.floats(0.01, 0.3), st.floats(0.0, 0.9), st.floats(-3.0, 3.0))
def test_the_variance_after_an_imu_pause_is_that_of_the_filters_steps(late_s, pause_s, up):
    # Given a flight in which the range finder comes some time after the IMU
    floor = FloorHeight(LidarOdometryParameters())
    for k in range(8):
        floor.on_acceleration(0.1 * k, up)
        floor.on_range(0.1 * k + min(late_s, 0.09), 2.0)
    # When the IMU is silent, and when it then says something: the filter steps to that time
    stamp_s = 0.8 + pause_s
    predicted, floor_then = floor.at(stamp_s), copy.deepcopy(floor)
    floor_then.on_acceleration(stamp_s, 0.0)
    # Then height and climb are the same both ways, and so is the variance
    assert predicted == pytest.approx(floor_then.at(stamp_s), rel=1e-9, abs=1e-12)
    assert predicted[2] > 0.0


def test_the_height_before_the_imus_last_reading_has_a_variance_too():
    floor = FloorHeight(LidarOdometryParameters())
    for k in range(50):
        floor.on_acceleration(0.02 * k, 0.3)
        floor.on_range(0.02 * k, 2.0)
    assert all(floor.at(0.98 - past_s)[2] > 0.0 for past_s in (0.0, 0.02, 0.2, 2.0))


def test_an_acceleration_is_that_of_the_time_up_to_its_stamp():
    """An IMU tells the mean of the last 20 ms. Counted forward, a take-off at 5 m/s2 would be 0.04 m late."""
    floor = FloorHeight(LidarOdometryParameters())
    for k in range(1, 101):
        floor.on_acceleration(0.02 * k, 0.0)
        floor.on_range(0.02 * k, 0.5)
    for k in range(101, 121):
        floor.on_acceleration(0.02 * k, 5.0)
    height_m, climb_m_s, _ = floor.at(2.4)
    assert height_m == pytest.approx(0.5 + 0.5 * 5.0 * 0.4**2, abs=0.005)
    assert climb_m_s == pytest.approx(5.0 * 0.4, abs=0.02)


def test_a_cloud_whose_map_jumps_does_not_move_a_height_that_the_range_finder_tells():
    """A cloud meets surfaces that were entered 0.2 m too high. Range finder and IMU tell of no move."""
    rng, floor = np.random.default_rng(3), FloorHeight(LidarOdometryParameters())
    for k in range(400):
        t = 0.05 * k
        floor.on_acceleration(t, 0.0)
        floor.on_range(t, round(2.0 + 0.01 * rng.standard_normal(), 2))
        told_m = 2.0 + (0.2 if k >= 200 else 0.0) + 0.02 * rng.standard_normal()
        floor.on_height(t, told_m, 0.05**2)
        assert floor.at(t)[0] == pytest.approx(2.0, abs=0.05)
    assert floor.floor_m == 0.0
    assert floor.map_m > 0.1


def test_over_a_slope_clouds_tell_the_height_and_the_range_finder_the_floor():
    """For 4 s the floor rises by 1.6 m, and the UAV 2 m above it. Then the range finder tells the height."""
    floor, before_m = FloorHeight(LidarOdometryParameters()), 0.0
    for k in range(1200):
        t = 0.01 * k
        turn = 0.5 * math.pi * min(max(t - 3.0, 0.0), 4.0)
        risen_m = 1.6 * (turn - math.sin(turn)) / (2.0 * math.pi)
        floor.on_acceleration(t, 0.2 * math.pi * math.sin(turn))
        if k % 5 == 0:
            floor.on_slope(t, 3.0 <= t < 7.0, risen_m - before_m)
            before_m = risen_m
            floor.on_range(t, 2.0)
            floor.on_height(t, 2.0 + risen_m, 1e-4)
        if t > 2.0:
            assert floor.at(t)[0] == pytest.approx(2.0 + risen_m, abs=0.04)
            assert floor.floor_m == pytest.approx(risen_m, abs=0.06)
            assert floor.wrong_m == 0.0
    assert floor.at(12.0)[0] == pytest.approx(3.6, abs=0.02)


def test_a_floor_that_rises_where_no_slope_was_flown_up_tells_that_the_height_is_wrong():
    """A UAV hovers 2 m over the floor, from 4 to 12 s beside a rim that the map takes for a slope.

    Clouds see walls alone: they tell the height that was predicted, and a little more each time.
    """
    floor = FloorHeight(LidarOdometryParameters())
    for k in range(1200):
        t = 0.01 * k
        floor.on_acceleration(t, 0.0)
        if k == 400:
            floor.on_slope(t, True)
        if k % 5 == 0:
            floor.on_range(t, 2.0)
            off_m = abs(floor.at(t)[0] - 2.0)
            assert floor.wrong_m == pytest.approx(off_m if off_m > RISEN_OFF_M else 0.0, abs=0.06)
            floor.on_height(t, floor.at(t)[0] + floor.map_m + 0.02 * floor.is_sloping, 1e-3)
    assert floor.wrong_m > 1.0
    floor.on_slope(12.0, False)
    for k in range(40):  # a deck: nothing tells that the height is right
        floor.on_range(12.0 + 0.05 * k, 1.2)
    assert floor.wrong_m > 1.0
    start_m = floor.at(14.0)[0]
    for k in range(40):  # the floor of the start, as high as it was
        floor.on_range(14.0 + 0.05 * k, start_m)
    assert floor.wrong_m == 0.0


def test_the_edge_of_a_deck_that_passed_for_a_slope_ends_it():
    """A UAV hovers at 10.1 m, from 4 s on over a deck. From 7.6 s on the map takes its rim for a slope.

    There clouds see walls alone: they tell the height that was predicted, and sink a little each time. At 8 s
    the deck is left behind.
    """
    floor = FloorHeight(LidarOdometryParameters())
    for k in range(1200):
        t = 0.01 * k
        floor.on_acceleration(t, 0.0)
        if k in (760, 900):
            floor.on_slope(t, k == 760)
        if k % 5 == 0:
            floor.on_range(t, 1.9 if 400 <= k < 800 else 10.1)
            floor.on_height(t, floor.at(t)[0] + floor.map_m + 0.02 * floor.is_sloping, 1e-3)
        if t > 8.5:
            assert floor.at(t)[0] == pytest.approx(10.1, abs=0.05)
            assert floor.floor_m == pytest.approx(0.0, abs=0.01)
