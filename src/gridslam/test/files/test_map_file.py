"""Maps are written as map_saver writes them, and read as map_server reads them."""

import contextlib
import resource
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from gridslam import MapError, OccupancyGrid
from gridslam.files.map_file import Thresholds, read_map, write_map, write_picture

FACTS = {"image": "map.pgm", "resolution": 0.1, "origin": [0.0, 0.0, 0.0]}


def drawn():
    """Two rows: the lower one (y = 0) free, unknown, occupied; the upper one all free."""
    return OccupancyGrid(np.array([[0, -1, 100], [0, 0, 0]]), 0.05, (-1.5, 2.0))


def write_files(folder, greys, **facts):
    Image.fromarray(np.asarray(greys, dtype=np.uint8)).save(folder / "map.pgm")
    (folder / "map.yaml").write_text(yaml.safe_dump({**FACTS, **facts}))
    return folder / "map.yaml"


@contextlib.contextmanager
def files_up_to(size):
    """No file can grow beyond this many bytes, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_the_image_is_map_savers(tmp_path):
    image, _ = write_map(tmp_path / "hold", drawn())
    assert image.read_bytes().split(b"\n", 2)[0] == b"P5"
    np.testing.assert_array_equal(np.asarray(Image.open(image)), [[254, 254, 254], [254, 205, 0]])


def test_the_yaml_file_is_map_servers(tmp_path):
    _, facts = write_map(tmp_path / "hold.2", drawn())
    assert facts.name == "hold.2.yaml"
    assert yaml.safe_load(facts.read_text()) == {
        "image": "hold.2.pgm",
        "resolution": 0.05,
        "origin": [-1.5, 2.0, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }


@given(
    arrays(np.int8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.sampled_from([-1, 0, 100]))
)
def test_a_map_comes_back_as_it_was(tmp_path_factory, cells):
    grid = OccupancyGrid(cells, 0.025, (-3.25, 7.5))
    read = read_map(write_map(tmp_path_factory.mktemp("map") / "m", grid)[1])
    np.testing.assert_array_equal(read.cells, cells)
    assert (read.resolution_m, read.origin_xy_m) == (grid.resolution_m, grid.origin_xy_m)


@pytest.mark.table(
    "name", ["hall #2", "run: 3", "- a", "{x", "'q\"", "höhle 3", "%", "a\nb", "tab\t", "x" * 200, "..."]
)
def test_a_map_of_any_name_comes_back(tmp_path, name):
    read = read_map(write_map(tmp_path / name, drawn())[1])
    np.testing.assert_array_equal(read.cells, drawn().cells)


@pytest.mark.table("bytes_max", [20, 60])
def test_where_a_map_cannot_be_written_whole_the_old_one_stays(tmp_path, bytes_max):
    # Given a map, and no room for more than so many bytes in a file: less than the image, or than the YAML
    paths = write_map(tmp_path / "map", drawn())
    write_picture(tmp_path / "map.png", drawn())
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    image, yaml_file = (len(path.read_bytes()) for path in paths)
    assert 20 < image < 60 < yaml_file
    other = OccupancyGrid(np.array([[0, 100]]), 0.1, (0.0, 0.0))
    with files_up_to(bytes_max):
        # When another one is written there
        with pytest.raises(MapError, match=r"cannot be written to .*map.*: File too large"):
            write_map(tmp_path / "map", other)
        with pytest.raises(MapError, match=r"cannot be written to .*map\.png: File too large"):
            write_picture(tmp_path / "map.png", other)
    # Then all files are as they were, and there are no others
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_probabilities_are_divided_as_map_saver_does(tmp_path):
    grid = OccupancyGrid(np.array([[0, 25, 26, 64, 65, 100]]), 0.05, (0.0, 0.0))
    assert read_map(write_map(tmp_path / "m", grid)[1]).cells.tolist() == [[0, 0, -1, -1, 100, 100]]
    wider = write_map(tmp_path / "m", grid, Thresholds(free_at_most=63, occupied_at_least=64))[1]
    assert read_map(wider).cells.tolist() == [[0, 0, 0, 100, 100, 100]]


@pytest.mark.table(("free", "occupied"), [(-1, 65), (65, 65), (25, 101)])
def test_thresholds_rise(free, occupied):
    with pytest.raises(MapError, match=f"must rise within 0 to 100, but they are {free} and {occupied}"):
        Thresholds(free, occupied)


def test_modes_and_negate(tmp_path):
    # occupancy 1 - 102/255 = 0.6 lies between the thresholds 0.2 and 0.7: 1 + 98 * 0.4 / 0.5 = 79.4
    greys, thresholds = [[0, 102, 255]], {"occupied_thresh": 0.7, "free_thresh": 0.2}
    expected = {"trinary": [100, -1, 0], "scale": [100, 79, 0], "raw": [0, -1, -1]}
    for mode, cells in expected.items():
        path = write_files(tmp_path, greys, mode=mode, negate=0, **thresholds)
        assert read_map(path).cells.tolist() == [cells], mode
    path = write_files(tmp_path, greys, negate=1, **thresholds)
    assert read_map(path).cells.tolist() == [[0, -1, 100]]
    # map_server subtracts the grey from 255 in the mode raw, too; what is above 100 is no occupancy
    path = write_files(tmp_path, [[255, 200, 155, 0]], mode="raw", negate=1)
    assert read_map(path).cells.tolist() == [[0, 55, 100, -1]]


@pytest.mark.table(
    ("mode", "cells"),
    [
        # map_server's image_loader.cpp: the mean of the colours; transparent and between: unknown.
        # 1 - 102/255 = 0.6, and 1 + 98 * (0.6 - 0.2) / (0.7 - 0.2) = 79.4
        ("scale", [79, -1, 100, 0, 79]),
        # The mean counts alpha: (3 * 102 + 255) / 4 -> 0.45, 0.7 - 1e-16, 1, 0.25, (3 * 102 + 1) / 4 -> 0.699
        ("trinary", [-1, -1, 100, -1, -1]),
    ],
)
def test_transparent_pixels_are_as_in_map_server(tmp_path, mode, cells):
    pixels = [[102, 102, 102, 255], [102, 102, 102, 0], [0, 0, 0, 0], [255, 255, 255, 0], [102, 102, 102, 1]]
    Image.fromarray(np.array([pixels], dtype=np.uint8)).save(tmp_path / "map.png")
    facts = {**FACTS, "image": "map.png", "mode": mode, "occupied_thresh": 0.7, "free_thresh": 0.2}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(facts))
    assert read_map(tmp_path / "map.yaml").cells.tolist() == [cells]


def test_colour_images_count_by_their_mean(tmp_path):
    colours = np.array([[[255, 255, 255], [255, 0, 0], [0, 0, 0]]], dtype=np.uint8)
    Image.fromarray(colours).save(tmp_path / "map.png")
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({**FACTS, "image": "map.png"}))
    assert read_map(tmp_path / "map.yaml").cells.tolist() == [[0, 100, 100]]


def bomb(path, width, height):
    """Write a PNG file of 8 bits a cell whose header promises that size."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    pixels = b"IDAT" + zlib.compress(b"")
    chunks = (header, pixels, b"IEND")
    framed = (struct.pack(">I", len(c) - 4) + c + struct.pack(">I", zlib.crc32(c)) for c in chunks)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(framed))


