"""All tests of the node mavros, which share one graph: a start costs more than most of them."""

from rostest_mavros import TestMavros
from rostest_mavros_plugins import TestMavrosPlugins
from rostest_mavros_vision import TestMavrosVision

__all__ = ["TestMavros", "TestMavrosPlugins", "TestMavrosVision"]
