"""The topics that the node `gazebo` publishes."""

from __future__ import annotations

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from gazebo_msgs.msg import ContactsState, ModelStates
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from visualization_msgs.msg import MarkerArray

from node_tools.direct_publisher import DirectPublisher
from simulation_tools_ros.gazebo.output import Topics


def advertise_payload(name: str, message_class: type) -> rospy.Publisher:
    """Advertise a topic of a further sensor."""
    return rospy.Publisher(name, message_class, queue_size=2, tcp_nodelay=True)


def advertise_topics(holds: bool) -> Topics:
    """Advertise the simulator's topics.

    Args:
        holds: messages between two scans are sent with the second scan; lockstep allows this.
    """

    def advertise(name: str, message_class: type, latch: bool = False) -> rospy.Publisher:
        return rospy.Publisher(name, message_class, queue_size=10, latch=latch, tcp_nodelay=True)

    def stream(name: str, message_class: type) -> DirectPublisher:
        return DirectPublisher(name, message_class, queue_size=30, holds=holds)

    return Topics(
        clock=stream("/clock", Clock),
        scan=DirectPublisher("scan", LaserScan, queue_size=10),
        odometry=stream("odometry", Odometry),
        ground_truth=stream("ground_truth", Odometry),
        imu=stream("imu", Imu),
        collision=advertise("collision", ContactsState),
        joint_states=stream("~joint_states", JointState),
        model_states=advertise("~model_states", ModelStates),
        visuals=advertise("~visuals", MarkerArray, latch=True),
        performance=advertise("~performance", DiagnosticArray, latch=True),
    )
