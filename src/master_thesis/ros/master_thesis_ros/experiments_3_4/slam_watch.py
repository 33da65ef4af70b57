"""Watches a SLAM node from outside: its output, its delay, its CPU time and memory."""

from __future__ import annotations

import threading
import time

import numpy as np
import rospy
from gridslam_ros.conversions import grid_of
from nav_msgs.msg import OccupancyGrid as GridMessage
from nav_msgs.msg import Path as PathMessage
from nav_msgs.srv import GetMap
from rospy.numpy_msg import numpy_msg
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from flights.mapping.slam_run import FoundAgain, SlamRun
from flights_ros.drivers.messages import planar_pose, stamp_s
from gridslam import OccupancyGrid, SlamError, se2
from gridslam.evaluation import poses_at
from gridslam.trajectory import Trajectory
from master_thesis_ros.experiments_3_4.node_process import NodeProcess
from node_tools.conversions import yaw_of
from node_tools.ending import Ending
from node_tools.services import ServiceCall

LAST_MAP_S = 10.0
"""Wall time to wait for the last map."""


class SlamWatch:
    """Keeps the output of a SLAM node until the end of the flight.

    Subscribes: map (nav_msgs/OccupancyGrid), slam_path (nav_msgs/Path), slam_processed (std_msgs/Header),
        slam_closures (visualization_msgs/Marker), /tf (map -> odom).
    Calls: dynamic_map (nav_msgs/GetMap), for the last map and path.
    """

    def __init__(self, slam_node: str, map_frame: str = "map"):
        self._lock = threading.Lock()
        self._map_frame = map_frame
        self._maps: list[tuple[float, OccupancyGrid]] = []
        self._path = Trajectory(np.zeros(0), np.zeros((0, 3)))
        self._closures: tuple = ()
        self._corrections: list[tuple] = []
        self._heard_s: dict[float, float] = {}
        self._lags_s: list[float] = []
        self._process = NodeProcess(slam_node)
        self._has_begun = threading.Event()
        self._asked = threading.Event()
        self._dynamic_map = ServiceCall("dynamic_map", GetMap, LAST_MAP_S)
        listen = rospy.Subscriber
        self._subscribers = [
            listen("map", numpy_msg(GridMessage), self._on_map, queue_size=2),
            listen("slam_path", PathMessage, self._on_path, queue_size=2),
            listen("slam_closures", Marker, self._on_closures, queue_size=2),
            listen("slam_processed", Header, self._on_processed, queue_size=100, tcp_nodelay=True),
            listen("/tf", TFMessage, self._on_tf, queue_size=100, tcp_nodelay=True),
        ]

    def on_scan(self, t_s: float) -> None:
        """Note a scan, which SLAM acknowledges later."""
        with self._lock:
            self._heard_s.setdefault(round(t_s, 6), time.perf_counter())

    @property
    def has_begun(self) -> bool:
        """Whether SLAM has published anything. It may have to compile its kernels first."""
        return self._has_begun.is_set()

    def begin(self) -> None:
        """Begin to count SLAM's CPU time, because the flight begins."""
        self._process.begin()

    def close(self, ending: Ending) -> None:
        """Ask for the last map and path, unless the process must end. Then unsubscribe."""
        threading.Thread(target=self._ask_for_the_map, daemon=True).start()  # a hung node never answers
        end = time.perf_counter() + LAST_MAP_S
        while not (self._asked.is_set() or ending.wait(0.05)) and time.perf_counter() < end:
            pass
        self._process.end()
        for subscriber in self._subscribers:
            subscriber.unregister()

    def run(self, odometry: Trajectory, half_time_s: float) -> SlamRun:
        """Return SLAM's output for the flight. odometry: of the whole flight, in `odom`.

        Raises:
            SlamError: there is no map or no path.
        """
        with self._lock:
            if not self._maps or not len(self._path.stamps_s):
                raise SlamError("SLAM gave no map or no path; see its messages above.")
            earlier = [grid for t_s, grid in self._maps if t_s <= half_time_s]
            return SlamRun(
                online=self._online(odometry),
                final=self._path,
                grid=self._maps[-1][1],
                half_way=earlier[-1] if earlier else self._maps[0][1],
                closures=self._closures,
                cpu_ms=np.zeros(0),
                scans=len(self._lags_s),
            )

    def costs(self) -> dict:
        """Return SLAM's CPU time and memory, and its delay in wall time."""
        lags_ms = 1e3 * np.array(self._lags_s)
        return {
            "cpu_share": self._process.cpu_share,
            "cpu_s": self._process.cpu_s,
            "peak_memory_mb": self._process.peak_mb,
            "lag_ms": {
                "median": float(np.median(lags_ms)),
                "p99": float(np.percentile(lags_ms, 99)),
                "max": float(lags_ms.max()),
            }
            if len(lags_ms)
            else None,
        }

    def _online(self, odometry: Trajectory) -> Trajectory:
        """Return the UAV's pose by TF at each correction of SLAM: map -> odom times the odometry's pose."""
        corrections = np.array(self._corrections).reshape(-1, 4)
        times = corrections[:, 0]
        corrections = corrections[(times >= odometry.stamps_s[0]) & (times <= odometry.stamps_s[-1])]
        stamps, first = np.unique(corrections[:, 0], return_index=True)
        return Trajectory(stamps, se2.compose(corrections[first, 1:], poses_at(odometry, stamps)))

    def _ask_for_the_map(self) -> None:
        try:
            self._on_map(self._dynamic_map().map)
            time.sleep(0.2)  # the path comes on its own topic
        except rospy.ServiceException as error:
            rospy.logwarn(f"SLAM gives no last map: {error}")
        self._asked.set()

    def _on_map(self, message: GridMessage) -> None:
        try:
            grid = grid_of(message)
        except SlamError as error:
            rospy.logwarn_throttle(5.0, f"A map is ignored: {error}")
            return
        self._has_begun.set()
        with self._lock:
            self._maps.append((stamp_s(message), grid))

    def _on_path(self, message: PathMessage) -> None:
        stamps = np.array([stamp_s(pose) for pose in message.poses])
        poses = np.array([planar_pose(pose.pose) for pose in message.poses]).reshape(-1, 3)
        with self._lock:
            self._path = Trajectory(stamps, poses)

    def _on_closures(self, message: Marker) -> None:
        """Take pairs of places on the path. The path gives the times."""
        points = np.array([(point.x, point.y) for point in message.points]).reshape(-1, 1, 2)
        with self._lock:
            path = self._path
            if not len(path.stamps_s):
                return
            nearest = np.linalg.norm(path.poses_in_map[:, :2] - points, axis=2).argmin(axis=1)
            stamps = path.stamps_s[nearest].reshape(-1, 2)
            self._closures = tuple(FoundAgain(*sorted(pair)) for pair in stamps.tolist())

    def _on_processed(self, message: Header) -> None:
        now_s = time.perf_counter()
        self._has_begun.set()
        with self._lock:
            heard_s = self._heard_s.pop(round(message.stamp.to_sec(), 6), None)
            if heard_s is not None:
                self._lags_s.append(max(now_s - heard_s, 0.0))

    def _on_tf(self, message: TFMessage) -> None:
        for transform in message.transforms:
            if transform.header.frame_id.lstrip("/") == self._map_frame:
                moved, turned = transform.transform.translation, transform.transform.rotation
                with self._lock:
                    self._corrections.append((stamp_s(transform), moved.x, moved.y, yaw_of(turned)))
