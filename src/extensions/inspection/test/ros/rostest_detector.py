"""Photographs go to a node that marks defects, ours or the one on the page, and its marks become findings."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospy
import trimesh
from drawn_wall import AWAY_M, CAMERA, wall_picture
from inspection_ros import detector_link
from inspection_ros.detector_link import DetectorLink
from inspection_ros.photograph_messages import photograph_message
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import optical_axes
from inspection.findings.parameters import FindingParameters
from inspection.findings.remembered import read_marks
from inspection.findings.search import find
from inspection.msg import Candidate, Candidates, Photograph
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.listing import photographs_in
from inspection.photographs.record import PhotographRecord
from node_tools.testing import wait_until

PAGE = Path(__file__).resolve().parents[2] / "doc/findings.md"


def drawn(with_rust=True):
    """A folder of two photographs of a wall with rust and a crack, and the wall's mesh."""
    picture = wall_picture()
    if not with_rust:
        picture[270:330, 170:230] = 150
    folder = Path(tempfile.mkdtemp())
    store = PhotographFolder(folder, CAMERA)
    turn = tuple(Rotation.from_matrix(optical_axes(0.0, 0.0)).as_quat())
    for stamp_s in (0.0, 1.0):
        store.save(picture, PhotographRecord(stamp_s, (-AWAY_M, 0.0, 0.0), turn, 0.002, 100.0, 100.0))
    box = trimesh.creation.box((1.0, 4.0, 4.0))
    box.apply_translation((0.5, 0.0, 0.0))
    box.export(folder / "wall.stl")
    return folder


def ask(folder, space):
    """Run ask_detector in a namespace, as on the page. Return what it says."""
    program = Path(sys.argv[0]).parents[1] / "inspection/ask_detector"  # rosrun takes long to find it
    command = [str(program), f"_folder:={folder}", f"_mesh:={folder}/wall.stl"]
    done = subprocess.run(
        command, env={**os.environ, "ROS_NAMESPACE": space}, capture_output=True, text=True, timeout=200.0
    )
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


class DetectorTest(unittest.TestCase):
    def test_1_our_node_marks_what_the_search_without_it_finds(self):
        folder = drawn()
        without = find([folder], folder / "wall.stl", FindingParameters())
        self.assertEqual([each.kind for each in without], ["crack", "rust"])
        self.assertIn("2 of 2 photographs are marked", ask(folder, "/"))
        for path in photographs_in(folder):
            self.assertEqual(sorted(each.kind for each in read_marks(path)), ["crack", "rust"])
        for mine, theirs in zip(find([folder], folder / "wall.stl", FindingParameters()), without):
            self.assertEqual((mine.kind, mine.photographs), (theirs.kind, theirs.photographs))
            np.testing.assert_allclose(mine.position_m, theirs.position_m, atol=1e-4)

    def test_2_the_detector_on_the_page_runs_and_its_marks_become_findings(self):
        code, _ = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
        folder = drawn(with_rust=False)
        (folder / "my_detector.py").write_text(code, encoding="utf-8")
        node = subprocess.Popen(
            [sys.executable, str(folder / "my_detector.py")], env={**os.environ, "ROS_NAMESPACE": "/page"}
        )
        try:
            self.assertIn("2 of 2 photographs are marked", ask(folder, "/page"))
        finally:
            node.terminate()
            node.wait(60.0)
        (found,) = find([folder], folder / "wall.stl", FindingParameters())
        self.assertEqual(found.kind, "dark")
        # Darker than 80 of 255 is the line of 2 x 200 px alone, from x 500 and y 200 on
        aside_px, down_px = np.array((500.5, 299.5)) - CAMERA.centre_px
        pixel_m = AWAY_M / CAMERA.focal_px
        np.testing.assert_allclose(
            found.position_m, (0.0, -aside_px * pixel_m, -down_px * pixel_m), atol=0.005
        )
        self.assertAlmostEqual(found.length_m, 200 * pixel_m, delta=0.02)

    def test_3_no_answer_and_a_bad_one_are_a_sentence_and_the_photograph_is_searched_by_us(self):
        folder, told, marked = drawn(), [], []
        first, second = photographs_in(folder)
        detector_link.PATIENCE_S, detector_link.NO_PATIENCE_S = 1.0, 1.0
        link = DetectorLink("map", told.append)
        link._photographs.unregister()  # alone: nobody hears it
        link._photographs = rospy.Publisher("/nobody", Photograph, queue_size=1)
        link.give(first, "wall.stl", marked.append)
        wait_until(lambda: marked == [first], "the end of its patience", 200.0)
        self.assertIn("0.000000.jpg: no candidates came on /candidates", told[0])
        # When another node answers with a pixel outside, then its answer is refused
        answers = rospy.Publisher("/candidates", Candidates, queue_size=1)
        bad = Candidates(file=str(second), candidates=[Candidate("rust", [9000.0], [1.0], 1)])
        rospy.Subscriber("/nobody", Photograph, lambda _: answers.publish(bad))
        wait_until(lambda: answers.get_num_connections() > 0, "the link", 200.0)
        link.give(second, "wall.stl", marked.append)
        wait_until(lambda: marked == [first, second], "the refusal", 200.0)
        self.assertIn("a pixel of the rust is outside the photograph", told[1])
        self.assertEqual([read_marks(path) for path in (first, second)], [None, None])
        kinds = [each.kind for each in find([folder], folder / "wall.stl", FindingParameters())]
        self.assertEqual(kinds, ["crack", "rust"])

    def test_4_a_message_holds_the_photograph_as_it_is_stored(self):
        path = photographs_in(drawn())[0]
        message = photograph_message(path, "wall.stl", "map")
        self.assertEqual(message.image.data, path.read_bytes())
        self.assertEqual((message.camera.width, message.camera.height), (CAMERA.width, CAMERA.height))
        self.assertAlmostEqual(message.camera.K[0], CAMERA.focal_px)
        self.assertEqual(message.pose.pose.position.x, -AWAY_M)
