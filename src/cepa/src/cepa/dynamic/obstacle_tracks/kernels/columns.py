"""The columns of clusters and of tracks, and the directions in which sides are measured.

A cluster's row is first and end index of its points, middle x and y, radius (m), x and y of the point in its
middle, and how its first and last end are cut off: NOT_CUT, TILTED or HIDDEN. A track's row is x, y (m) of a
disc that holds the thing, velocity (m/s), variance of position, covariance, variance of velocity (per axis),
the disc's radius (m), time unseen, evidence (s), and how far the thing reaches from (x, y) along each of
NORMALS (m, NaN where nobody has seen it).
"""

from __future__ import annotations

import math

import numpy as np

FIRST, END, MIDDLE_X, MIDDLE_Y, SIZE, SURFACE_X, SURFACE_Y, CUT_FIRST, CUT_LAST, CLUSTER_COLUMNS = range(10)
NOT_CUT, TILTED, HIDDEN = 0.0, 1.0, 2.0
"""An end is the thing's own, or its beams are far from level, or it is where something hides the rest."""
NORMALS = np.array([(math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(16)])
"""The directions in which a thing's sides are measured."""
X, Y, VX, VY, PP, PV, VV, RADIUS, UNSEEN, EVIDENCE, REACH = range(11)
TRACK_COLUMNS = REACH + len(NORMALS)
