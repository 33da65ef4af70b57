"""Given pictures and truth of any make, `bench findings` counts as one would by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image
from scipy.io import savemat

from benchmarks import findings
from benchmarks.findings_rows.burnt import Burnt, moved
from benchmarks.findings_rows.halves import halves_of
from benchmarks.findings_rows.public_set import SetError, read_mask, with_answers, with_masks
from benchmarks.findings_rows.scores import of_answer, of_pixels, total

MASK = np.zeros((40, 60), bool)
MASK[20, 5:55] = True


def written(path, kind):
    """A mask in a file, as sets have them."""
    values = MASK.astype(np.uint8)
    if kind == "matlab":
        savemat(path.with_suffix(".mat"), {"groundTruth": {"Segmentation": values + 1, "Boundaries": values}})
        return path.with_suffix(".mat")
    images = {
        "ones": Image.fromarray(values),
        "black on white": Image.fromarray(255 - 255 * values),
        "colour": Image.fromarray(values[..., None] * np.array((84, 105, 77), np.uint8)),
        "16 bit": Image.fromarray(values.astype(np.uint16) * 40000),
    }
    if kind == "palette":
        image = Image.fromarray(values, "P")
        image.putpalette([9, 9, 9, 10, 9, 9])
    else:
        image = images[kind]
    image.save(path)
    return path


@pytest.mark.parametrize("kind", ["ones", "black on white", "colour", "16 bit", "palette", "matlab"])
def test_masks_of_all_kinds_are_read_alike(tmp_path, kind):
    np.testing.assert_array_equal(read_mask(written(tmp_path / "a.png", kind)), MASK)


def test_a_label_chooses_and_a_compressed_mask_is_halved(tmp_path):
    labels = MASK.astype(np.uint8) + 1
    labels[0, :5] = 3
    savemat(tmp_path / "a.mat", {"groundTruth": {"Segmentation": labels}})
    np.testing.assert_array_equal(read_mask(tmp_path / "a.mat", 2), MASK)
    thick = np.kron(MASK[::8, ::8], np.ones((8, 8))).astype(bool)
    Image.fromarray(thick).convert("L").save(tmp_path / "b.jpg", quality=70)
    np.testing.assert_array_equal(read_mask(tmp_path / "b.jpg"), thick)


def test_scores_are_those_by_hand():
    found = np.zeros_like(MASK)
    found[23, 5:30] = True  # near the mask
    found[35, 5:30] = True  # far from it
    score = of_pixels(found, MASK, 3.0)
    assert (score.right, score.found, score.shown, score.true) == (25, 50, 25, 50)
    assert (score.precision, score.recall, score.f) == (0.5, 0.5, 0.5)
    nothing = of_pixels(np.zeros_like(MASK), MASK, 3.0)
    assert (nothing.precision, nothing.recall, nothing.f) == (1.0, 0.0, 0.0)
    both = total(
        [of_answer(True, True), of_answer(True, False), of_answer(False, True), of_answer(False, False)]
    )
    assert (both.precision, both.recall) == (0.5, 0.5)


@pytest.fixture
def pictures(tmp_path):
    (tmp_path / "pictures").mkdir()
    rng = np.random.default_rng(1)
    shots = {"a": 120 * np.ones((40, 60)), "b": 255 * np.ones((40, 60)), "c": 90 * np.ones((40, 60))}
    for name, light in shots.items():
        grey = np.clip(light + rng.normal(0.0, 2.0, light.shape), 0, 255).astype(np.uint8)
        grey[MASK] = np.where(name == "b", 255, grey[MASK] // 3)
        Image.fromarray(grey).save(tmp_path / f"pictures/{name}.png")
    Image.fromarray(np.full((4, 4), 9, np.uint8)).save(tmp_path / "pictures/d.png")
    return tmp_path / "pictures"


def test_what_does_not_fit_is_left_out_and_named(pictures, tmp_path):
    (tmp_path / "masks").mkdir()
    for name, mask in (("a", MASK), ("b", MASK), ("c", MASK[:20])):
        Image.fromarray(mask).save(tmp_path / f"masks/{name}.png")
    found = with_masks(pictures, tmp_path / "masks")
    masks = {path.name: found.mask(path, picture.shape[:2]) for path, picture in found.pictures()}
    np.testing.assert_array_equal(masks["a.png"], MASK)
    assert set(found.left_out) == {"b.png", "c.png", "d.png"}
    assert found.left_out["b.png"] == "It is white all over. Shoot it again with another exposure."
    assert found.left_out["c.png"] == "Its mask has 60 x 20 px, and not its size."


def test_grey_pictures_count_and_others_that_cannot_be_read_are_named(pictures, tmp_path):
    """As sets have them: with alpha, with 16 bits; and what is no picture, whatever its name says."""
    grey = np.tile(np.arange(60, 180, 2, dtype=np.uint8), (40, 1))
    Image.fromarray(grey).convert("LA").save(pictures / "alpha.png")
    Image.fromarray(grey.astype(np.uint16) * 256).save(pictures / "deep.png")
    (pictures / "folder.jpg").mkdir()
    (pictures / "empty.jpg").write_bytes(b"")
    (pictures / "phone.jpg").write_bytes(b"\0\0\0\x18ftypheic" + bytes(99))
    names = ("alpha.png", "deep.png", "folder.jpg", "empty.jpg", "phone.jpg", "d.png")
    (tmp_path / "truth.csv").write_text("name,crack\n" + "".join(f"{each},no\n" for each in names))
    found = with_answers(pictures, tmp_path / "truth.csv", "crack")
    for _, picture in found.pictures():
        np.testing.assert_array_equal(picture, grey[..., None].repeat(3, axis=2))
    assert set(found.left_out) == {"folder.jpg", "empty.jpg", "phone.jpg", "d.png"}
    assert "it is a folder" in found.left_out["folder.jpg"].lower()
    assert "the file is empty" in found.left_out["empty.jpg"].lower()
    assert "HEIC" in found.left_out["phone.jpg"]
    assert "4 x 4 px" in found.left_out["d.png"]


def test_a_table_answers(pictures, tmp_path, capsys):
    (tmp_path / "truth.csv").write_text("\ufeffname,crack\na.png,yes\nc.png,No\nb.png,yes\nx.png,no\n")
    call = [
        "--photographs",
        str(pictures),
        "--truth",
        str(tmp_path / "truth.csv"),
        "--results",
        str(tmp_path),
    ]
    findings.main(call)
    said = capsys.readouterr().out
    assert "crack in pictures: 2 pictures, 2 left out." in said
    assert "left out: x.png" in said
    numbers = json.loads((tmp_path / "benchmarks.json").read_text())["findings"]["pictures"]["crack"]["ours"]
    assert (numbers["true"], numbers["others"]) == (1, 1)


def test_pictures_with_a_flaw_count_with_the_others_and_apart(pictures, tmp_path, capsys):
    with Image.open(pictures / "c.png") as image:
        image.convert("P").save(pictures / "c.png")
    (tmp_path / "truth.csv").write_text("name,crack\na.png,yes\nc.png,no\n")
    findings.main(
        ["--photographs", str(pictures), "--truth", str(tmp_path / "truth.csv"), "--results", str(tmp_path)]
    )
    assert "converted: 1 pictures: c.png." in capsys.readouterr().out
    numbers = json.loads((tmp_path / "benchmarks.json").read_text())["findings"]["pictures"]["crack"]
    assert numbers["ours"]["pictures"] == 2
    assert (numbers["ours_converted"]["true"], numbers["ours_converted"]["others"]) == (0, 1)


def test_halves_share_no_picture_and_copies_stay_together(tmp_path):
    rng, answers = np.random.default_rng(1), {}
    for k in range(10):
        image = Image.fromarray(rng.integers(0, 255, (24, 24, 3)).astype(np.uint8))
        for name, copy in ((f"{k}.png", image), (f"{k}_copy.png", image.resize((48, 48)))):
            copy.save(tmp_path / name)
            answers[tmp_path / name] = k < 4
    for seed in (1, 2):
        halves = halves_of(answers, seed)
        assert halves == halves_of(dict(reversed(answers.items())), seed)
        assert halves.first | halves.second == {path.name for path in answers}
        assert not halves.first & halves.second
        for half in halves:
            assert {name for name in half if "copy" in name} == {
                name.replace(".", "_copy.") for name in half if "copy" not in name
            }
            assert sum(answers[tmp_path / name] for name in half) == 4


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name,rust\na.png,yes\n", r"its first line must name the columns name,crack\.$"),
        ("name,crack\na.png,perhaps\n", r"line 2: crack must be yes or no, not 'perhaps'\.$"),
        ("name,crack\nz.png,yes\n", r"answers for no picture of .*pictures\.$"),
    ],
)
def test_a_table_that_cannot_be_read_is_refused(pictures, tmp_path, text, said):
    (tmp_path / "truth.csv").write_text(text)
    with pytest.raises(SetError, match=said):
        with_answers(pictures, tmp_path / "truth.csv", "crack")


def test_without_photographs_nothing_is_measured(capsys):
    findings.main(["--brief"])
    assert capsys.readouterr().out.startswith("bench findings: nothing is measured without --photographs")


def test_motion_moves_light_along_its_line():
    """A point becomes a line of the motion's length and of the same light in all, but for the noise."""
    point = np.full((61, 61, 3), 0, np.uint8)
    point[30, 30] = 255
    blurred = np.mean(
        [moved(point, 15.0, 0.0, np.random.default_rng(seed)) for seed in range(4)], axis=(0, 3)
    )
    assert blurred[30, 24:37].min() > 8.0  # 255 / 15 = 17 each
    assert blurred[30, 39:].max() < 5.0
    assert blurred[[27, 33]].max() < 5.0


