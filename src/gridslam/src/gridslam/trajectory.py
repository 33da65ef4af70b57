"""Every particle's path. Particles share the nodes of their common past."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam import se2
from gridslam.errors import StateError


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses of the base in the map, at the scans that were processed."""

    stamps_s: np.ndarray
    """(k,) ascending"""
    poses_in_map: np.ndarray
    """(k, 3) x, y, yaw"""
    heights_m: np.ndarray | None = None
    """(k,) of the base in the map; None, or NaN at a pose: not known."""

    def filled(
        self, stamps_s: np.ndarray, base_in_odom: np.ndarray, has_jumped: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the poses in the map (n, 3) at other stamps, from the odometry (n, 3) at these stamps.

        Between two poses of the trajectory the motion is odometry's, and its error is spread evenly over the
        time. ``stamps_s`` (n,) must ascend and contain the trajectory's. has_jumped: (n,) whether odometry
        has jumped since the stamp before, so that it does not tell this step: the error is that step's alone.

        Raises:
            StateError: they do not.
        """
        stamps, odometry = np.asarray(stamps_s, float), np.asarray(base_in_odom, float)
        nodes = np.searchsorted(stamps, self.stamps_s)
        if np.any(np.diff(stamps) <= 0.0) or not np.isin(self.stamps_s, stamps).all():
            raise StateError("The stamps of odometry must ascend, and the trajectory's be among them.")
        before = np.clip(np.searchsorted(self.stamps_s, stamps, side="right") - 1, 0, len(nodes) - 1)
        after = np.minimum(before + 1, len(nodes) - 1)
        start, end = self.poses_in_map[before], self.poses_in_map[after]
        moved = se2.compose(start, se2.between(odometry[nodes[before]], odometry))
        reached = se2.compose(start, se2.between(odometry[nodes[before]], odometry[nodes[after]]))
        missed = end - reached
        missed[:, 2] = se2.wrap(missed[:, 2])
        duration = np.maximum(self.stamps_s[after] - self.stamps_s[before], 1e-9)
        share = np.where(after > before, (stamps - self.stamps_s[before]) / duration, 0.0)
        if has_jumped is not None:
            jumps = np.cumsum(has_jumped)
            first, of_all = jumps[nodes[before]], jumps[nodes[after]] - jumps[nodes[before]]
            share = np.where(of_all > 0, (jumps - first) / np.maximum(of_all, 1), share)
        filled = moved + np.clip(share, 0.0, 1.0)[:, None] * missed
        filled[:, 2] = se2.wrap(filled[:, 2])
        return filled


class Node:
    """One pose of a particle's path; particles with a common past share its nodes.

    Python frees a branch by itself when no particle's path uses it.
    """

    __slots__ = ("parent", "pose")

    def __init__(self, pose: tuple[float, float, float], parent: Node | None):
        self.pose = pose
        self.parent = parent


@dataclass(frozen=True, eq=False)
class TreeState:
    """A `TrajectoryTree` to save."""

    node_poses: np.ndarray
    """(n, 3) x, y, yaw of every node."""
    node_parents: np.ndarray
    """(n,) index of the node before it; -1: it is the first of a path."""
    leaves: np.ndarray
    """(particles,) index of each path's last node; -1: the path is empty."""
    stamps_s: np.ndarray
    """(k,) of the nodes of a path."""


class TrajectoryTree:
    """The paths of all particles, a tree with a leaf for each."""

    def __init__(self, particles: int):
        self.stamps_s: list[float] = []
        self.leaves: list[Node | None] = [None] * particles
        self._known: list[Node] = []
        self._known_poses = np.empty((0, 3))
        """The last path that was asked for. The next one mostly begins with it."""

    def extend(self, stamp_s: float, poses: np.ndarray) -> None:
        """Add a pose (particles, 3) to every path."""
        self.stamps_s.append(float(stamp_s))
        self.leaves = [Node(tuple(pose), parent) for pose, parent in zip(poses.tolist(), self.leaves)]

    def resample(self, parents: np.ndarray) -> None:
        """Give particle i the path of particle parents[i]."""
        self.leaves = [self.leaves[parent] for parent in parents.tolist()]

    def path(self, particle: int) -> np.ndarray:
        """Return one particle's poses (k, 3), the first one first."""
        new, node, left = [], self.leaves[particle], len(self.stamps_s)
        while node is not None and not (left <= len(self._known) and self._known[left - 1] is node):
            new.append(node)
            node, left = node.parent, left - 1
        new.reverse()
        poses = np.array([node.pose for node in new]).reshape(-1, 3)
        self._known = self._known[:left] + new
        self._known_poses = np.concatenate([self._known_poses[:left], poses])
        return self._known_poses.copy()

    def replace(self, poses: np.ndarray) -> None:
        """Give all particles one path (k, 3)."""
        node = None
        for pose in poses.tolist():
            node = Node(tuple(pose), node)
        self.leaves = [node] * len(self.leaves)

    def state(self) -> TreeState:
        """Return all paths."""
        index: dict[int, int] = {}
        poses: list[tuple] = []
        parents: list[int] = []
        for leaf in self.leaves:
            branch, node = [], leaf
            while node is not None and id(node) not in index:
                branch.append(node)
                node = node.parent
            for node in reversed(branch):
                index[id(node)] = len(poses)
                poses.append(node.pose)
                parents.append(-1 if node.parent is None else index[id(node.parent)])
        leaves = [-1 if leaf is None else index[id(leaf)] for leaf in self.leaves]
        return TreeState(
            np.array(poses).reshape(-1, 3),
            np.array(parents, np.int64),
            np.array(leaves, np.int64),
            np.array(self.stamps_s),
        )

    @classmethod
    def from_state(cls, state: TreeState) -> TrajectoryTree:
        """Return the tree of a state.

        Raises:
            ValueError: it is no tree, or a path is not as long as there are stamps.
        """
        poses, parents, leaves, stamps = state.node_poses, state.node_parents, state.leaves, state.stamps_s
        if poses.shape != (len(parents), 3) or not np.isfinite(poses).all():
            raise ValueError("the path's nodes are no poses")
        nodes: list[Node | None] = [None]  # before the first of a path
        depths = [0]
        for index, (pose, parent) in enumerate(zip(poses.tolist(), parents.tolist())):
            if not -1 <= parent < index:
                raise ValueError(f"node {index} of the path comes from {parent}")
            nodes.append(Node(tuple(pose), nodes[parent + 1]))
            depths.append(depths[parent + 1] + 1)
        if any(not -1 <= leaf < len(parents) or depths[leaf + 1] != len(stamps) for leaf in leaves):
            raise ValueError("the particles' paths are not as long as there are stamps")
        tree = cls(len(leaves))
        tree.leaves = [nodes[leaf + 1] for leaf in leaves.tolist()]
        tree.stamps_s = stamps.tolist()
        return tree
