"""A small space for tests: a box of 4 x 3 x 2 m whose patches and findings are known."""

import json

import numpy as np
import trimesh
import yaml
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.findings.findings_file import SearchRecord, write_findings
from inspection.findings.merging import Finding
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord
from inspection.ship.ship_file import parse_ship
from inspection.survey.surface_record import SurfaceRecord, write_surface_record

CAMERA = SurveyCamera(160, 120, 60.0)
SIDE_M = 0.25
SHIP = {
    "name": "Drawn",
    "space": "Box",
    "ap": [-2.0, 0.0, 0.0],
    "frames": [{"from": 0, "to": 8, "spacing": 500}],
    "plate_frames": 4,
    "strakes": [
        {"name": "T", "breadth": [0.0, 1.4]},
        {"name": "A", "breadth": [1.4, 2.0], "height": [0.0, 1.0]},
        {"name": "B", "breadth": [1.4, 2.0], "height": [1.0, 3.0]},
    ],
    "areas": [
        {"name": "Port", "sides": ["P"], "strakes": ["A", "B"]},
        {"name": "Starboard", "sides": ["S"], "strakes": ["A", "B"]},
    ],
    "parts": {"shell": "side plating"},
    "particulars": {"imo": 9074729, "surveyor": "A. Inspector", "pilot": None},
}


def ship():
    return parse_ship(SHIP)


def mesh(path):
    box = trimesh.creation.box((4.0, 3.0, 2.0))
    box.apply_translation((0.0, 0.0, 1.0))
    box.invert()
    box.export(path)
    return path


def side_walls(shown):
    """Both sides, y = 1.5 to port and y = -1.5, of 8 m2 each. shown: of (points) -> bool."""
    x, z = np.meshgrid(np.arange(-2, 2, SIDE_M) + SIDE_M / 2, np.arange(0, 2, SIDE_M) + SIDE_M / 2)
    walls = [np.column_stack((x.ravel(), np.full(x.size, y), z.ravel())) for y in (1.5, -1.5)]
    points = np.concatenate(walls)
    normals = np.repeat([(0.0, -1.0, 0.0), (0.0, 1.0, 0.0)], x.size, axis=0)
    count = len(points)
    return SurfaceRecord(
        points, normals, np.full(count, SIDE_M**2), np.zeros(count, int), ("shell",), shown(points) * 1.0,
        np.ones(count), SIDE_M,
    )  # fmt: skip


def finding(number, kind, place_m, length_m=0.2, area_m2=0.0, **more):
    normal = (0.0, -1.0 if place_m[1] > 0 else 1.0, 0.0)
    return Finding(number, kind, place_m, normal, length_m, area_m2, more.pop("photographs", ()), **more)


FINDINGS = (
    finding(1, "rust", (0.5, 1.5, 1.2), 0.5, 0.1, photographs=("0.000000.jpg",)),
    finding(
        2, "crack", (-0.3, 1.5, 1.0), 0.3, photographs=("0.000000.jpg", "1.000000.jpg"), remark="<b>long</b>"
    ),
)


def folder(path):
    """An inspection: two photographs of the port side, its surface, and findings there."""
    store = PhotographFolder(path / "photographs", CAMERA)
    turn = tuple(Rotation.from_matrix(optical_axes(np.pi / 2, 0.0)).as_quat())
    rng = np.random.default_rng(1)
    for stamp_s in (0.0, 1.0):
        picture = rng.integers(90, 160, (120, 160, 3)).astype(np.uint8)
        store.save(picture, PhotographRecord(stamp_s, (0.1 * stamp_s, -1.0, 1.0), turn, 0.002, 100.0, 300.0))
    searched = tuple(f"{stamp_s:.6f}.jpg" for stamp_s in (0.0, 1.0))
    write_findings(path / "findings.json", SearchRecord(FINDINGS, searched))
    record = {
        "share_of_reachable": 0.5,
        "reachable_m2": 16.0,
        "resolution_mm_per_px": 1.0,
        "incidence_deg": 60.0,
        "counted": list(searched),
    }
    (path / "coverage.json").write_text(json.dumps(record))
    write_surface_record(path / "coverage.npz", side_walls(lambda points: points[:, 1] > 0.0))
    flight = {"photographs": 2, "time_s": 120.0, "way_m": 8.0, "battery_start": 1.0, "battery_end": 0.4}
    mapping = {"purpose": "mapping", "time_s": 90.0, "battery_start": 1.0, "battery_end": 0.7}
    unknown = [{"place_m": [0.0, 0.0, 0.0], "border_m2": 0.5, "why": "too narrow"}] * 3
    explored = {"known_m3": 1234.4, "home_s": 90.0, "unknown": unknown}
    result = {"seed": 3, "exploration": explored, "flights": [mapping, flight]}
    (path / "result.json").write_text(json.dumps(result))
    (path / "ship.yaml").write_text(yaml.safe_dump(SHIP))
    return path
