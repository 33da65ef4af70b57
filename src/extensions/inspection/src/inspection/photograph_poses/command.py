"""The command ``rosrun inspection place_photographs``: poses of one's own photographs."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Callable, NamedTuple, Sequence

from flight_basics.errors import FlightBasicsError
from flight_basics.geometry import Quaternion, Vector3, normalised
from inspection.photograph_poses.colmap import poses_of_colmap
from inspection.photograph_poses.of_exif import accuracy, poses_of_exif, read_all, with_exifs
from inspection.photograph_poses.of_flight import Flight, poses_of_flight
from inspection.photograph_poses.pose import Poses, checked_by
from inspection.photograph_poses.storing import store
from inspection.photograph_poses.table import moved_to_places, poses_of_table
from inspection.photograph_poses.world_frame import WorldFrame
from inspection.photographs.listing import LeftOut, pictures_in, unread_in
from inspection.photographs.record import PhotographError
from inspection.photographs.sourced import doubts_in_words

FIRST = "first"


class BagQuery(NamedTuple):
    """What is looked for in a bag; mount: of the camera's optical frame in the UAV's; None: by TF."""

    bag: Path
    path: str
    odometry: str
    camera_frame: str
    mount: tuple[Vector3, Quaternion] | None


def main(arguments: list[str] | None, read_flight: Callable[[BagQuery], Flight]) -> int:
    """Run the command. Return the exit code: 0, or 1 with one sentence on stderr."""
    given = _parser().parse_args(arguments)
    try:
        poses = _poses(given, read_flight)
        if not poses.of:
            first = poses.left_out[0]
            raise PhotographError(
                f"{given.folder}: none of the photographs can be placed. The first is {first.name}: "
                f"{first.why} What an earlier call placed stays."
            )
        said = store(given.folder, poses, given.replace, given.keep)
    except FlightBasicsError as error:
        print(f"place_photographs: {error}", file=sys.stderr)
        return 1
    stems = {path.stem for path in pictures_in(given.folder)}
    unread = [path for path in unread_in(given.folder) if path.stem not in stems]
    for each in (*poses.left_out, *map(LeftOut.of_kind, unread)):
        print(f"place_photographs: left out: {each.name}: {each.why}", file=sys.stderr)
    for remark in (*poses.remarks, *said):
        print(f"place_photographs: {remark}", file=sys.stderr)
    print(f"placed: {len(poses.of)} of {len(pictures_in(given.folder)) + len(unread)} photographs")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="place_photographs",
        description="Write the pose of each photograph of a folder beside it, for findings, coverage and "
        "report. "
        "Poses come from the pictures' EXIF (GPS, and the gimbal's angles as DJI's UAVs write them), unless "
        "another source is given. The pictures stay as they are.",
    )
    parser.add_argument("folder", type=Path, help="of photographs of one camera, of any names")
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--colmap", type=Path, metavar="FOLDER", help="with images.txt and cameras.txt")
    source.add_argument(
        "--table", type=Path, metavar="CSV", help="name, x, y, z, qx, qy, qz, qw; see findings.md"
    )
    source.add_argument(
        "--bag", type=Path, help="of the flight: poses by the pictures' times, from SLAM's path"
    )
    world = parser.add_argument_group("places by latitude and longitude")
    world.add_argument(
        "--origin", metavar="LAT,LON,HEIGHT",
        help="of the map's origin (WGS 84, m). Without the height, z is that above the take-off. "
        f'"{FIRST}": the first photograph\'s place',
    )  # fmt: skip
    world.add_argument(
        "--heading",
        type=float,
        default=90.0,
        help="of the map's x axis, deg clockwise from north; default: 90",
    )
    model = parser.add_argument_group("with --colmap")
    model.add_argument(
        "--places", type=Path, metavar="CSV",
        help="name, x, y, z: where three or more of the cameras were in the map. The model is moved, "
        "turned and scaled to them. Without it, the model counts as one in the map and in metres",
    )  # fmt: skip
    flight = parser.add_argument_group("with --bag")
    flight.add_argument("--path", default="/gridslam/path", help="topic of SLAM's path; default: %(default)s")
    flight.add_argument("--odometry", default="/UAV/odometry", help="default: %(default)s")
    flight.add_argument(
        "--camera-frame", default="inspection_camera_optical",
        help="the camera's optical frame in the bag's TF; default: %(default)s",
    )  # fmt: skip
    flight.add_argument(
        "--mount", metavar="X,Y,Z,QX,QY,QZ,QW", help="of the optical frame in the UAV's, in place of TF"
    )
    flight.add_argument(
        "--clock", type=float, default=0.0, help="s that the camera's clock is behind the bag's"
    )
    flight.add_argument("--level", action="store_true", help="a gimbal keeps the camera level")
    parser.add_argument(
        "--replace", action="store_true", help="also the JSON files and calibration of others"
    )
    parser.add_argument(
        "--keep", action="store_true",
        help="keep the poses of an earlier call of photographs that this source lacks; else they are removed",
    )  # fmt: skip
    return parser


def _poses(given: argparse.Namespace, read_flight: Callable[[BagQuery], Flight]) -> Poses:
    folder: Path = given.folder
    photographs = pictures_in(folder)
    if not photographs:
        unread = unread_in(folder)
        kinds = f" that can be read; {unread[0].name} is of another kind. Export it as JPEG" if unread else ""
        raise PhotographError(f"{folder}: there is no photograph in it{kinds}.")
    frame = None
    if given.origin is not None and given.origin != FIRST:
        frame = _frame(given.origin, given.heading)
    if given.places is not None and given.colmap is None:
        raise PhotographError("--places needs --colmap.")
    told, damaged = read_all(photographs)
    by_gps = Poses() if given.origin is None else poses_of_exif(told, frame, given.heading)
    if given.bag is not None:
        mount = _mount(given.mount) if given.mount else None
        query = BagQuery(given.bag, given.path, given.odometry, given.camera_frame, mount)
        poses = poses_of_flight(told, read_flight(query), given.clock, given.level)
    elif given.colmap is not None:
        poses = poses_of_colmap(given.colmap, folder, photographs)
        if given.places is not None:
            poses = moved_to_places(poses, given.places, folder)
    elif given.table is not None:
        poses = poses_of_table(given.table, folder, photographs, frame)
    elif given.origin is not None:
        poses = by_gps
    else:
        raise PhotographError(
            "Give --origin LAT,LON,HEIGHT, the place of the map's origin, or another source: --colmap, "
            "--table "
            f'or --bag. "--origin {FIRST}" takes the place of the first photograph.'
        )
    known = {each.name for each in poses.left_out}
    poses = replace(poses, left_out=(*poses.left_out, *(each for each in damaged if each.name not in known)))
    poses = with_exifs(checked_by(poses, by_gps), told)
    said = (*poses.remarks, *accuracy(poses), *doubts_in_words(poses.doubts))
    return replace(poses, remarks=said)


def _numbers(option: str, text: str, counts: Sequence[int]) -> list[float]:
    try:
        numbers = [float(each) for each in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts:
        raise PhotographError(
            f'--{option} is "{text}"; it must be {" or ".join(map(str, counts))} numbers with commas between.'
        )
    return numbers


def _frame(text: str, heading_deg: float) -> WorldFrame:
    latitude, longitude, *height = _numbers("origin", text, (3, 2))
    return WorldFrame(latitude, longitude, height[0] if height else None, heading_deg)


def _mount(text: str) -> tuple[Vector3, Quaternion]:
    x, y, z, qx, qy, qz, qw = _numbers("mount", text, (7,))
    return (x, y, z), normalised((qx, qy, qz, qw))
