"""The tiles of all maps: which are in use, by how many tables, and room for more."""

from __future__ import annotations

import mmap
from dataclasses import dataclass

import numpy as np

from gridslam.kernels.tiles import EMPTY, ENDS, SIDE, TILES, Tiles
from gridslam.maps.mapped_arrays import mapped_zeros, size_bytes

TILES_FIRST = 2048
"""Tiles of the first pool. Only used tiles take memory."""
ARRAYS = (
    ("references", "stamps", "scans", "visits", "occupied", "ends"),
    ("end_references", "hits", "means"),
)
"""Of TILES and of ENDS."""
NOTHING = np.empty(0)
STACKS = ("free_tiles", "free_ends")
SAVED = ("stamps", "visits", "occupied", "ends")
SAVED_ENDS = ("hits", "means")


@dataclass(frozen=True, eq=False)
class TilesState:
    """The content of n tiles and of m entries of ends, to save it. The fields are those of `Tiles`."""

    stamps: np.ndarray
    visits: np.ndarray
    occupied: np.ndarray
    ends: np.ndarray
    """(n,) index of each tile's entry, from 1 on; 0: it has none."""
    hits: np.ndarray
    means: np.ndarray


class TilePool:
    """Tiles of SIDE x SIDE cells and entries of ends, each used by one or several, or free."""

    def __init__(self, capacity: int = TILES_FIRST):
        """Tile 0 and ends 0 are empty for ever; nothing writes to them."""
        self.tiles = _tiles(capacity)
        """The kernels' arrays."""

    @property
    def capacity(self) -> int:
        """Number of tiles there is room for."""
        return self.tiles.references.size

    @property
    def used(self) -> int:
        """Number of tiles in use, the empty one left out."""
        return self.capacity - 1 - int(self.tiles.free[TILES])

    @property
    def surfaces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The input of scan matching: occupied, ends and means."""
        return self.tiles.occupied, self.tiles.ends, self.tiles.means

    def reserve(self, count: int) -> None:
        """Make room for this many more tiles and entries of ends."""
        for which in (TILES, ENDS):
            if self.tiles.free[which] < count:
                self._grow(which, count)

    def _grow(self, which: int, count: int) -> None:
        """Double the tiles or the entries of ends, at least to this many more.

        No other variable may hold one of the arrays meanwhile.
        """
        old = len(getattr(self.tiles, ARRAYS[which][0]))
        new = old + max(old, count)
        for name in ARRAYS[which]:
            array = getattr(self.tiles, name)
            shape, dtype, memory = (new, *array.shape[1:]), array.dtype, array.base
            self.tiles = self.tiles._replace(**{name: NOTHING})
            if isinstance(memory, mmap.mmap):
                del array  # memory that an array uses cannot grow
                memory.resize(size_bytes(shape, dtype))
                grown: np.ndarray = np.ndarray(shape, dtype, memory)
            else:  # of a pool that was copied
                grown = mapped_zeros(shape, dtype)
                grown[:old] = array
            self.tiles = self.tiles._replace(**{name: grown})
        left = self.tiles.free[which]
        stack = np.empty(new - 1, np.int32)
        stack[: new - old] = np.arange(new - 1, old - 1, -1)
        stack[new - old : new - old + left] = getattr(self.tiles, STACKS[which])[:left]
        self.tiles.free[which] += new - old
        self.tiles = self.tiles._replace(**{STACKS[which]: stack})

    def take(self, count: int, stamp: int) -> np.ndarray:
        """Return this many empty tiles, each with its own ends.

        The caller must then call `count_references`.
        """
        tiles = self.tiles
        tiles.free[:] -= count
        taken = tiles.free_tiles[tiles.free[TILES] : tiles.free[TILES] + count].copy()
        ends = tiles.free_ends[tiles.free[ENDS] : tiles.free[ENDS] + count].copy()
        for array in (tiles.visits, tiles.occupied):
            array[taken] = 0
        for array in (tiles.hits, tiles.means):
            array[ends] = 0
        tiles.ends[taken], tiles.stamps[taken] = ends, stamp
        return taken

    def count_references(self, tables: np.ndarray) -> None:
        """Count the references in all tables. Unused tiles and ends become free."""
        tiles = self.tiles
        references = np.bincount(tables.ravel(), minlength=self.capacity)
        references[EMPTY] = 0
        self._release(tiles.references, references, tiles.free_tiles, TILES)
        of_ends = np.bincount(tiles.ends[references > 0], minlength=tiles.end_references.size)
        of_ends[EMPTY] = 0
        self._release(tiles.end_references, of_ends, tiles.free_ends, ENDS)

    def _release(self, before: np.ndarray, now: np.ndarray, stack: np.ndarray, which: int) -> None:
        released = np.flatnonzero((before > 0) & (now == 0))
        left = self.tiles.free[which]
        stack[left : left + released.size] = released[::-1]
        self.tiles.free[which] += released.size
        before[:] = now

    def state(self, used: np.ndarray) -> TilesState:
        """Return the content of the used tiles (n,)."""
        ends, which = np.unique(np.append(self.tiles.ends[used], EMPTY), return_inverse=True)
        saved = {name: getattr(self.tiles, name)[used] for name in SAVED}
        saved["ends"] = which[:-1].astype(np.int32)
        return TilesState(**saved, **{name: getattr(self.tiles, name)[ends[1:]] for name in SAVED_ENDS})

    @classmethod
    def from_state(cls, state: TilesState) -> TilePool:
        """Return a pool of saved tiles. The caller must then call `count_references`.

        Raises:
            ValueError: they are none.
        """
        counts = [len(state.stamps), len(state.hits)]
        pool = cls(max(TILES_FIRST, 2 * max(counts)))
        require_indices(state.ends, counts[1], "the tiles' ends")
        for names, count in zip((SAVED, SAVED_ENDS), counts):
            for name in names:
                given, kept = getattr(state, name), getattr(pool.tiles, name)[1 : count + 1]
                if given.shape != kept.shape or given.dtype != kept.dtype:
                    raise ValueError(f"the tiles' {name} are {given.dtype} {given.shape}, not {kept.shape}")
                kept[:] = given
        pool.tiles.free[:] -= counts
        return pool


def require_indices(indices: np.ndarray, greatest: int, name: str) -> None:
    """Raise ValueError unless all are whole numbers from 0 to ``greatest``: a kernel trusts them."""
    whole = indices.dtype.kind in "iu"
    if not whole or (indices.size and not (indices.min() >= 0 and indices.max() <= greatest)):
        raise ValueError(f"{name} point at what is not there")


def _tiles(capacity: int) -> Tiles:
    """Return arrays for this many tiles and entries of ends. All but the first are free."""
    cells, free = SIDE * SIDE, np.arange(capacity - 1, EMPTY, -1, dtype=np.int32)
    return Tiles(
        references=mapped_zeros((capacity,), np.int32),
        stamps=mapped_zeros((capacity,), np.int64),
        scans=mapped_zeros((capacity,), np.int64),
        visits=mapped_zeros((capacity, cells), np.uint8),
        occupied=mapped_zeros((capacity, SIDE), np.uint32),
        ends=mapped_zeros((capacity,), np.int32),
        end_references=mapped_zeros((capacity,), np.int32),
        hits=mapped_zeros((capacity, cells), np.uint8),
        means=mapped_zeros((capacity, cells, 2), np.uint16),
        free_tiles=free,
        free_ends=free.copy(),
        free=np.array((capacity - 1, capacity - 1)),
    )
