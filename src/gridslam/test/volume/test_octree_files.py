"""OctoMap's streams and files against its own library, and against a slow reader."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_volume import body_of, filled, leaves_of_binary, leaves_of_full
from room_clouds import puck_in_hold

from gridslam import MapError
from gridslam.volume import (
    Board,
    Box,
    VolumeParameters,
    VoxelMap,
    map_from,
    read_octree,
    stream_of,
    write_octree,
)

coordinate = st.floats(-4.0, 4.0, width=32)
point = st.tuples(coordinate, coordinate, coordinate)
clouds = st.lists(st.tuples(point, st.lists(point, min_size=1, max_size=15)), min_size=1, max_size=4)


def mapped(given_clouds, repeats=1):
    voxel_map, board = VoxelMap(VolumeParameters()), Board()
    for _ in range(repeats):
        for origin, points in given_clouds:
            voxel_map.insert(voxel_map.rays(origin, points), board)
    return voxel_map


def hold_map():
    """Three clouds, five times each: then free space is at its least probability, and is pruned."""
    return mapped(
        [puck_in_hold((4.0 + 6.0 * k, 3.0 + 5.0 * k, 2.0 + 2.0 * k), k, columns=450) for k in range(3)], 5
    )


def kinds(values):
    return np.where(np.isnan(values), values, (values >= 0.0).astype(np.float32))


@given(clouds)
def test_streams_read_by_a_slow_reader_hold_the_maps_voxels(given_clouds):
    voxel_map = mapped(given_clouds)
    box, values = voxel_map.box(), voxel_map.values(voxel_map.box())
    full, binary = stream_of(voxel_map, is_binary=False), stream_of(voxel_map, is_binary=True)
    np.testing.assert_array_equal(filled(leaves_of_full(full.data), box), values)
    np.testing.assert_array_equal(filled(leaves_of_binary(binary.data), box), kinds(values))


def test_the_full_stream_equals_octomaps_byte_for_byte():
    octomap = pytest.importorskip("pyoctomap")
    given_clouds = [puck_in_hold((5.0, 4.0, 3.0 + k), k, columns=90) for k in range(7)]
    tree = octomap.OcTree(0.1)
    for origin, points in given_clouds:
        tree.insertPointCloud(points.astype(float), origin.astype(float))
    tree.updateInnerOccupancy()
    octree = stream_of(mapped(given_clouds), is_binary=False)
    assert (octree.data, octree.nodes) == (body_of(tree.write()), tree.size())


@pytest.mark.parametrize("suffix", [".bt", ".ot"])
def test_octomap_reads_our_files_and_we_read_its(tmp_path, suffix):
    octomap = pytest.importorskip("pyoctomap")
    voxel_map, is_binary = hold_map(), suffix == ".bt"
    ours, its = tmp_path / f"ours{suffix}", tmp_path / f"its{suffix}"
    octree = stream_of(voxel_map, is_binary)
    write_octree(ours, octree, 0.1)
    if is_binary:
        tree = octomap.OcTree(0.1)
        assert tree.readBinary(str(ours))
        assert tree.writeBinary(str(its))
    else:
        tree = octomap.OcTree(0.1).read(str(ours))
        assert tree.write(str(its))
    assert (tree.size(), tree.getResolution()) == (octree.nodes, 0.1)
    assert body_of(its.read_bytes()) == octree.data
    again, box = read_octree(its), voxel_map.box()
    expected = kinds(voxel_map.values(box)) if is_binary else voxel_map.values(box)
    found = kinds(again.values(box)) if is_binary else again.values(box)
    np.testing.assert_array_equal(found, expected)


def test_a_leaf_of_many_tiles_is_read(tmp_path):
    voxel_map = VoxelMap(VolumeParameters(resolution_m=0.05))
    voxel_map.cover(np.array((4, 4, 4)), np.array((8, 8, 8)))
    places = np.argwhere(np.ones((4, 4, 4), bool)) + 4 - voxel_map.corner[::-1]
    voxel_map.table[tuple(places.T)] = voxel_map.pool.take(64, 1)
    voxel_map.pool.cubes[1:][voxel_map.table[tuple(places.T)] - 1] = -2.0
    octree = stream_of(voxel_map, is_binary=True)
    assert (
        octree.nodes == 11
    )  # the root, and nine levels down to one leaf of 64 voxels a side, with no others
    write_octree(tmp_path / "map.bt", octree, 0.05)
    read = read_octree(tmp_path / "map.bt")
    assert read.parameters.resolution_m == 0.05
    inside = Box(np.full(3, 64), np.full(3, 128))
    assert (read.values(inside) == read.parameters.model.low).all()
    assert read.box().low.tolist() == [64] * 3
    assert read.box().high.tolist() == [128] * 3


def test_an_empty_map_gives_a_file_that_is_read(tmp_path):
    octree = stream_of(VoxelMap(VolumeParameters()), is_binary=True)
    write_octree(tmp_path / "map.bt", octree, 0.1)
    assert read_octree(tmp_path / "map.bt").pool.used == 0


@pytest.mark.table("suffix", [".bt", ".ot"])
@pytest.mark.table("share", [0.0, 0.001, 0.5, 0.999])
def test_a_cut_file_is_told_in_a_sentence(tmp_path, suffix, share):
    path = tmp_path / f"map{suffix}"
    write_octree(path, stream_of(mapped([((0.0, 0.0, 0.0), [(2.0, 1.0, 0.5)])]), suffix == ".bt"), 0.1)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(MapError, match=r"map\.[bo]t.*(cut|no octree)"):
        read_octree(path)


@pytest.mark.table(
    ("old", "new", "sentence"),
    [
        (b"id OcTree", b"id CountingOcTree", "CountingOcTree"),
        (b"res 0.1", b"res 0", "resolution"),
        (b"res 0.1", b"res nan", "resolution"),
        (b"# Octomap", b"# Bonxai", "no octree"),
        (b"data\n", b"data\n\xff\xff", "cut|no sense"),
    ],
)
def test_a_file_that_makes_no_sense_is_told(tmp_path, old, new, sentence):
    path = tmp_path / "map.bt"
    write_octree(path, stream_of(mapped([((0.0, 0.0, 0.0), [(2.0, 1.0, 0.5)])]), True), 0.1)
    path.write_bytes(path.read_bytes().replace(old, new))
    with pytest.raises(MapError, match=sentence):
        read_octree(path)


@pytest.mark.table("suffix", [".bt", ".ot"])
@pytest.mark.table(
    "header",
    [
        b"%b\r\n# of an editor\r\nid OcTree\r\nsize 9\r\nres 0.25\r\ndata\r\n",
        b"%b\nres\t0.25\nid  OcTree\ndata \n",
        b"%b, by others\nid OcTree res 0.25 # m\ndata\n",
        b"%b\nid 1\nsensor\nmax \nres 0.25\ndata\n",
    ],
)
def test_headers_are_read_as_octomap_reads_them(tmp_path, suffix, header):
    voxel_map, is_binary = mapped([((0.0, 0.0, 0.0), [(2.0, 1.0, 0.5)])], 2), suffix == ".bt"
    first = b"# Octomap OcTree binary file" if is_binary else b"# Octomap OcTree file"
    octree, path, box = stream_of(voxel_map, is_binary), tmp_path / f"map{suffix}", voxel_map.box()
    path.write_bytes(header % first + octree.data)
    read = read_octree(path)
    assert read.parameters.resolution_m == 0.25
    assert stream_of(read, is_binary).data == octree.data
    np.testing.assert_array_equal(kinds(read.values(box)), kinds(voxel_map.values(box)))


@pytest.mark.table(("kind", "colour"), [("ColorOcTree", b"\x01\x0a\xff"), ("OcTreeStamped", b"")])
def test_octrees_with_colours_or_times_are_read_without_them(tmp_path, kind, colour):
    # In OctoMap a node of an .ot is log-odds, colour and a byte of children; a .bt has no colours
    voxel_map = mapped([((0.0, 0.0, 0.0), [(2.0, 1.0, 0.5), (-1.0, 2.0, 0.3)])], 3)
    full, binary = stream_of(voxel_map, is_binary=False).data, stream_of(voxel_map, is_binary=True).data
    nodes = b"".join(full[k : k + 4] + colour + full[k + 4 : k + 5] for k in range(0, len(full), 5))
    told = f"id {kind}\nsize {len(full) // 5}\nres 0.1\ndata\n".encode()
    (tmp_path / "map.ot").write_bytes(b"# Octomap OcTree file\n" + told + nodes)
    (tmp_path / "map.bt").write_bytes(b"# Octomap OcTree binary file\n" + told + binary)
    assert stream_of(map_from(nodes, False, VolumeParameters(), kind), is_binary=False).data == full
    assert stream_of(read_octree(tmp_path / "map.ot"), is_binary=False).data == full
    assert stream_of(read_octree(tmp_path / "map.bt"), is_binary=True).data == binary
    (tmp_path / "map.ot").write_bytes(b"# Octomap OcTree file\n" + told + nodes[:-3])
    with pytest.raises(MapError, match=r"cut|no sense"):
        read_octree(tmp_path / "map.ot")


def test_octomaps_own_octree_with_colours_is_read(tmp_path):
    octomap = pytest.importorskip("pyoctomap")
    tree, path = octomap.ColorOcTree(0.2), str(tmp_path / "map.ot")
    for x, is_occupied in ((0.1, True), (0.5, False), (-1.1, True)):
        tree.updateNode([x, 0.3, -0.3], is_occupied)
    tree.updateInnerOccupancy()
    tree.write(path)
    read = read_octree(path)
    row = read.values(Box(np.array((-6, 1, -2)), np.array((3, 2, -1)))).ravel()
    hit, miss = np.log(0.7 / 0.3), np.log(0.4 / 0.6)
    expected = [hit, *[np.nan] * 5, hit, np.nan, miss]
    np.testing.assert_allclose(row, expected, rtol=1e-6)


def test_a_leaf_as_large_as_the_octree_is_refused(tmp_path):
    path = tmp_path / "map.bt"
    path.write_bytes(b"# Octomap OcTree binary file\nid OcTree\nsize 2\nres 0.1\ndata\n\x01\x00")
    with pytest.raises(MapError, match="more space"):
        read_octree(path)


def test_files_that_are_not_there_or_cannot_be_written_are_told(tmp_path):
    with pytest.raises(MapError, match="cannot be read"):
        read_octree(tmp_path / "none.bt")
    with pytest.raises(MapError, match="cannot be written"):
        write_octree(tmp_path / "none/map.bt", stream_of(VoxelMap(VolumeParameters()), True), 0.1)
