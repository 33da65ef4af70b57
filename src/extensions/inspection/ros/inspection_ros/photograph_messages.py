"""Photographs and candidates as messages, for nodes that mark defects in photographs."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import rospy
from flight_basics_ros.pose_messages import pose_of
from geometry_msgs.msg import Point, Pose, PoseWithCovariance, Quaternion
from PIL import Image
from sensor_msgs.msg import CameraInfo, CompressedImage
from std_msgs.msg import Header

from flight_basics.errors import ParameterError
from inspection.camera.lens import lens_of
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.picture.candidates import Candidate
from inspection.findings.remembered import marked
from inspection.msg import Candidate as CandidateMessage
from inspection.msg import Candidates, Photograph
from inspection.photographs.calibration import camera_with, distortion_of, read_camera
from inspection.photographs.record import PhotographError, PhotographRecord, read_record


def photograph_message(path: Path, mesh: str, frame: str) -> Photograph:
    """Return a stored photograph as a message. mesh: file of the surface. frame: of its pose.

    Raises:
        PhotographError: it cannot be read.
    """
    camera, record = read_camera(path.parent / "calibration.yaml"), read_record(path.with_suffix(".json"))
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PhotographError(f"{path} cannot be read: {error.strerror}.") from None
    header = Header(stamp=rospy.Time.from_sec(record.stamp_s), frame_id=frame)
    model, distortion = distortion_of(camera)
    info = CameraInfo(header=header, height=camera.height, width=camera.width, distortion_model=model)
    info.D, info.R, info.K = distortion, np.eye(3).ravel().tolist(), camera.matrix.ravel().tolist()
    info.P = np.column_stack((camera.matrix, np.zeros(3))).ravel().tolist()
    pose = Pose(Point(*record.position_m), Quaternion(*record.orientation_xyzw))
    return Photograph(
        header, str(path), mesh, CompressedImage(header, "jpeg", content), info,
        PoseWithCovariance(pose, record.covariance),
    )  # fmt: skip


def picture_of(message: Photograph) -> np.ndarray:
    """Return the picture, uint8 (height, width, 3).

    Raises:
        PhotographError: it is cut, or not as large as the camera's pictures.
    """
    try:
        with Image.open(io.BytesIO(message.image.data)) as image:
            picture = np.array(image.convert("RGB"))
    except (OSError, SyntaxError) as error:
        raise PhotographError(f"{message.file}: the picture is cut or damaged ({error}).") from None
    if picture.shape[:2] != (message.camera.height, message.camera.width):
        raise PhotographError(f"{message.file}: the picture has another size than its camera's.")
    return picture


def record_of(message: Photograph) -> tuple[SurveyCamera, PhotographRecord]:
    """Return camera and pose; exposure and light are not told.

    Raises:
        PhotographError: the camera or the pose makes no sense.
    """
    info = message.camera
    try:
        camera = camera_with(info.width, info.height, lens_of(info.K, info.distortion_model, info.D))
    except ParameterError as error:
        raise PhotographError(f"{message.file}: its camera_info makes no sense: {error}") from None
    position_m, orientation = pose_of(message.pose.pose)
    return camera, PhotographRecord(message.header.stamp.to_sec(), position_m, orientation, 0.0, 0.0, 0.0)


def candidates_message(message: Photograph, found: list[Candidate]) -> Candidates:
    """Return what was found in a photograph."""
    marks = [
        CandidateMessage(each.kind, each.pixels[:, 0].tolist(), each.pixels[:, 1].tolist(), each.size_px)
        for each in found
    ]
    return Candidates(message.header, message.file, marks)


def candidates_of(message: Candidates, camera: SurveyCamera) -> list[Candidate]:
    """Return the candidates of a message. camera: of the photograph.

    Raises:
        PhotographError: one makes no sense.
    """
    found = []
    for number, each in enumerate(message.candidates, start=1):
        try:
            if len(each.x) != len(each.y):
                raise ValueError(f"the {each.kind} has {len(each.x)} x and {len(each.y)} y")
            candidate = marked(each.kind, np.column_stack((each.x, each.y)), each.size)
            outside = (candidate.pixels < -0.5) | (
                candidate.pixels > (camera.width - 0.5, camera.height - 0.5)
            )
            if outside.any():
                raise ValueError(f"a pixel of the {each.kind} is outside the photograph")
        except ValueError as error:
            raise PhotographError(f"{message.file}: candidate {number}: {error}.") from None
        found.append(candidate)
    return found
