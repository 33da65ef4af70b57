"""Given a folder of photographs of others, each counts, or is left out with the reason."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image

from inspection.findings.findings_file import SearchRecord, write_findings
from inspection.photographs.listing import (
    LeftOut,
    listed,
    photographs_in,
    read_photograph,
    read_picture,
    records_in,
)
from inspection.photographs.record import PhotographError
from inspection.photographs.searched import countable

NO_TURN = {"position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 0.0]}
POSE = {"position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 1.0]}


def shoot(folder, *names, **record):
    """Photographs of these names, each with a JSON."""
    noise = np.random.default_rng(1).integers(0, 255, (48, 64, 3)).astype(np.uint8)
    for name in names:
        Image.fromarray(noise).save(folder / name)
        (folder / name).with_suffix(".json").write_text(json.dumps({**POSE, **record}))


def names_of(listing):
    return [path.name for path, _ in listing.whole], [each.name for each in listing.left_out]


def test_any_name_and_suffix_counts_in_the_order_in_which_one_counts(tmp_path):
    shoot(tmp_path, "DJI_0010.JPG", "DJI_0009.jpeg", "100.5.jpg", "99.25.JPG", "wall.png", "deck.TIF")
    order = ["99.25.JPG", "100.5.jpg", "DJI_0009.jpeg", "DJI_0010.JPG", "deck.TIF", "wall.png"]
    assert names_of(listed(tmp_path)) == (order, [])
    assert [path.name for path in photographs_in(tmp_path)] == order
    stamps = {path.name: record.stamp_s for path, record in listed(tmp_path).whole}
    assert (stamps["99.25.JPG"], stamps["wall.png"]) == (99.25, 0.0)


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def zeroed(path):
    """The file system knew the size, but not the content, when the power was lost."""
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[: size // 2] + bytes(size - size // 2))


def with_more_behind(path):
    """As of a phone that stores a film behind the picture."""
    path.write_bytes(path.read_bytes() + bytes(100_000))


def as_a_folder(path):
    path.unlink()
    path.mkdir()


def turned(path):
    exif = Image.Exif()
    exif[0x0112] = 6
    with Image.open(path) as image:
        image.load()
        image.save(path, exif=exif)


@pytest.mark.table(
    ("damage", "told"),
    [
        (cut, "cut or damaged"), (zeroed, "cut or damaged"), (lambda p: p.write_bytes(b""), "is empty"),
        (lambda p: p.write_text("no picture"), "cut or damaged"), (turned, "orientation 6"),
        (lambda p: p.write_text("<!DOCTYPE html><p>Not found"), "is a web page"),
        (lambda p: p.write_text("version https://git-lfs.github.com/spec/v1"), "git lfs pull"),
        (lambda p: p.write_bytes(b"\0\0\0\x18ftypheic" + bytes(99)), "content is HEIC"),
        (lambda p: p.write_bytes(b"II*\0" + bytes(99)), "it is a TIFF"), (as_a_folder, "it is a folder"),
        (lambda p: p.unlink(), "no photograph beside it"),
        (lambda p: p.with_suffix(".json").unlink(), "no JSON"),
        (lambda p: p.with_suffix(".json").write_text("{"), "cannot be read"),
        (lambda p: p.with_suffix(".json").write_text(json.dumps(NO_TURN)), "unit"),
    ],
)  # fmt: skip
@pytest.mark.table("pixels", [True, False])
def test_what_cannot_be_read_is_left_out_with_the_reason(tmp_path, damage, told, pixels):
    shoot(tmp_path, "1.jpg", "2.jpg")
    damage(tmp_path / "2.jpg")
    whole, (left_out,) = names_of(listed(tmp_path, pixels))
    assert (whole, left_out[0]) == (["1.jpg"], "2")
    (each,) = listed(tmp_path, pixels).left_out
    assert told.lower() in each.why.lower()
    assert str(tmp_path) not in each.why
    assert len(records_in(tmp_path)[0]) == 1


@pytest.mark.table("pixels", [True, False])
def test_what_cameras_put_behind_a_picture_does_no_harm(tmp_path, pixels):
    shoot(tmp_path, "1.jpg")
    with_more_behind(tmp_path / "1.jpg")
    assert names_of(listed(tmp_path, pixels)) == (["1.jpg"], [])


def test_two_pictures_do_not_share_a_json_and_other_files_are_no_photographs(tmp_path):
    shoot(tmp_path, "a.jpg", "a.png")
    for name in ("coverage.json", "findings.json", "a.marks.json"):
        (tmp_path / name).write_text("{}")
    assert names_of(listed(tmp_path)) == (["a.jpg"], ["a.png"])


def test_what_the_search_left_out_does_not_count(tmp_path):
    shoot(tmp_path, "1.jpg", "2.jpg")
    assert names_of(countable(tmp_path)) == (["1.jpg", "2.jpg"], [])
    write_findings(
        tmp_path / "findings.json", SearchRecord((), ("1.jpg",), (LeftOut("2.jpg", "Its marks are cut."),))
    )
    assert names_of(countable(tmp_path)) == (["1.jpg"], ["2.jpg"])
    (tmp_path / "photographs").mkdir()
    for path in tmp_path.glob("?.*"):
        shutil.move(path, tmp_path / "photographs")
    assert names_of(countable(tmp_path / "photographs")) == (["1.jpg"], ["2.jpg"])


def test_a_picture_whose_turn_is_not_known_is_read(tmp_path):
    """EXIF tells turns by 1 to 8; some cameras write 0."""
    exif = Image.Exif()
    exif[0x0112] = 0
    Image.new("RGB", (40, 32)).save(tmp_path / "1.jpg", exif=exif)
    assert read_picture(tmp_path / "1.jpg").shape == (32, 40, 3)


def test_a_turned_picture_is_not_read_as_if_it_stood_upright(tmp_path):
    shoot(tmp_path, "1.jpg")
    turned(tmp_path / "1.jpg")
    with pytest.raises(PhotographError, match="orientation 6"):
        read_photograph(tmp_path / "1.jpg")


@pytest.mark.table(
    ("orientation", "corner"),
    [(2, "top right"), (3, "bottom right"), (4, "bottom left"), (5, "top left"), (6, "top right"),
     (7, "bottom right"), (8, "bottom left"), (9, "top left")],
)  # fmt: skip
def test_a_turned_picture_may_be_turned_upright(tmp_path, orientation, corner):
    # EXIF 2.32: where the 0th row and the 0th column of what is stored lie, so where its first pixel is seen
    exif = Image.Exif()
    exif[0x0112] = orientation
    stored = np.zeros((32, 48, 3), np.uint8)
    stored[:16, :16] = 255
    Image.fromarray(stored).save(tmp_path / "1.png", exif=exif)
    seen = read_picture(tmp_path / "1.png", turns=True)
    assert seen.shape == ((48, 32, 3) if orientation in (5, 6, 7, 8) else (32, 48, 3))
    row, column = (0 if side in ("top", "left") else -1 for side in corner.split())
    assert seen[row, column].min() == 255
    assert [seen[r, c].max() for r in (0, -1) for c in (0, -1) if (r, c) != (row, column)] == [0, 0, 0]


def test_what_macos_puts_beside_each_file_is_no_photograph(tmp_path):
    shoot(tmp_path, "1.jpg")
    (tmp_path / "._1.jpg").write_bytes(b"\0\5\x16\7")
    (tmp_path / "._2.heic").write_bytes(b"\0\5\x16\7")
    assert names_of(listed(tmp_path)) == (["1.jpg"], [])


def test_a_json_that_an_editor_has_given_a_byte_order_mark_is_read(tmp_path):
    shoot(tmp_path, "1.jpg", "2.jpg")
    record = tmp_path / "1.json"
    record.write_text(record.read_text(), encoding="utf-8-sig")
    write_findings(
        tmp_path / "findings.json", SearchRecord((), ("1.jpg",), (LeftOut("2.jpg", "It is black."),))
    )
    found = tmp_path / "findings.json"
    found.write_text(found.read_text(), encoding="utf-8-sig")
    assert names_of(countable(tmp_path)) == (["1.jpg"], ["2.jpg"])


def test_jpegs_by_their_other_suffixes_and_several_in_one_file(tmp_path):
    shoot(tmp_path, "1.jfif", "2.JPE")
    one, other = (Image.new("RGB", (64, 48), colour) for colour in ("white", "black"))
    one.save(tmp_path / "3.mpo", "MPO", save_all=True, append_images=[other])
    shutil.copy(tmp_path / "1.json", tmp_path / "3.json")
    assert names_of(listed(tmp_path)) == (["1.jfif", "2.JPE", "3.mpo"], [])
    assert read_photograph(tmp_path / "3.mpo")[0].min() == 255
    (tmp_path / "4.mpo").write_bytes((tmp_path / "3.mpo").read_bytes()[:500] + bytes(4096))
    shutil.copy(tmp_path / "1.json", tmp_path / "4.json")
    assert names_of(listed(tmp_path))[1] == ["4.mpo"]


@pytest.mark.table("name", ["a b.HEIC", "Übersicht.dng", "c.jxl", "d.PEF"])
def test_a_picture_of_a_kind_that_is_not_read_is_told(tmp_path, name):
    shoot(tmp_path, "1.jpg")
    (tmp_path / name).write_bytes(b"a picture")
    (tmp_path / name).with_suffix(".json").write_text(json.dumps(POSE))
    (left_out,) = listed(tmp_path).left_out
    assert left_out.name == name
    assert "not read here. Export it as JPEG." in left_out.why
    (tmp_path / "1.DNG").write_bytes(b"as the camera took it")  # beside the JPEG it is the same photograph
    assert listed(tmp_path).left_out == (left_out,)


@pytest.mark.table(("name", "depth"), [("1.tif", np.uint16), ("1.png", np.uint16), ("1.jpg", np.uint8)])
def test_a_picture_without_colours_shows_no_rust_and_does_not_count(tmp_path, name, depth):
    """Pillow makes of 16 bits a white picture."""
    grey = np.linspace(0, np.iinfo(depth).max, 48 * 64).reshape(48, 64).astype(depth)
    Image.fromarray(grey).save(tmp_path / name)
    (tmp_path / "1.json").write_text(json.dumps(POSE))
    (left_out,) = listed(tmp_path).left_out
    assert "no colours" in left_out.why
    with pytest.raises(PhotographError, match="no colours"):
        read_photograph(tmp_path / name)
