"""Which stamps a node takes, told by hand: ROS time and wall time are set."""

import pytest

pytestmark = pytest.mark.ros

WHY = "needs the workspace's environment: source devel/setup.bash"
rospy = pytest.importorskip("rospy", reason=WHY)
stamp_watch = pytest.importorskip("node_tools.stamp_watch", reason=WHY)


class Clocks:
    """ROS time as /clock would set it, and the wall time at which it is looked at."""

    def __init__(self):
        self.wall_s, self.ros_s = 1000.0, 0.0

    def set(self, ros_s, after_wall_s=0.025):
        self.wall_s += after_wall_s
        self.ros_s = ros_s


class Said:
    """The warnings."""

    def __init__(self):
        self.sentences = []

    def say(self, sentence):
        self.sentences.append(sentence)


@pytest.fixture
def clocks(monkeypatch):
    clocks = Clocks()
    monkeypatch.setattr(stamp_watch.time, "monotonic", lambda: clocks.wall_s)
    monkeypatch.setattr(stamp_watch.rospy.Time, "now", lambda: rospy.Time.from_sec(clocks.ros_s))
    return clocks


@pytest.fixture
def said():
    return Said()


@pytest.fixture
def watch(clocks, said):
    return stamp_watch.StampWatch(said)


def is_ahead(watch, stamp_s):
    return watch.is_ahead(rospy.Time.from_sec(stamp_s), "scan")


def test_a_stamp_far_ahead_of_a_running_clock_is_dropped(watch, clocks, said):
    for ros_s in (5.0, 5.025):
        clocks.set(ros_s)
        assert not is_ahead(watch, ros_s + 0.004)
    assert is_ahead(watch, 1.8e9)
    assert is_ahead(watch, 6.03)
    assert not is_ahead(watch, 6.02)
    assert said.sentences[1].startswith("The scan is stamped 1.005 s ahead of ROS time and dropped")


def test_before_the_first_clock_every_stamp_is_taken(watch):
    assert not is_ahead(watch, 1.8e9)
    assert not is_ahead(watch, 1.8e9 + 0.025)


def test_a_bag_played_while_an_ended_simulations_clock_stands_still(watch, clocks):
    clocks.set(49.975)
    is_ahead(watch, 49.975)
    clocks.set(50.0)
    is_ahead(watch, 50.0)
    clocks.set(50.0, after_wall_s=2.0)
    assert not is_ahead(watch, 70.0)


def test_a_clock_that_is_reset_takes_what_is_stamped_by_either(watch, clocks, said):
    clocks.set(99.975)
    is_ahead(watch, 99.975)
    clocks.set(100.0)
    assert not is_ahead(watch, 0.0)  # it came before the /clock of its instant
    clocks.set(0.0)
    assert not is_ahead(watch, 0.0)
    clocks.set(0.025)
    assert not is_ahead(watch, 0.025)
    assert is_ahead(watch, 100.0)  # a straggler of the old time
    assert len(said.sentences) == 1
