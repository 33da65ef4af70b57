"""What is remembered: points of obstacles in the plane and in space, and beams that stand out alone."""

from __future__ import annotations

# -- points in the plane -----------------------------------------------------------------------------------
POINT_CELL_M = 0.1
"""m: Cells of remembered points; one point each. Source: grid. Greater: less memory, coarser."""
SEEN_PAST_M = 0.3
"""m: A remembered point was seen past when beams end so far beyond it. Source: chosen. Greater: longer
memory."""
TRUST = 4
"""scans: A scan that sees a point makes up for so many that see past it. Source: flown. Greater: ghosts
stay."""
MOST_TRUST = 60
"""scans: At most so many. Source: flown. Greater: ghosts stay."""

# -- points in space ---------------------------------------------------------------------------------------
VOXEL_M = 0.15
"""m: Edge of cells of remembered points. Source: grid. Greater: fewer points."""
VOXEL_HEIGHT_M = 0.05
"""m: Their height. Source: grid. Greater: fewer points."""
VOXELS = 128
"""1: Cells along an edge. Source: grid. Greater: more memory."""
VOXEL_LEVELS = 96
"""1: Levels of cells. Source: grid. Greater: more memory."""
VOXEL_REACH_UP_M = 1.7
"""m: What is farther up or down is forgotten. Source: grid. Greater: at most half of all levels."""
MOST_POINTS = 100000
"""1: Points; the nearest ones stay. Source: grid. Greater: more time and memory."""
SEEN_THROUGH_CLOUDS = 3
"""clouds: So many in a row must see through a point before it is forgotten. Source: chosen. Greater: ghosts
stay."""
BESIDE_UP_M = 0.01
"""m: A beam that passes so near above or below a point tells that it may have gone. Source: flown. Greater:
thin things near the UAV are forgotten."""
PARTS_OF_A_MISS = 20
"""1: So many clouds beside a point count as one through it. Source: flown. Greater: ghosts near the UAV stay,
and so does what swings to and fro."""
GREATEST_MOVE_M = 1.0
"""m: A farther move between two scans drops the memory, because its grids repeat themselves. Source: chosen.
Greater: jumps of the odometry count as flight."""

# -- beams that stand out alone ----------------------------------------------------------------------------
SINGLE_GAP_M = 0.3
"""m: A beam stands out if those on both sides end so much farther. Source: chosen. Greater: rain counts."""
SINGLE_WIDEST = 2
"""beams: At most so many side by side. Source: chosen. Greater: thin poles need to be confirmed."""
SINGLE_PASSES = 4
"""1: Of beams that stand out side by side the nearest is looked at first. Source: chosen. Greater: more rain
is dropped."""
SINGLE_THINNEST_M = 0.004
"""m: A thing so thick is confirmed by as many scans as it is met in. Source: chosen. Greater: thin wires are
lost."""
SINGLE_SHARE = 0.6
"""1: Share of these scans that must show it. Source: chosen. Greater: less rain, later wires."""
SINGLE_ALONG_M = 0.06
"""m: It is found again within so much along the beam. Source: chosen. Greater: rain is confirmed."""
SINGLE_ACROSS_M = 0.02
"""m: The same across the beam. Source: chosen. Greater: rain is confirmed."""
SINGLE_GATE_SHARE = 0.02
"""m/m: Added to both for each metre of range. Source: chosen. Greater: rain is confirmed."""
SINGLE_SCANS = 9
"""scans: So many are compared, with the newest one. Source: chosen. Greater: less rain, later wires."""
SINGLE_WITHIN_S = 0.25
"""s: Or fewer, if they take longer than this. Source: chosen. Greater: the UAV's drift matters."""
SINGLE_FEWEST_SCANS = 3
"""scans: Or more, if the scans are slower. Source: chosen. Greater: later wires."""
SINGLE_FEWEST_MATCHES = 2
"""scans: So many earlier scans must show it at least. Source: chosen. Greater: later wires."""
SINGLE_KEPT = 128
"""1: Such beams of each scan. Source: grid. Greater: more time in rain."""
