"""What the photographs of an inspection show: by the poses that SLAM told, and by the true ones."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from inspection.camera.photograph_pose import PhotographPose
from inspection.files.coverage_record import MAP
from inspection.photographs.searched import countable
from inspection.survey.coverage import OnDrawing, coverages_on, write_coverage
from inspection.survey.plan import SurveyPlan
from inspection.survey.poses import photograph_poses_in, read_photograph_poses
from inspection.survey.surface.mesh_file import reference_of
from inspection.survey.surface.reading import read_surface

TruePose = tuple[tuple[float, float, float], tuple[float, float, float, float]]
"""Position in the world, m, and orientation (x, y, z, w) of the optical frame."""


@dataclass(frozen=True)
class Judged:
    """What was shown: shares of what is reachable, 0..1, and areas.

    told: content of coverage.json, which tells of what surface it is. slam_share, planned_share: of that
    surface. true_share, true_m2, reachable_m2: of the world. planned_share: what the flown photographs of
    the plan would show, from their own places. off_m, off_deg: of SLAM's poses from the true ones, median and
    greatest. taken: the photographs, where they truly were.
    """

    slam_share: float
    true_share: float
    planned_share: float
    true_m2: float
    reachable_m2: float
    off_m: tuple[float, float]
    off_deg: tuple[float, float]
    taken: tuple[PhotographPose, ...]
    told: Mapping[str, Any]

    def figures(self) -> dict:
        """Return them for result.json."""
        return {
            **{key: self.told[key] for key in ("of", "surface")},
            "told": {key: self.told[key] for key in ("shown_m2", "reachable_m2", "share_of_reachable")},
            "drawing": self.told["drawing"],
            "share_by_slam": self.slam_share,
            "share_by_truth": self.true_share,
            "share_planned": self.planned_share,
            "shown_m2": self.true_m2,
            "reachable_m2": self.reachable_m2,
            "pose_error_m": {"median": self.off_m[0], "max": self.off_m[1]},
            "pose_error_deg": {"median": self.off_deg[0], "max": self.off_deg[1]},
        }


def judge_photographs(
    folder: Path, plan_file: Path, plan: SurveyPlan, truths: Mapping[float, TruePose], views: int, world: Path
) -> Judged | None:
    """Write coverage.json and coverage_truth.json beside the photographs' folder; None: it has none.

    The first is on the surface that the plan was made from. If that is a map, it also tells what the same
    photographs show of the world, which the flight did not know. The second is on the world, by true poses.

    truths: by the stamp of the photograph, in seconds with six decimals. views: photographs to be flown.

    Raises:
        FlightBasicsError: one sentence.
    """
    listing = countable(folder)
    kept = [(path, record) for path, record in listing.whole if round(record.stamp_s, 6) in truths]
    if not kept:
        return None
    told, camera = photograph_poses_in(folder, listing, plan.camera)
    true = []
    for path, record in kept:
        place_m, turn = truths[round(record.stamp_s, 6)]
        axes = Rotation.from_quat(turn).as_matrix()
        taken = PhotographPose(np.array(place_m), axes, record.blur_px, name=path.name, path=path)
        true.append(taken.moved(record.shift_m, record.turn_rad))
    planned = read_photograph_poses(plan_file, plan.camera)[0][:views]
    source = Path(plan.source)
    drawn = read_surface(world, plan.asked, plan.home_m)
    (by_truth, on_world) = coverages_on(drawn, (true, told), camera, plan.asked)
    surface = drawn if source == world else read_surface(source, plan.asked, plan.home_m)
    by_slam, by_plan = coverages_on(surface, (told, planned), camera, plan.asked)
    is_map = reference_of(surface.mesh.names) == MAP
    drawing = OnDrawing.beside(by_slam, str(world), on_world) if is_map else None
    told_of = write_coverage(
        folder.parent / "coverage.json", by_slam, plan.source, str(folder), told, plan.asked,
        listing.left_out, drawing,
    )  # fmt: skip
    written = write_coverage(
        folder.parent / "coverage_truth.json", by_truth, str(world), "truth", true, plan.asked
    )
    off_m = [float(np.linalg.norm(np.array(r.position_m) - t.place_m)) for (_, r), t in zip(kept, true)]
    turns = [
        Rotation.from_quat(r.orientation_xyzw).inv() * Rotation.from_matrix(t.axes)
        for (_, r), t in zip(kept, true)
    ]
    off_deg = [float(np.degrees(turn.magnitude())) for turn in turns]
    return Judged(
        by_slam.share() or 0.0,
        by_truth.share() or 0.0,
        by_plan.share() or 0.0,
        written["shown_m2"],
        written["reachable_m2"],
        (float(np.median(off_m)), max(off_m)),
        (float(np.median(off_deg)), max(off_deg)),
        tuple(true),
        told_of,
    )
