"""Given a folder of photographs, what is stored can be read, and a failure loses nothing."""

import errno
import json
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from PIL import Image

from inspection.camera.survey_camera import SurveyCamera
from inspection.flight import InspectionParameters
from inspection.flight.photograph_records import done_in
from inspection.flight.viewpoints import row_of
from inspection.photographs import folder as photographs
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.listing import read_photograph
from inspection.photographs.record import PhotographError, PhotographRecord, read_record
from inspection.survey.poses import read_photograph_poses
from inspection.survey.views.candidates import View

CAMERA = SurveyCamera(64, 48, 60.0)
PICTURE = np.full((48, 64, 3), 120, np.uint8)


def record(stamp_s=1.5):
    return PhotographRecord(stamp_s, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0), 0.002, 800.0, 150.0)


VIEWS = (View((1.0, 2.0, 3.0), 0.5, 0.2), View((5.0, 2.0, 3.0), -2.0, 0.0))


def taken(stamp_s, number):
    """A good photograph of one of the viewpoints."""
    return replace(record(stamp_s), view=number, lux=100.0, viewpoint=row_of(VIEWS[number - 1]))


def test_a_photograph_comes_back(tmp_path):
    path = PhotographFolder(tmp_path / "shots", CAMERA).save(PICTURE, record())
    picture, read = read_photograph(path)
    assert read == record()
    assert np.abs(picture.astype(int) - PICTURE).max() <= 2
    exif = Image.open(path).getexif().get_ifd(photographs.EXIF_BLOCK)
    assert exif[photographs.EXPOSURE_TIME] == pytest.approx(0.002)
    assert exif[photographs.FOCAL_35MM] == 30  # 55.4 of 80 px along the diagonal, of 43.3 mm
    assert exif[photographs.FOCAL_LENGTH] == pytest.approx(18.0 / math.tan(math.radians(30.0)), abs=1e-3)
    assert (exif[photographs.DATE], exif[photographs.SUBSECONDS]) == ("1970:01:01 00:00:01", "500000")
    assert Image.open(path).getexif()[0x0112] == 1


@pytest.mark.table("number", [math.nan, math.inf])
@pytest.mark.table("name", ["exposure_s", "iso", "lux", "blur_px", "position_m", "covariance"])
def test_a_record_that_nobody_could_read_is_not_written(tmp_path, name, number):
    given = getattr(record(), name)
    bad = (number, *given[1:]) if isinstance(given, tuple) else number
    with pytest.raises(PhotographError, match=f"is not stored: {name} must be"):
        PhotographFolder(tmp_path, CAMERA).save(PICTURE, replace(record(), **{name: bad}))
    assert not list(tmp_path.glob("1.5*"))


def test_a_disk_that_gets_full_leaves_no_half_line_in_the_lists(tmp_path, monkeypatch):
    store = PhotographFolder(tmp_path, CAMERA)
    store.save(PICTURE, record(1.0))
    was = (tmp_path / "groundtruth.txt").read_text()

    def full(self, *words, **more):
        file = type(self)._open(self, *words, **more)
        if words[:1] == ("a",):
            file.write("2.0 half a li")
            file.flush()
            raise OSError(errno.ENOSPC, "No space left on device")
        return file

    path = type(tmp_path)
    monkeypatch.setattr(path, "_open", path.open, raising=False)
    monkeypatch.setattr(path, "open", full)
    with pytest.raises(PhotographError, match="the disk is full"):
        store.save(PICTURE, record(2.0))
    monkeypatch.undo()
    assert (tmp_path / "groundtruth.txt").read_text() == was


