"""The link to the camera: opens its shutter, and gives each picture to the photograph that it belongs to."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np
import roslib.message
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Float64

from flight_basics.errors import FlightBasicsError
from node_tools.services import ServiceCall

SHOOT = "simulation_tools/Shoot"
"""By its name, as rosservice does: this package builds without the simulator."""
ANSWER_S, HANGING_S = 20.0, 5.0
"""Wall time in which the shutter must answer; and after one that did not, until it answers again."""
PICTURE_S, LAST_PICTURE_S = 60.0, 20.0
"""Wall time in which the picture of a shot must come; and when the UAV waits at home for nothing else."""


class CameraError(FlightBasicsError):
    """The camera did not take the photograph."""


@dataclass(frozen=True)
class Waiting:
    """A shot whose picture is to come. what: the caller's."""

    what: Any
    since_s: float


class CameraLink:
    """One camera.

    Args:
        on_picture: called with what belongs to a shot, and its picture, uint8 (height, width, 3).
        on_lost: called with what belongs to a shot whose picture did not come.
    """

    def __init__(self, on_picture: Callable[[Any, np.ndarray], None], on_lost: Callable[[Any], None]) -> None:
        found = roslib.message.get_service_class(SHOOT)
        if found is None:
            raise CameraError(f"The service {SHOOT} is not built; build the package simulation_tools.")
        self._on_picture, self._on_lost = on_picture, on_lost
        self._shoot = ServiceCall("camera/shoot", found, ANSWER_S, wait_s=ANSWER_S)
        self._shoot_again = ServiceCall("camera/shoot", found, HANGING_S, wait_s=HANGING_S)
        self._hangs = False
        self._tilts = rospy.Publisher("camera/tilt", Float64, queue_size=1, latch=True)
        self._lock = threading.Lock()
        self._waiting: dict[int, Waiting] = {}
        self._early: dict[int, np.ndarray | None] = {}
        self._subscriber = rospy.Subscriber(
            "camera/image_raw", Image, self._on_image, queue_size=4, buff_size=1 << 27
        )

    def tilt(self, angle_rad: float) -> None:
        """Tilt the camera; pi / 2 looks straight up."""
        self._tilts.publish(angle_rad)

    def shoot(
        self, stamp_s: float, what: Callable[[Any], Any], detail_m: float = 0.0, bias_ev: float = 0.0
    ) -> Any:
        """Open the shutter; return what belongs to the shot.

        stamp_s: of the UAV's pose at which it opens, or at a later one. what: returns it, by the answer.
        detail_m, bias_ev: by which the camera exposes, see Shoot.srv.

        Raises:
            CameraError: it did not; one sentence.
        """
        try:
            shoot = self._shoot_again if self._hangs else self._shoot
            told = shoot(rospy.Time(0, round(1e9 * stamp_s)), detail_m, bias_ev)
        except (rospy.ServiceException, rospy.ROSException) as error:
            self._hangs = True
            raise CameraError(f"The camera does not answer: {error}.") from None
        self._hangs = False
        if not told.success:
            raise CameraError(f"The camera took no photograph: {told.status_message}")
        waiting = Waiting(what(told), time.monotonic())
        key = told.stamp.to_nsec()
        with self._lock:
            is_there, picture = key in self._early, self._early.pop(key, None)
            if not is_there:
                self._waiting[key] = waiting
        if is_there:
            self._take(waiting, picture)
        return waiting.what

    @property
    def waits(self) -> bool:
        """Whether a picture is still to come."""
        return bool(self._waiting)

    @property
    def awaited(self) -> list[Any]:
        """What belongs to the shots whose pictures are still to come."""
        with self._lock:
            return [waiting.what for waiting in self._waiting.values()]

    def give_up_late(self, patience_s: float = PICTURE_S) -> None:
        """Tell which pictures did not come in this wall time."""
        late_s = time.monotonic() - patience_s
        with self._lock:
            late = [key for key, waiting in self._waiting.items() if waiting.since_s < late_s]
            lost = [self._waiting.pop(key) for key in late]
        for waiting in lost:
            self._on_lost(waiting.what)

    def _on_image(self, image: Image) -> None:
        picture = None
        if image.encoding == "rgb8" and len(image.data) == image.height * image.width * 3:
            picture = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
        else:
            rospy.logwarn_throttle(
                5.0, f"A picture is cut or not rgb8: {image.width} x {image.height}, {image.encoding}."
            )
        key = image.header.stamp.to_nsec()
        with self._lock:
            waiting = self._waiting.get(key)
            if waiting is None:
                self._early = {key: picture}
        if waiting is not None:
            self._take(waiting, picture)
            with self._lock:
                self._waiting.pop(key, None)

    def _take(self, waiting: Waiting, picture: np.ndarray | None) -> None:
        """Give the picture of a shot to whom it belongs; None: it is cut."""
        if picture is None:
            self._on_lost(waiting.what)
        else:
            self._on_picture(waiting.what, picture)
