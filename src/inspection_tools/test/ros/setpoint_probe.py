"""A node of a test that sends setpoints, or listens to where the position controller flies.

setpoint_probe.py sends | latches: for each line, a number x, it sends (x, 0, 2) to the controller, and prints
"sent". setpoint_probe.py listens: for each line it prints where the controller flies to. A line is such a
place, which it waits for, or "again": it waits for a controller that has started since and hears all.
"""

import sys
import time
from xmlrpc.client import ServerProxy

import rosgraph
import rosnode
import rospy
from flight_basics_ros.setpoints import SetpointSender
from geometry_msgs.msg import Point, Pose, PoseStamped

NODE, TOPIC = "/position_controller", "/pos_setpoint"
SETTLED_S = 0.5
"""In which what was sent on a connection has come."""
role = sys.argv[1]
rospy.init_node(f"probe_that_{role}", anonymous=True, disable_signals=True)
master = rosgraph.Master(rospy.get_name())


def wait_for(condition):
    while not condition():
        time.sleep(0.02)


def address():
    """Of the controller; None: there is none."""
    return rosnode.get_api_uri(master, NODE, skip_cache=True)


def hears_all_senders():
    """Whether the controller is connected to all nodes that send setpoints."""
    senders = dict(master.getSystemState()[0]).get(TOPIC, [])
    connections = ServerProxy(address()).getBusInfo(rospy.get_name())[2]
    return sum(each[2] == "i" and each[4] == TOPIC for each in connections) == len(senders)


def is_heard_by_all(publisher):
    """Whether a publisher is connected to all nodes that hear setpoints: the other senders too."""
    return publisher.get_num_connections() == len(dict(master.getSystemState()[1]).get(TOPIC, []))


class Listener:
    """Knows where the newest controller flies to."""

    def __init__(self):
        self._goals, self._connection, self._address = [], None, ""
        rospy.Subscriber(NODE + "/goal", PoseStamped, self._goals.append)

    def wait_for_another(self):
        """Wait for a controller that has started since, and hears all senders."""
        self._connection = self._goals[-1]._connection_header if self._goals else None
        before = self._address
        wait_for(lambda: address() not in (None, before))
        self._address = address()
        wait_for(hears_all_senders)
        time.sleep(SETTLED_S)

    def place(self):
        """Where it flies to. Goals of the controller before do not count."""
        told = [goal for goal in self._goals if goal._connection_header is not self._connection]
        return f"{told[-1].pose.position.x:g}" if told else "none"

    def answer(self, line):
        if line == "again":
            self.wait_for_another()
        else:
            wait_for(lambda: self.place() == line)
        return self.place()


class Sender:
    """Sends setpoints as this workspace's nodes do, or latches them."""

    def __init__(self):
        latches = role == "latches"
        publisher = rospy.Publisher("pos_setpoint", Pose, queue_size=1, latch=True) if latches else None
        self._sender = None if latches else SetpointSender()
        self._publisher = publisher or self._sender._publisher
        wait_for(hears_all_senders)
        wait_for(lambda: is_heard_by_all(self._publisher))

    def answer(self, line):
        setpoint = Pose(position=Point(float(line), 0.0, 2.0))
        if self._sender is not None:
            self._sender.send(setpoint)
        else:
            self._publisher.publish(setpoint)
        return "sent"


node = Listener() if role == "listens" else Sender()
for question in sys.stdin:
    print(node.answer(question.strip()), flush=True)
