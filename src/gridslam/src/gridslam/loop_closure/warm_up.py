"""Compiles the kernels of loop closure ahead of their first use."""

from __future__ import annotations

import math
import time

import numpy as np

from gridslam.kernels.least_squares import inverses
from gridslam.kernels.links import nearest_earlier
from gridslam.kernels.pose_graph import covariance_of, shortest_ways
from gridslam.loop_closure.edges import Edge, Edges
from gridslam.loop_closure.links.scan_pairs import link_pairs
from gridslam.loop_closure.local_maps.correlation import Correlation, Window
from gridslam.loop_closure.local_maps.local_map import LocalMapSizes, build_local_map, surface_points
from gridslam.loop_closure.local_maps.refinement import refine
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.pose_graph import optimise
from gridslam.maps.new_map import MapDraft
from gridslam.maps.scan_surfaces import ScanSurfaces, surfaces_of
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan


def warm_up_loop_closure() -> float:
    """Match a small map and a scan with themselves, optimise a path, draw a map; return the seconds."""
    start = time.perf_counter()
    angles = np.linspace(-math.pi, math.pi, 120, endpoint=False)
    ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    scan = PlanarScan(0.0, angles, ranges, (0.0, 0.0, 0.0), 10.0)
    surface = surface_points(scan, 10.0)
    local_map = build_local_map(0, [surface], [scan], np.zeros((1, 3)), LocalMapSizes(0.1, 0.2, 0.1, 10.0))
    Correlation(local_map, local_map, Window(np.zeros(3), 1.0, 0.1)).best(0.5, 0.2)
    refine(surface, surface, np.zeros(3), 0.2)
    steps = [Edge(0, 1, np.zeros(3), np.eye(3)), Edge(1, 2, np.zeros(3), np.eye(3))]
    optimise(np.zeros((3, 3)), Edges.of(steps))
    inverses(np.eye(3)[None])
    nodes = np.arange(2)
    shortest_ways(3, nodes, nodes + 1, np.ones(2), 0)
    covariance_of(np.zeros((3, 3)), nodes, nodes + 1, np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)), 2)
    nearest_earlier(np.zeros((1, 3)), np.zeros(1), 0, 1.0, 1.0, 1)
    surfaces = ScanSurfaces([surfaces_of(scan, 10.0)] * 2)
    link_pairs(np.array([(0, 1)]), surfaces, np.zeros((1, 1, 3)), LoopClosureParameters(), is_pass=True)
    parameters = SlamParameters()
    MapDraft(parameters, None).add(np.zeros((1, 3)), [scan])
    return time.perf_counter() - start
