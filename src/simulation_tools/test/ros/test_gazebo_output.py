"""What the node gazebo publishes and when; the real simulation, and publishers that keep what they get."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("gazebo_msgs.msg", reason="needs ROS's message packages")

from visualization_msgs.msg import Marker

from simulation_tools.geometry import Pose, rotate
from simulation_tools.sdf.parser import parse_model
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.simulation.payload import PayloadError
from simulation_tools.world.world import BodyState
from simulation_tools_ros.gazebo.markers import model_markers
from simulation_tools_ros.gazebo.output import GazeboOutput, Topics
from simulation_tools_ros.gazebo.payload_output import PayloadOutput

pytestmark = pytest.mark.ros

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
BALL = """<sdf version="1.6"><model name="ball"><link name="link">
<inertial><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
<visual name="v"><geometry><sphere><radius>0.1</radius></sphere></geometry></visual></link></model></sdf>"""


class Recorder:
    """A publisher that writes down (topic, message) in one list that all share; held back until flushed."""

    def __init__(self, name, log, holds=False):
        self._name, self._log, self._holds = name, log, holds
        self._held = []

    def publish(self, message):
        (self._held if self._holds else self._log).append((self._name, message))

    def flush(self):
        self._log += self._held
        self._held.clear()

    def get_num_connections(self):
        return 1


@pytest.fixture
def fly():
    """Returns a function: a simulation whose outputs are published to a log -> (simulation, output, log)."""
    made = []

    def build(held=(), **changes):
        simulation = Simulation(SimulationParameters(**{"world": EMPTY, **changes}))
        made.append(simulation)
        log = []
        topics = Topics(**{name: Recorder(name, log, name in held) for name in Topics.__dataclass_fields__})
        return simulation, GazeboOutput(simulation, topics), log

    yield build
    for simulation in made:
        simulation.close()


def test_an_instant_that_comes_again_has_the_same_range(fly):
    # Lockstep publishes the first instant until it is answered
    simulation, _output, log = fly(sensors=("range_finder",))
    payload = PayloadOutput(simulation.payload, lambda name, message_class: Recorder(name, log))
    for time_us in (0, 0, 0, 50_000):
        payload.publish(time_us, simulation.payload)
    first, *again, later = (message.range for name, message in log if name == "range_finder")
    assert again == [first, first]
    assert later != first  # it has noise


def test_a_sensor_without_a_message_is_refused_when_the_node_starts():
    sonar = SimpleNamespace(name="sonar_below", device=Fraction(), mount=SimpleNamespace(frame="base"))
    with pytest.raises(PayloadError, match="sensor sonar_below has no message; enter its class Fraction in"):
        PayloadOutput([sonar], lambda name, message_class: None)


def run(simulation, output, steps):
    for _ in range(steps):
        output.publish(simulation.step())


def of(log, name):
    return [message for topic, message in log if topic == name]


def test_at_a_scan_the_clock_comes_first_then_the_poses_and_the_scan_last(fly):
    simulation, output, log = fly()
    run(simulation, output, 6)
    log.clear()
    output.publish(simulation.step())  # 28 ms: a scan
    names = [name for name, _ in log]
    assert names[0] == "clock"
    assert names[-1] == "scan"
    assert names.index("odometry") < names.index("ground_truth") < names.index("scan")
    stamps = {
        message.header.stamp.to_nsec() for name, message in log if name not in ("clock", "model_states")
    }
    assert stamps == {28_000_000} == {log[0][1].clock.to_nsec()}


def test_the_clock_precedes_every_stamp(fly):
    simulation, output, log = fly(lidar="m8")
    run(simulation, output, 500)
    now = None
    for name, message in log:
        if name == "clock":
            now = message.clock
        elif hasattr(message, "header"):
            assert message.header.stamp == now, name


def test_held_back_streams_send_poses_before_the_scan_the_rest_after_it(fly):
    streams = ("clock", "odometry", "ground_truth", "imu", "joint_states")
    simulation, output, log = fly(held=streams, lidar="puck")  # 10 Hz: streams do not wait that long
    newest_us = dict.fromkeys(streams, 0)
    lags_us = []
    for _ in range(500):
        log.clear()
        output.publish(simulation.step())
        for name, message in log:
            if name in streams:
                stamp = message.clock if name == "clock" else message.header.stamp
                newest_us[name] = stamp.to_nsec() // 1000
            elif name == "scan":
                assert newest_us["odometry"] == newest_us["ground_truth"] == simulation.time_us
            elif name == "collision":
                assert newest_us["clock"] == simulation.time_us
        if "scan" in dict(log):
            assert newest_us["clock"] == simulation.time_us
        lags_us.append(simulation.time_us - newest_us["clock"])
    assert 12_000 <= max(lags_us) <= 32_000


def test_what_the_gimbal_carries_is_drawn_in_its_own_frame(fly):
    simulation, _, log = fly()
    drawn = of(log, "visuals")[-1].markers
    assert {marker.header.frame_id for marker in drawn if marker.ns == "iris"} >= {"base_frame", "hokuyo"}
    lidar = [marker for marker in drawn if marker.header.frame_id == "hokuyo"]
    link = next(link for link in simulation.uav.model.links if link.name == "hokuyo")
    assert all(marker.frame_locked for marker in lidar)
    heights_m = [visual.pose.position_m[2] for visual in link.visuals]
    assert [marker.pose.position.z for marker in lidar] == pytest.approx(heights_m)


def test_a_lasting_contact_comes_at_20_hz_and_its_end_once(fly):
    simulation, output, log = fly()
    run(simulation, output, 500)
    log.clear()
    run(simulation, output, 250)  # 1 s on the ground
    contacts = of(log, "collision")
    pairs = [{(s.collision1_name, s.collision2_name) for s in message.states} for message in contacts]
    changes = sum(a != b for a, b in zip(pairs, pairs[1:]))
    assert 18 <= len(contacts) - changes <= 21
    simulation.world.set_state("iris", BodyState(Pose((0.0, 0.0, 30.0))))
    run(simulation, output, 2)
    log.clear()
    run(simulation, output, 250)  # 1 s in the air
    assert [len(message.states) for message in of(log, "collision")] in ([], [0])


def test_the_forces_of_a_contact_add_up_to_the_weight(fly):
    simulation, output, log = fly()
    run(simulation, output, 1000)
    last = of(log, "collision")[-1]
    assert {s.collision1_name.split("::")[0] for s in last.states} == {"iris"}
    total = sum(state.total_wrench.force.z for state in last.states)
    assert total == pytest.approx(simulation.world.mass_kg("iris") * 9.80665, rel=0.05)


def test_a_model_that_moves_is_drawn_anew_and_one_that_rests_is_not(fly):
    simulation, output, log = fly()
    simulation.world.spawn(parse_model(BALL, "ball", ()), "ball", Pose((5.0, 0.0, 5.0)))
    output.publish_visuals()
    log.clear()
    run(simulation, output, 125)  # 0.5 s of falling
    drawn = of(log, "visuals")
    assert len(drawn) == pytest.approx(5, abs=1)  # 10 Hz
    heights = [marker.pose.position.z for array in drawn for marker in array.markers if marker.ns == "ball"]
    assert all(a > b for a, b in zip(heights, heights[1:]))
    assert not any(marker.action == Marker.DELETEALL for array in drawn for marker in array.markers)
    run(simulation, output, 1000)
    log.clear()
    run(simulation, output, 250)
    assert not of(log, "visuals")


WALKER = """<sdf version="1.6"><actor name="walker"><script><trajectory id="0" type="walk">
<waypoint><time>0</time><pose>5 0 1 0 0 0</pose></waypoint>
<waypoint><time>1</time><pose>7 0 1 0 0 0</pose></waypoint>
<waypoint><time>2</time><pose>9 0 1 0 0 0</pose></waypoint></trajectory></script></actor></sdf>"""


def test_an_actor_is_drawn_where_it_is_and_told_with_its_speed(fly):
    simulation, output, log = fly()
    simulation.world.spawn(parse_model(WALKER, "walker", ()), "walker", Pose())
    output.publish_visuals()
    run(simulation, output, 250)
    states = of(log, "model_states")[-1]
    index = states.name.index("walker")
    assert states.pose[index].position.x == pytest.approx(7.0, abs=1e-3)
    assert states.twist[index].linear.x == pytest.approx(2.0, abs=1e-3)
    drawn = [marker for marker in of(log, "visuals")[-1].markers if marker.ns == "walker"]
    assert [marker.pose.position.x for marker in drawn] == pytest.approx([7.0], abs=0.3)


def test_a_deleted_model_is_erased(fly):
    simulation, output, log = fly()
    simulation.world.spawn(parse_model(BALL, "ball", ()), "ball", Pose((5.0, 0.0, 5.0)))
    output.publish_visuals()
    simulation.world.delete("ball")
    output.publish_visuals()
    markers = of(log, "visuals")[-1].markers
    assert markers[0].action == Marker.DELETEALL
    assert "ball" not in {marker.ns for marker in markers}


SHAPES = """<sdf version="1.6"><model name="m"><static>true</static><link name="l"><pose>1 0 0 0 0 0</pose>
<visual name="box"><pose>0 2 0 0 0 0</pose><geometry><box><size>1 2 3</size></box></geometry>
<material><diffuse>0.1 0.2 0.3 0.5</diffuse></material></visual>
<visual name="tube"><geometry><cylinder><radius>0.5</radius><length>4</length></cylinder></geometry></visual>
<visual name="ball"><geometry><sphere><radius>0.25</radius></sphere></geometry></visual>
<visual name="wall"><geometry><plane><normal>1 0 0</normal><size>6 7</size></plane></geometry></visual>
</link></model></sdf>"""


def test_markers_have_the_sizes_and_places_of_the_visuals():
    model = parse_model(SHAPES, "shapes", ())
    box, tube, ball, wall = model_markers(model, "world", Pose((0.0, 0.0, 10.0)), moves_with_frame=False)
    assert (box.type, tube.type, ball.type) == (Marker.CUBE_LIST, Marker.CYLINDER, Marker.SPHERE)
    assert (box.scale.x, box.scale.y, box.scale.z) == (1.0, 2.0, 3.0)
    assert [(p.x, p.y, p.z) for p in box.points] == [(0.0, 0.0, 0.0)]
    assert (tube.scale.x, tube.scale.y, tube.scale.z) == (1.0, 1.0, 4.0)
    assert (ball.scale.x, ball.scale.y, ball.scale.z) == (0.5, 0.5, 0.5)
    assert (box.pose.position.x, box.pose.position.y, box.pose.position.z) == (1.0, 2.0, 10.0)
    assert (box.color.r, box.color.g, box.color.b, box.color.a) == (0.1, 0.2, 0.3, 0.5)
    assert len({(marker.ns, marker.id) for marker in (box, tube, ball, wall)}) == 4
    q = wall.pose.orientation
    np.testing.assert_allclose(rotate((q.x, q.y, q.z, q.w), (0.0, 0.0, 1.0)), (1.0, 0.0, 0.0), atol=1e-12)
    assert math.hypot(wall.scale.x - 6.0, wall.scale.y - 7.0) == 0.0


def test_a_plane_that_faces_down_is_turned_over():
    model = parse_model(SHAPES.replace("<normal>1 0 0", "<normal>0 0 -1"), "shapes", ())
    q = model_markers(model, "world", Pose(), moves_with_frame=False)[3].pose.orientation
    np.testing.assert_allclose(rotate((q.x, q.y, q.z, q.w), (0.0, 0.0, 1.0)), (0.0, 0.0, -1.0), atol=1e-12)