@pytest.mark.table("side", [21_000, 60_000])
def test_an_image_larger_than_any_map_is_refused_unread(tmp_path, side):
    path = write_files(tmp_path, [[0]], image="bomb.png")
    bomb(tmp_path / "bomb.png", side, side)
    with pytest.raises(MapError, match=r"bomb\.png"):
        read_map(path)


def test_pillows_limit_for_others_stays(tmp_path, monkeypatch):
    # a limit of 8 pixels, beyond which Pillow refuses twice as many: what is no map of ours is still refused
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 8)
    path = write_files(tmp_path, [[0, 255, 205] * 10])
    assert read_map(path).cells.tolist() == [[100, 0, -1] * 10]
    assert Image.MAX_IMAGE_PIXELS == 8
    with pytest.raises(Image.DecompressionBombError):
        Image.open(tmp_path / "map.pgm")


def test_a_picture_for_people(tmp_path):
    write_picture(tmp_path / "map.png", drawn())
    np.testing.assert_array_equal(
        np.asarray(Image.open(tmp_path / "map.png")), [[254, 254, 254], [254, 205, 0]]
    )


@pytest.mark.table(
    ("facts", "words"),
    [
        ({"origin": [0.0, 0.0, 0.5]}, "yaw 0"),
        ({"origin": 3}, "origin"),
        ({"origin": [0.0, "a", 0.0]}, "must be a number"),
        ({"resolution": "fine"}, "resolution"),
        ({"resolution": -1.0}, "resolution"),
        ({"resolution": 10**400}, "resolution"),
        ({"origin": [10**400, 0.0, 0.0]}, "must be a number"),
        ({"image": "other.pgm"}, "other.pgm"),
        ({"mode": "rgb"}, "mode"),
        ({"free_thresh": 1.9}, "free_thresh"),
        ({"origin": [0.0, 0.0, 90.0]}, "Turn the image, and set the number to 0"),
        ({"resolution": "0,05"}, "resolution"),
        ({"negate": "yes, please"}, "negate"),
        ({"image": None}, "image is None"),
        ({"image": ["a.pgm"]}, "image is"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(tmp_path, facts, words):
    path = write_files(tmp_path, [[0, 255]], **facts)
    with pytest.raises(MapError, match=words):
        read_map(path)


@pytest.mark.table(
    "text", ["", "5", "- 1", "image: map.pgm", "a: [", "image: {\n", "a: " + "1" * 5000, "[" * 1000]
)
def test_a_file_that_is_no_maps_is_said_by_name(tmp_path, text):
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(MapError, match=r"map\.yaml"):
        read_map(tmp_path / "map.yaml")


def test_a_broken_image_and_missing_files(tmp_path):
    with pytest.raises(MapError, match=r"nothing\.yaml cannot be read: No such file or directory\.$"):
        read_map(tmp_path / "nothing.yaml")
    path = write_files(tmp_path, [[0, 255]])
    (tmp_path / "map.pgm").write_bytes(b"P5\n3")
    with pytest.raises(MapError, match=r"map\.pgm"):
        read_map(path)
    (tmp_path / "map.pgm").write_text("no picture")
    with pytest.raises(MapError, match=r"map\.pgm cannot be read: it is not an image that Pillow knows\.$"):
        read_map(path)
    with pytest.raises(MapError, match="cannot be written"):
        write_map(tmp_path / "no/folder/map", drawn())
    with pytest.raises(MapError, match="is a folder"):
        write_map(".", drawn())
    with pytest.raises(MapError, match="no cells"):
        write_map(tmp_path / "map", OccupancyGrid(np.zeros((0, 0)), 0.05, (0.0, 0.0)))


def test_a_resolution_with_an_exponent_and_without_a_point_is_a_number_as_to_map_server(tmp_path):
    Image.fromarray(np.zeros((2, 3), np.uint8)).save(tmp_path / "m.png")
    (tmp_path / "m.yaml").write_text("image: m.png\nresolution: 5e-2\norigin: [-1e1, 2e0, 0]\n")
    read = read_map(tmp_path / "m.yaml")
    assert (read.resolution_m, read.origin_xy_m) == (0.05, (-10.0, 2.0))


@pytest.mark.table("mode", ["trinary", "scale"])
@pytest.mark.table(("free", "occupied", "right"), [(0.5, 0.1, [100, 100, 0]), (0.6, 0.6, [100, 0, 0])])
def test_thresholds_that_do_not_rise_count_as_in_map_server(tmp_path, mode, free, occupied, right):
    """It asks first whether a cell is above occupied_thresh, then whether it is below free_thresh."""
    Image.fromarray(np.array([[0, 115, 254]], np.uint8)).save(tmp_path / "m.png")
    facts = {**FACTS, "image": "m.png", "mode": mode, "free_thresh": free, "occupied_thresh": occupied}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(facts))
    assert read_map(tmp_path / "m.yaml").cells.tolist() == [right]


def test_tabs_are_blanks_as_to_map_server(tmp_path):
    Image.fromarray(np.zeros((2, 3), np.uint8)).save(tmp_path / "a\tmap.png")
    text = "image:\t'a\tmap.png'\t# of an\teditor's\nresolution:\t0.05\t\n"
    text += "origin:\t[-1.0,\t2.0,\t0]\nnegate:\t1\n"
    (tmp_path / "m.yaml").write_text(text)
    read = read_map(tmp_path / "m.yaml")
    assert (read.resolution_m, read.origin_xy_m) == (0.05, (-1.0, 2.0))
    assert read.cells.tolist() == [[0, 0, 0]] * 2


@pytest.mark.table(
    ("encoding", "before", "behind"),
    [
        ("utf-16", "", ""),  # with its mark, as PowerShell writes it
        ("utf-8-sig", "", ""),
        ("utf-8", "%YAML 1.1\n---\n", "...\n"),
        ("utf-8", "", "---\nimage: another.pgm\n"),  # as in map_server, the first one counts
    ],
)
def test_the_file_may_be_of_another_encoding_or_hold_documents(tmp_path, encoding, before, behind):
    write_map(tmp_path / "a", OccupancyGrid(np.zeros((1, 1), np.int8), 0.05, (0.0, 0.0)))
    text = before + (tmp_path / "a.yaml").read_text() + behind
    (tmp_path / "a.yaml").write_bytes(text.encode(encoding))
    assert read_map(tmp_path / "a.yaml").cells.tolist() == [[0]]


def test_any_letter_may_stand_in_a_comment(tmp_path):
    write_map(tmp_path / "a", OccupancyGrid(np.zeros((1, 1), np.int8), 0.05, (0.0, 0.0)))
    text = (tmp_path / "a.yaml").read_bytes()
    (tmp_path / "a.yaml").write_bytes("# \xdcbungsraum\n".encode("latin-1") + text)
    assert read_map(tmp_path / "a.yaml").resolution_m == 0.05


@pytest.mark.table("yaw", [1e-9, -1e-9, 6.283185307179586, -0.0])
def test_a_turn_that_moves_no_cell_is_none(tmp_path, yaw):
    read = read_map(write_files(tmp_path, [[0, 255]], origin=[1.0, 2.0, yaw]))
    assert (read.origin_xy_m, read.cells.tolist()) == ((1.0, 2.0), [[100, 0]])


@pytest.mark.table(("negate", "right"), [("0", [100, 0]), ("1", [0, 100]), (True, [0, 100]), (2, [0, 100])])
def test_numbers_in_quotes_are_numbers_as_to_map_server(tmp_path, negate, right):
    read = read_map(write_files(tmp_path, [[0, 255]], negate=negate, resolution="0.05"))
    assert (read.resolution_m, read.cells.tolist()) == (0.05, [right])


@pytest.mark.table("dtype", [np.int32, np.float32])
def test_pixels_whose_white_nobody_knows_are_refused(tmp_path, dtype):
    path = write_files(tmp_path, [[0, 255]], image="m.tiff")
    Image.fromarray(np.array([[0, 1]], dtype)).save(tmp_path / "m.tiff")
    with pytest.raises(MapError, match="32 bits"):
        read_map(path)


@pytest.mark.table("name", ["m.png", "m.tiff", "m.pgm"])
def test_pixels_of_16_bits_are_read(tmp_path, name):
    path = write_files(tmp_path, [[0, 255]], image=name)
    greys = 257 * np.array([[0, 205, 254]], np.uint16)
    if name == "m.pgm":
        (tmp_path / name).write_bytes(b"P5\n3 1\n65535\n" + greys.astype(">u2").tobytes())
    else:
        Image.fromarray(greys).save(tmp_path / name)
    assert read_map(path).cells.tolist() == [[100, -1, 0]]


def test_a_large_map_is_written_with_memory_for_one_picture(tmp_path):
    cells = np.full((1500, 1000), -1, np.int8)
    cells[100:1400, 50:900], cells[700, 60:800] = 0, 100
    grid = OccupancyGrid(cells, 0.05, (-3.0, 2.0))
    tracemalloc.start()
    try:
        write_map(tmp_path / "large", grid)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1.5 * cells.size
    np.testing.assert_array_equal(read_map(tmp_path / "large.yaml").cells, cells)
