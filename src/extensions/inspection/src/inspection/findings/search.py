"""Searches photographs, one by one or whole folders, and plans nearer ones of the cracks."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Iterator, NamedTuple, Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.findings_file import DISMISSED, SearchRecord
from inspection.findings.kinds import RUST, kind_of
from inspection.findings.merging import Finding, merged
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate, candidates_in
from inspection.findings.picture.flaws import check_shows, flaws_in
from inspection.findings.picture.on_pictures import PictureSearch, without_pose
from inspection.findings.picture.paint import RED
from inspection.findings.placing import MeshSurface, Placed, PosedPhotograph
from inspection.findings.remembered import Remembered, read_marks
from inspection.findings.second_look import without_refuted
from inspection.findings.several_views import where_sights_cross
from inspection.photograph_poses.exif import read_exif
from inspection.photographs.calibration import focal_apart, focal_in_words, read_camera, read_sourced_camera
from inspection.photographs.listing import LeftOut, Listing, check_picture, listed, read_photograph
from inspection.photographs.record import PhotographError, PhotographRecord, read_record
from inspection.photographs.searched import digest_of
from inspection.photographs.sourced import Sourced, best_of
from inspection.survey.closer import Closer, closer_plan
from inspection.survey.plan import SurveyPlan
from inspection.survey.surface.mesh_file import Mesh, read_mesh
from inspection.survey.surface.reading import Surface

CLOSER_MM, CLOSER_SEED = 0.3, 1
"""Of the surface per pixel of a nearer photograph. Cracks that are shown half as fine need none."""


class Detector:
    """Marks rust and cracks in photographs of one mesh, in the map's frame."""

    def __init__(self, mesh: Mesh, parameters: FindingParameters) -> None:
        self._surface, self._p = MeshSurface(mesh.triangles_m), parameters.for_mesh(mesh)

    def posed(
        self, camera: SurveyCamera, record: PhotographRecord, name: str = "", focal_deviation: float = 0.0
    ) -> PosedPhotograph:
        """Return where a photograph looks."""
        return PosedPhotograph(self._surface, camera, record.pose, self._p, name, focal_deviation)

    def candidates(self, picture: np.ndarray, posed: PosedPhotograph) -> list[Candidate]:
        """Return the candidates in a picture, uint8 (height, width, 3), sRGB."""
        return candidates_in(picture, self._p, posed.sight.judged, posed.sight.detail_mm)


class PhotographSearch:
    """Collects what photographs show of one mesh.

    A photograph that another detector has marked is not searched: its marks count.

    Args:
        mesh: in the map's frame. first: folder from which photographs of others are named.

    Attributes:
        searched: names of the photographs that were searched.
        flawed: those of them that have a flaw, with a sentence each.
    """

    def __init__(self, mesh: Mesh, parameters: FindingParameters, first: Path) -> None:
        self._detector, self._p, self._first = Detector(mesh, parameters), parameters.for_mesh(mesh), first
        self._remembered = Remembered(mesh.triangles_m, self._p)
        self._placed: list[Placed] = []
        self._near: list[PosedPhotograph] = []
        self.searched: list[str] = []
        self.flawed: list[LeftOut] = []

    def add(self, path: Path) -> None:
        """Search a photograph.

        Raises:
            PhotographError: it shows nothing, it or its marks are damaged, or its folder's calibration cannot
                be read.
        """
        camera = read_sourced_camera(path.parent / "calibration.yaml")
        record, name = read_record(path.with_suffix(".json")), _named(path, self._first)
        posed = self._detector.posed(camera.value, record, name, camera.deviation)
        found, flaws = self._marks_of(path, posed)
        self.flawed += [LeftOut(name, why) for why in (*flaws, *_doubts(camera, path))]
        self._placed += [each for each in map(posed.place, found) if each is not None]
        self.searched.append(name)
        if posed.sight.finest_mm <= self._p.crack_closer:
            posed.sight.forget_edges()  # or hundreds of photographs take gigabytes
            self._near.append(posed)

    def _marks_of(self, path: Path, posed: PosedPhotograph) -> tuple[list[Candidate], tuple[str, ...]]:
        """Return what is marked in a photograph, by another detector or by us, and its flaws."""
        by_others = read_marks(path)
        if by_others is not None:
            check_picture(path)
            return by_others, ()
        known = self._remembered.read(path)
        if known is None:
            picture, _ = read_photograph(path)
            check_shows(picture, str(path))
            known = self._detector.candidates(picture, posed), flaws_in(picture, path)
            self._remembered.write(path, *known)
        return known

    def red_photographs(self) -> list[str]:
        """Return the photographs that show little but the colour of rust, if they are most of all.

        Then it counts as the coating's, and rust of the same colour is not told from it. If they are few, the
        coating is another one, and they show rust.
        """
        red = sorted({each.photograph for each in self._placed if each.kind == RED})
        return red if 2 * len(red) > len(self.searched) else []

    def _sure_of_paint(self) -> list[Placed]:
        """Return what is placed, with rust in place of what one photograph cannot tell from paint."""
        if self.red_photographs():
            return [each for each in self._placed if each.kind != RED]
        red = {each.photograph for each in self._placed if each.kind == RED}
        kept = [each for each in self._placed if each.kind != RUST.name or each.photograph not in red]
        return [each._replace(kind=RUST.name) if each.kind == RED else each for each in kept]

    def findings(self) -> list[Finding]:
        """Return what all photographs show together."""
        placed = without_refuted(self._sure_of_paint(), self._near, self._p)
        if self._p.crossing:
            placed = where_sights_cross(placed, self._p.crossing, self._p.distance)
        return merged(placed, self._p.apart)


