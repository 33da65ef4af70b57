"""The link to a node that marks defects: gives it the photographs, and keeps what it marks beside them."""

from __future__ import annotations

import queue
import threading
import time
from pathlib import Path
from typing import Callable

import rospy

from flight_basics.errors import FlightBasicsError
from inspection.findings.remembered import read_marks, write_marks
from inspection.msg import Candidates, Photograph
from inspection.photographs.calibration import read_camera
from inspection_ros.photograph_messages import candidates_of, photograph_message

PATIENCE_S, NO_PATIENCE_S = 60.0, 5.0
"""Wall time for an answer; and after one that did not come, until one comes again."""
LOOK_S = 0.2


class DetectorLink:
    """Gives photographs to a detector, one after the other. A photograph that is marked already is left out.

    A photograph stays with its surface, and with whoever waits for it: meanwhile another survey may begin.

    Publishes: photographs (inspection/Photograph).
    Subscribes: candidates (inspection/Candidates).

    Args:
        frame: of the photographs' poses. say: told what goes wrong.

    Attributes:
        marked: number of photographs.
    """

    def __init__(self, frame: str, say: Callable[[str], None]) -> None:
        self._frame, self._say = frame, say
        self.marked = 0
        self._patience_s = PATIENCE_S
        self._due: queue.Queue[tuple[Path, str, Callable[[Path], None]]] = queue.Queue()
        self._waits_for: str | None = None
        self._answer: Candidates | None = None
        self._came = threading.Condition()
        self._photographs = rospy.Publisher("photographs", Photograph, queue_size=2)
        self._candidates = rospy.Subscriber("candidates", Candidates, self._on_candidates, queue_size=10)
        threading.Thread(target=self._work, daemon=True).start()

    def give(self, path: Path, mesh: str, on_marked: Callable[[Path], None] = lambda _: None) -> None:
        """Let a photograph be marked.

        mesh: file of the surface. on_marked: called with the path, in the link's thread, when it is marked,
        or when there is no answer.
        """
        self._due.put((path, mesh, on_marked))

    @property
    def waits(self) -> bool:
        """Whether a photograph is still to be marked."""
        return self._due.unfinished_tasks > 0

    def _on_candidates(self, message: Candidates) -> None:
        with self._came:
            if message.file == self._waits_for:
                self._answer = message
                self._came.notify_all()

    def _work(self) -> None:
        while not rospy.is_shutdown():
            try:
                path, mesh, on_marked = self._due.get(timeout=LOOK_S)
            except queue.Empty:
                continue
            try:
                self._mark(path, mesh)
            except FlightBasicsError as error:
                self._say(f"{error} Its defects are looked for by inspection.")
            on_marked(path)
            self._due.task_done()

    def _mark(self, path: Path, mesh: str) -> None:
        """Raises FlightBasicsError: the photograph or the answer makes no sense, or there is none."""
        if read_marks(path) is not None:
            return
        answer = self._asked(photograph_message(path, mesh, self._frame))
        if answer is None:
            told_s, self._patience_s = self._patience_s, NO_PATIENCE_S
            topic = self._candidates.resolved_name
            raise FlightBasicsError(f"{path.name}: no candidates came on {topic} within {told_s:.0f} s.")
        self._patience_s = PATIENCE_S
        found = candidates_of(answer, read_camera(path.parent / "calibration.yaml"))
        write_marks(path, found, answer._connection_header.get("callerid", ""))
        self.marked += 1

    def _asked(self, message: Photograph) -> Candidates | None:
        """Send a photograph, again to each detector that joins, until its candidates come or it is late."""
        with self._came:
            self._waits_for, self._answer = message.file, None
        until_s, told = time.monotonic() + self._patience_s, 0
        while time.monotonic() < until_s and not rospy.is_shutdown():
            listens, answers = self._photographs.get_num_connections(), self._candidates.get_num_connections()
            if listens and answers and listens != told:
                self._photographs.publish(message)
                told = listens
            elif not listens or not answers:
                told = 0
            with self._came:
                if self._answer is None:
                    self._came.wait(LOOK_S)
                if self._answer is not None:
                    break
        with self._came:
            self._waits_for = None
            return self._answer