def test_writing_is_burnt_in_at_a_border_and_each_picture_has_its_own():
    grey = np.full((400, 600, 3), 120, np.uint8)
    written = [np.abs(Burnt(3).into(grey, number).astype(int) - 120).max(axis=2) > 30 for number in (0, 1)]
    for each in written:
        rows = np.nonzero(each.any(axis=1))[0]
        assert 0.02 * 400 <= np.ptp(rows) + 1 <= 0.06 * 400 + 2
        assert rows[0] < 40 or rows[-1] > 360
    assert (written[0] != written[1]).any()
    assert (Burnt(3).into(grey, 0) == Burnt(3).into(grey, 0)).all()
    assert Burnt().into(grey, 0) is grey


def test_flaws_that_are_put_in_are_counted_and_so_are_false_alarms(pictures, tmp_path, capsys):
    for name in ("a", "c"):  # large enough for writing
        Image.new("RGB", (640, 480), (120, 120, 120)).save(pictures / f"{name}.png")
    (tmp_path / "truth.csv").write_text("name,crack\na.png,no\nc.png,no\n")
    call = [
        "--photographs",
        str(pictures),
        "--truth",
        str(tmp_path / "truth.csv"),
        "--results",
        str(tmp_path),
    ]
    findings.main([*call, "--burn-stamp", "1"])
    numbers = json.loads((tmp_path / "benchmarks.json").read_text())["findings"]["pictures"]["crack"]["ours"]
    assert (numbers["written"], numbers["pictures"]) == (2, 2)
    assert (numbers["clean"], numbers["false_alarms_a_picture"]) == (2, 0.0)
    assert "2 pictures show nothing of it: 0 false alarms in them, 0.00 a picture" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        findings.main([*call, "--blur", "-1"])
    assert "--blur is 0 to 200 px" in capsys.readouterr().err
