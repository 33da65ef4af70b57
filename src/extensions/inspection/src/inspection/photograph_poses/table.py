"""Poses from a table, one row a photograph; and known places, by which a model is moved into the map."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import optical_axes, rolled
from inspection.files.table import Row, Table, TableError, number_of, read_table
from inspection.photograph_poses.pose import Names, Pose, Poses
from inspection.photograph_poses.world_frame import WorldFrame
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographError

HEADS = {
    "name": ("photograph", "file", "filename", "file_name", "image", "image_name", "label", "picture"),
    "x": ("x_m",), "y": ("y_m",), "z": ("z_m",),
    "latitude": ("lat", "latitude_deg"), "longitude": ("lon", "lng", "longitude_deg"),
    "height": ("altitude", "alt", "height_m", "altitude_m"),
    "yaw_deg": ("yaw",), "tilt_deg": ("tilt",), "pitch_deg": ("pitch",), "roll_deg": ("roll",),
    "qx": (), "qy": (), "qz": (), "qw": (),
    "stamp_s": ("stamp", "time_s", "timestamp"), "exposure_s": ("exposure",),
    "iso": ("iso_speed",), "lux": (), "deviation_m": ("sigma_m", "accuracy_m"),
}  # fmt: skip
QUATERNION = ("qx", "qy", "qz", "qw")
COLUMNS = (
    "name; x, y, z in the map, or latitude, longitude, height; and qx, qy, qz, qw of the optical frame, or "
    "yaw_deg and tilt_deg in the map, or yaw_deg, pitch_deg, roll_deg by the compass"
)


def poses_of_table(path: Path, folder: Path, photographs: Sequence[Path], frame: WorldFrame | None) -> Poses:
    """Return the poses of a table.

    Raises:
        PhotographError: it cannot be read; the sentence names the line.
    """
    table = _table(path, ("name",))
    names = Names(folder, photographs, [row.values["name"] for row in table.rows], path)
    poses, left_out = dict[Path, Pose](), list[LeftOut]()
    for row in table.rows:
        found = names.find(row.values["name"])
        if found is None:
            left_out.append(LeftOut(row.values["name"], f"It is in {path.name}, but not in the folder."))
        elif found in poses:
            raise PhotographError(f"{row.where}: {found.name} has a row before.")
        else:
            poses[found] = replace(_pose(row, frame), source=path.name)
    why = f"{path.name} has no row for it."
    left_out += [LeftOut(each.name, why) for each in photographs if each not in poses]
    unused = ", ".join(table.unused)
    said = (f"{path.name}: these columns are not known and not read: {unused}.",) if unused else ()
    return Poses(poses, tuple(left_out), remarks=(*names.remarks, *said))


def moved_to_places(poses: Poses, path: Path, folder: Path) -> Poses:
    """Return poses of a model, moved, turned and scaled so that its cameras come near to known places.

    path: a table with name, x, y, z: where some of the cameras were in the map.

    Raises:
        PhotographError: the table cannot be read, or the places do not tell how the model lies.
    """
    table, known = _table(path, ("name", "x", "y", "z")), dict[Path, list[float]]()
    names = Names(folder, list(poses.of), [row.values["name"] for row in table.rows], path)
    for row in table.rows:
        found = names.find(row.values["name"])
        if found is not None:
            known[found] = [_number(row, axis) for axis in "xyz"]
    target, given = np.array(list(known.values())), np.array([poses.of[each].position_m for each in known])
    spread = np.linalg.svd(given - given.mean(axis=0), compute_uv=False) if len(known) > 2 else np.zeros(2)
    if len(known) < 3 or spread[1] < 0.01 * spread[0]:
        raise PhotographError(
            f"{path}: has places of {len(known)} photographs of the model; it takes three or more that do "
            "not lie on one line."
        )
    scale, turn, shift = similarity(given, target)
    off_m = np.linalg.norm(scale * given @ turn.T + shift - target, axis=1)
    rms_m = float(np.sqrt((off_m**2).mean()))
    moved = {
        each: replace(
            Pose.of_axes(scale * turn @ pose.position_m + shift, turn @ _axes_of(pose)),
            source=pose.source, deviation=rms_m,
        )
        for each, pose in poses.of.items()
    }  # fmt: skip
    said = (
        f"{len(known)} known places: the model's scale is {scale:.4g}; the places are "
        f"{rms_m:.3f} m off (rms), at most {off_m.max():.3f} m."
    )
    return replace(poses, of=moved, remarks=(*poses.remarks, said))


def similarity(given: np.ndarray, target: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return scale, turn (3, 3) and shift (3,) that bring points (n, 3) nearest to others (Umeyama, 1991)."""
    middle, other = given.mean(axis=0), target.mean(axis=0)
    u, values, vt = np.linalg.svd((target - other).T @ (given - middle))
    signs = np.array((1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))))
    turn: np.ndarray = u * signs @ vt
    scale = float((values * signs).sum() / ((given - middle) ** 2).sum())
    return scale, turn, other - scale * turn @ middle


def _axes_of(pose: Pose) -> np.ndarray:
    axes: np.ndarray = Rotation.from_quat(pose.orientation_xyzw).as_matrix()
    return axes


def _table(path: Path, needed: Sequence[str]) -> Table:
    try:
        table = read_table(path, HEADS, needed)
    except TableError as error:
        raise PhotographError(str(error)) from None
    return table._replace(rows=[each for each in table.rows if each.values["name"]])


def _number(row: Row, name: str) -> float:
    try:
        value = number_of(row.values[name])
        if math.isfinite(value):
            return value
    except (KeyError, ValueError):
        pass
    raise PhotographError(f"{row.where}: {name} must be a finite number. The columns are {COLUMNS}.")


def _pose(row: Row, frame: WorldFrame | None) -> Pose:
    values = row.values
    if values.get("x"):
        place_m = np.array([_number(row, each) for each in "xyz"])
    elif values.get("latitude"):
        if frame is None:
            raise PhotographError(f"{row.where}: latitude and longitude need --origin, the place of the map.")
        place_m = frame.place_m(*(_number(row, each) for each in ("latitude", "longitude", "height")))
    else:
        raise PhotographError(f"{row.where}: there is no place. The columns are {COLUMNS}.")
    deviation_m = _number(row, "deviation_m") if values.get("deviation_m") else 0.0
    return replace(Pose.of_axes(place_m, _axes(row, frame)), deviation=abs(deviation_m), **_light(row))


def _axes(row: Row, frame: WorldFrame | None) -> np.ndarray:
    values = row.values
    if values.get("qx"):
        turn = np.array([_number(row, each) for each in QUATERNION])
        if abs(np.linalg.norm(turn) - 1.0) > 0.01:
            raise PhotographError(f"{row.where}: qx, qy, qz, qw must be a unit quaternion.")
        axes: np.ndarray = Rotation.from_quat(turn).as_matrix()
        return axes
    roll_deg = _number(row, "roll_deg") if values.get("roll_deg") else 0.0
    if values.get("tilt_deg"):
        yaw, tilt = (math.radians(_number(row, each)) for each in ("yaw_deg", "tilt_deg"))
        return rolled(optical_axes(yaw, tilt), math.radians(roll_deg))
    compass = frame or WorldFrame(0.0, 0.0)
    return compass.axes(_number(row, "yaw_deg"), _number(row, "pitch_deg"), roll_deg)


def _light(row: Row) -> dict[str, Any]:
    names = ("stamp_s", "exposure_s", "iso", "lux")
    return {each: _number(row, each) for each in names if row.values.get(each)}
