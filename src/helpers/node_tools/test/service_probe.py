"""Calls services that answer, fail, hang, or are not there. Prints what became of each call as JSON."""

import json
import socket
import threading
import time

import rosgraph
import rospy
from std_srvs.srv import Trigger, TriggerResponse

from node_tools.services import ServiceCall

PATIENCE_S = 0.5
rospy.init_node("service_probe", disable_signals=True)
end = threading.Event()


def fails(_):
    raise rospy.ServiceException("it is broken")


def outcome(name, **how):
    """Return what a call of a service gives, and for how long it took, s."""
    began_s = time.monotonic()
    try:
        told = ServiceCall(name, Trigger, PATIENCE_S, **how)().message
    except rospy.ServiceException as error:
        told = str(error)
    return told, time.monotonic() - began_s


rospy.Service("answers", Trigger, lambda _: TriggerResponse(True, "here"))
rospy.Service("fails", Trigger, fails)
rospy.Service("hangs", Trigger, lambda _: end.wait() and TriggerResponse(True, "late"))
# A process that is stopped: the kernel takes the connection, and nobody reads
stopped = socket.create_server(("127.0.0.1", 0))
uri = f"rosrpc://127.0.0.1:{stopped.getsockname()[1]}"
rosgraph.Master("/stopped_node").registerService("/stopped", uri, "http://127.0.0.1:1")
told = {name: outcome(name) for name in ("answers", "fails", "absent")}
told |= {name: outcome(name) for name in ("hangs", "stopped")}
time.sleep(0.1)
after = [thread for thread in threading.enumerate() if "Timer" in repr(thread)]
threading.Timer(
    0.2, lambda: rospy.Service("late", Trigger, lambda _: TriggerResponse(True, "at last"))
).start()
told["late"] = outcome("late", wait_s=PATIENCE_S)
print(json.dumps({"told": told, "left": [repr(each) for each in after]}), flush=True)
end.set()