def _doubts(camera: Sourced[SurveyCamera], path: Path) -> Iterator[str]:
    """Yield a sentence if what a photograph tells of its lens contradicts its folder's calibration."""
    told = read_exif(path).camera
    if told is not None:
        known = replace(camera, source="calibration.yaml")
        _, doubts = best_of((known, told), focal_apart, "the focal length", focal_in_words)
        yield from (each.why for each in doubts)


def find(folders: Sequence[Path], mesh: Path | Mesh, parameters: FindingParameters) -> list[Finding]:
    """Return the findings in folders of photographs; see `search_folders`."""
    return list(search_folders(folders, mesh, parameters).findings)


def search_folders(
    folders: Sequence[Path], mesh: Path | Mesh | None, parameters: FindingParameters
) -> SearchRecord:
    """Return the findings in folders of photographs, and which photographs were searched and left out.

    Photographs of other folders than the first are named by their way from there. Those without a pose are
    searched on their own. mesh: None: no photograph has a pose.

    Raises:
        SurveyError: a folder has no photograph, none can be searched, or the mesh cannot be read.
        PhotographError: a calibration cannot be read.
    """
    listings = [(folder, listed(folder, pixels=False)) for folder in folders]
    for folder, listing in listings:
        if not listing.whole and not without_pose(folder):
            why = f": {listing.left_out[0].name}: {listing.left_out[0].why}" if listing.left_out else "."
            raise SurveyError(f"{folder}: there is no photograph that can be searched{why}")
        if listing.whole:
            read_camera(folder / "calibration.yaml")
    if mesh is None and any(listing.whole for _, listing in listings):
        raise SurveyError("Give the surface: --mesh FILE, a mesh or an SDF world.")
    left_out = [
        each._replace(name=_named(folder / each.name, folders[0]))
        for folder, listing in listings
        for each in listing.left_out
    ]
    record = SearchRecord(searched=(), left_out=tuple(left_out))
    if mesh is not None:
        known = read_mesh(mesh) if isinstance(mesh, Path) else mesh
        record = _with_poses(record, listings, known, parameters)
    record = _without_poses(record, folders, parameters)
    if not record.searched:
        name, why = record.left_out[0]
        raise SurveyError(
            f"{folders[0]}: none of the {len(record.left_out)} photographs could be searched. The first is "
            f"{name}: {why}"
        )
    return record


def _with_poses(
    record: SearchRecord,
    listings: Sequence[tuple[Path, Listing]],
    mesh: Mesh,
    parameters: FindingParameters,
) -> SearchRecord:
    """Return a record with what the photographs show on the mesh whose poses are known."""
    first, rests_on = listings[0][0], dict[str, str]()
    search, left_out = PhotographSearch(mesh, parameters, first), list(record.left_out)
    for _, listing in listings:
        for path, _ in listing.whole:
            try:
                digest = digest_of(path)
                search.add(path)
                rests_on[_named(path, first)] = digest
            except PhotographError as error:
                left_out.append(LeftOut.of(path, error)._replace(name=_named(path, first)))
    return SearchRecord(
        tuple(search.findings()), tuple(search.searched), tuple(left_out), tuple(search.red_photographs()),
        flawed=tuple(search.flawed), rests_on=rests_on,
    )  # fmt: skip


def _without_poses(
    record: SearchRecord, folders: Sequence[Path], parameters: FindingParameters
) -> SearchRecord:
    """Return a record with what the photographs show whose poses are not known."""
    search, searched, left_out = PictureSearch(parameters), list(record.searched or ()), list[LeftOut]()
    unposed = {_named(path, folders[0]): path for folder in folders for path in without_pose(folder)}
    for name, path in unposed.items():
        try:
            search.add(path, name)
            searched.append(name)
        except PhotographError as error:
            left_out.append(LeftOut.of(path, error)._replace(name=name))
    kept = [each for each in record.left_out if each.name not in unposed]
    return replace(
        record,
        searched=tuple(searched),
        left_out=(*kept, *left_out),
        without_pose=search.marked(),
        flawed=(*record.flawed, *search.flawed),
    )


def _named(path: Path, first: Path) -> str:
    """Return a photograph's name, from the first folder."""
    return os.path.relpath(path, first)


class Nearer(NamedTuple):
    """closer: None: no crack needs a nearer photograph. hidden: numbers of findings that none can show."""

    closer: Closer | None
    hidden: tuple[int, ...] = ()


def plan_nearer(plan: SurveyPlan, surface: Surface, findings: Sequence[Finding]) -> Nearer:
    """Return a plan of nearer photographs of the cracks that no photograph shows well enough.

    plan: that was flown. surface: of its mesh.

    Raises:
        SurveyError: the UAV gets near none of the cracks.
    """
    coarse = 2.0 * CLOSER_MM
    lines = [each for each in findings if kind_of(each.kind).is_line]
    open_ = [each for each in lines if each.status != DISMISSED and not each.detail_mm <= coarse]
    if not open_:
        return Nearer(None)
    rng = np.random.default_rng(CLOSER_SEED)
    closer = closer_plan(plan, open_, surface.room, surface.ranges_m, CLOSER_MM, rng)
    return Nearer(closer, tuple(open_[k].id for k in closer.hidden))
