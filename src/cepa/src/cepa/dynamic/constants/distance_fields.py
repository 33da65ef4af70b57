"""Distance fields: grids around the UAV, in the plane and in layers of heights."""

from __future__ import annotations

FIELD_WINDOW_M = 15.0
"""m: Edge of the distance field around the UAV. Source: grid. Greater: more time; at 4 m/s it brakes within 4
m."""
FIELD_CELL_M = 0.1
"""m: Its cells. Source: grid. Greater: faster; gaps look narrower."""
FINEST_CELL_M = 0.03
"""m: Cells are no smaller than this, however little r_LB leaves beside the body. Source: grid. Greater:
openings that fit a small UAV look closed."""
LAYERS = 15
"""1: Layers of heights. Source: grid. Greater: ways farther up and down."""
LAYER_M = 0.15
"""m: From layer to layer. Source: grid. Greater: coarser; more height is kept."""
FINEST_LAYER_M = 0.1
"""m: From layer to layer, where cells are smaller than FIELD_CELL_M. Source: grid. Greater: a manhole needs
more height."""
HEIGHT_ERROR_M = 0.05
"""m: Added to the body below and above, for the odometry and what cells round. Source: chosen. Greater: more
height is kept."""
SHADING_M = 1.0
"""m: What is so much higher or lower than the lidar does not reach to other heights. Source: chosen. Greater:
the floor blocks."""