def test_other_tools_find_their_lists(tmp_path):
    store = PhotographFolder(tmp_path, CAMERA)
    store.save(PICTURE, record(1.0))
    (tmp_path / "rgb.txt").write_text("# timestamp filename\n1.00")  # killed while it wrote
    store = PhotographFolder(tmp_path, CAMERA)  # a folder is continued
    assert store.last_stamp_s == 1.0
    store.save(PICTURE, record(2.0))
    with pytest.raises(PhotographError, match="is there already"):
        store.save(PICTURE, record(1.0))
    with pytest.raises(PhotographError, match="another camera"):
        PhotographFolder(tmp_path, SurveyCamera(64, 48, 50.0))
    assert (tmp_path / "rgb.txt").read_text().split("\n")[1:3] == [
        "1.000000 1.000000.jpg",
        "2.000000 2.000000.jpg",
    ]
    poses = np.loadtxt(tmp_path / "groundtruth.txt")
    assert poses.shape == (2, 8)
    info = yaml.safe_load((tmp_path / "calibration.yaml").read_text())
    assert np.allclose(info["camera_matrix"]["data"], CAMERA.matrix.ravel())


def test_a_full_disk_loses_nothing(tmp_path, monkeypatch):
    store = PhotographFolder(tmp_path, CAMERA)
    first = store.save(PICTURE, record(1.0))

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(photographs.os, "replace", full)
    with pytest.raises(PhotographError, match=r"disk is full.*Earlier ones are whole"):
        store.save(PICTURE, record(2.0))
    assert read_photograph(first)[1] == record(1.0)
    assert [path.name for path in tmp_path.glob("*.jpg")] == [first.name]
    assert not list(tmp_path.glob("*.part"))


def test_a_picture_that_is_cut_is_named(tmp_path):
    path = PhotographFolder(tmp_path, CAMERA).save(PICTURE, record())
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(PhotographError, match="cut or damaged"):
        read_photograph(path)


def test_a_record_of_a_newer_program_is_read_and_one_that_lacks_a_key_is_named(tmp_path):
    path = PhotographFolder(tmp_path, CAMERA).save(PICTURE, record(1.0)).with_suffix(".json")
    values = json.loads(path.read_text())
    path.write_text(json.dumps({**values, "weather": "dusty"}))
    assert read_record(path) == record(1.0)
    del values["position_m"]
    path.write_text(json.dumps(values))
    with pytest.raises(PhotographError, match="position_m"):
        read_record(path)


@pytest.mark.table("damage", ["{", "NO PLACE", "LESS"])
def test_a_damaged_record_loses_one_photograph_and_is_told(tmp_path, damage):
    store = PhotographFolder(tmp_path, CAMERA)
    store.save(PICTURE, taken(1.0, 1))
    bad = store.save(PICTURE, taken(2.0, 2)).with_suffix(".json")
    values = json.loads(bad.read_text())
    damage = {
        "NO PLACE": json.dumps({**values, "position_m": [0.0, None, 1.0]}),
        "LESS": json.dumps({**values, "blur_px": -1.0}),
    }.get(damage, damage)
    bad.write_text(damage)
    store = PhotographFolder(tmp_path, CAMERA)
    (sentence,) = store.damaged
    assert bad.stem in sentence
    assert "left out" in sentence
    assert done_in(tmp_path, InspectionParameters(), VIEWS) == {1}
    assert (tmp_path / "rgb.txt").read_text().split("\n")[1:] == ["1.000000 1.000000.jpg", ""]
    assert store.last_stamp_s == 2.0
    store.save(PICTURE, taken(3.0, 2))  # it is taken again
    assert done_in(tmp_path, InspectionParameters(), VIEWS) == {1, 2}


def test_coverage_is_judged_without_the_photograph_whose_record_is_damaged(tmp_path):
    store = PhotographFolder(tmp_path, CAMERA)
    store.save(PICTURE, record(1.0))
    bad = store.save(PICTURE, record(2.0)).with_suffix(".json")
    bad.write_text("{")
    said = []
    taken, _ = read_photograph_poses(tmp_path, CAMERA, said.append)
    assert len(taken) == len(said) == 1
    assert bad.stem in said[0]
