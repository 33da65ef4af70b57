"""Two sources of one transform are found, whatever their rates; one source never is, however it is."""

import math

import numpy as np
import pytest

from input_checks.transform_senders import TransformSenders

SECONDS = 24.0


def place(time_s):
    """A vehicle on a circle of 1.5 m, once in 24 s."""
    turn = 2.0 * math.pi * time_s / SECONDS
    return np.array((1.5 * math.cos(turn), 1.5 * math.sin(turn), 1.0)), turn + math.pi / 2


def track(rate_hz, off_m=(0.0, 0.0, 0.0), turn=0.0, drift_m_s=0.0, begins_s=0.0, late_s=0.0, noise_m=0.001):
    """Poses (stamp, place, yaw) of one odometry, off by a shift, a turn and a drift along y."""
    rng = np.random.default_rng(round(1e3 * rate_hz))
    poses = []
    for time_s in np.arange(begins_s, SECONDS, 1.0 / rate_hz) + late_s:
        at, yaw = place(time_s)
        drifted = np.array((0.0, drift_m_s * time_s, 0.0))
        poses.append((time_s, at + off_m + drifted + rng.normal(0.0, noise_m, 3), yaw + turn))
    return poses


def in_turns(one, other, burst=1):
    """Both streams, so many poses of each at a time."""
    parts = max(len(one), len(other)) // burst + 1
    return [pose for k in range(parts) for each in (one, other) for pose in each[k * burst : (k + 1) * burst]]


def by_stamp(*streams):
    return sorted((pose for stream in streams for pose in stream), key=lambda pose: pose[0])


def first_found(poses, names=("",)):
    """The stamp at which two sources are found first, and what is found; None: never."""
    senders = TransformSenders()
    for index, (stamp_s, at, yaw) in enumerate(poses):
        senders.add(stamp_s, tuple(at.tolist()), yaw, names[index % len(names)])
        if senders.found is not None:
            return stamp_s, senders.found
    return None


SHIFT = (0.5, 0.0, 0.0)
TWO = {
    "equal rates": by_stamp(track(50), track(50, SHIFT, late_s=0.01)),
    "50 and 20 Hz": by_stamp(track(50), track(20, SHIFT, late_s=0.003)),
    "200 and 10 Hz": by_stamp(track(200), track(10, SHIFT, late_s=0.003)),
    "slow": by_stamp(track(5), track(5, SHIFT, late_s=0.03)),
    "equal stamps": by_stamp(track(50), track(50, SHIFT)),
    "arriving in bursts": in_turns(track(50), track(50, SHIFT, late_s=0.01), burst=10),
    "drifting slowly": by_stamp(track(50), track(50, drift_m_s=0.05, late_s=0.01)),
    "beginning late": by_stamp(track(50), track(50, SHIFT, begins_s=12.0, late_s=0.01)),
    "turned": by_stamp(track(50), track(30, turn=0.3, late_s=0.003)),
    "noisy": by_stamp(track(50, noise_m=0.02), track(30, SHIFT, late_s=0.003, noise_m=0.02)),
}


@pytest.mark.table("case", TWO)
def test_two_sources_of_one_process_are_found(case):
    stamp_s, found = first_found(TWO[case])
    begins_s = {"beginning late": 12.0}.get(case, 0.0)
    assert begins_s < stamp_s < begins_s + 6.0
    sentence = found.sentence("odom", "base_link")
    assert 'Two sources send TF "odom" -> "base_link"' in sentence
    if case == "50 and 20 Hz":
        assert found.apart_m == pytest.approx(0.5, abs=0.02)


def test_the_names_of_both_are_told():
    _, found = first_found(in_turns(track(50), track(50, SHIFT, late_s=0.01)), names=("/wheels", "/filter"))
    assert "/filter and /wheels" in found.sentence("odom", "base_link")


def jumping(rng, every, sigma_m, step=True):
    """A correction such as map -> odom, which jumps now and then and stands still between."""
    at, poses = np.zeros(3), []
    for k in range(3000):
        if k % every == 0:
            at = (at if step else np.zeros(3)) + rng.normal(0.0, sigma_m, 3)
        poses.append((0.02 * k, at.copy(), 0.0))
    return poses


def with_outliers(rng):
    return [(t, at + rng.normal(0.0, 1.0, 3) * (rng.uniform() < 0.05), yaw) for t, at, yaw in track(50)]


RNG = np.random.default_rng(1)
ONE = {
    **{f"noise of {sigma} m": track(50, noise_m=sigma) for sigma in (0.01, 0.1, 1.0)},
    "begins anew once": [(t, at - 3.0 * (t > 12.0), yaw - (t > 12.0)) for t, at, yaw in track(50)],
    "messages dropped": [pose for pose in track(50) if RNG.uniform() < 0.3],
    "sent twice": in_turns(track(50), track(50)),
    "a bag played twice": track(50) + track(50),
    "a bag that goes on later": track(50) + [(t + 30.0, at, yaw) for t, at, yaw in track(50)],
    "corrections": jumping(RNG, every=10, sigma_m=0.3),
    "corrections to and fro": jumping(RNG, every=3, sigma_m=0.1, step=False),
    "outliers": with_outliers(RNG),
    "in steps of 0.1 m": [(t, np.round(at, 1), yaw) for t, at, yaw in track(50, noise_m=0.0)],
    "turning fast": [
        (t / 50, np.array((math.cos(t / 17), math.sin(t / 10), 0.0)), t / 17) for t in range(2000)
    ],
}


@pytest.mark.table("case", ONE)
def test_one_source_is_left_in_peace(case):
    assert first_found(ONE[case]) is None


def test_two_nodes_that_send_the_same_track_do_no_harm():
    assert first_found(in_turns(track(50), track(50, late_s=0.01)), names=("/wheels", "/filter")) is None


def test_when_one_of_both_stops_the_transform_is_right_again():
    senders = TransformSenders()
    for stamp_s, at, yaw in [pose for pose in TWO["equal rates"] if pose[0] < 5.0]:
        senders.add(stamp_s, tuple(at), yaw)
    assert senders.found is not None
    for stamp_s, at, yaw in [pose for pose in track(50) if pose[0] > 5.0]:
        senders.add(stamp_s, tuple(at), yaw)
    assert senders.found is None
