"""Free space: what counts as seen free, by scans, by clouds and by range finders."""

from __future__ import annotations

# -- in the plane ------------------------------------------------------------------------------------------
RANGE_BINS = 360
"""1: Directions of free ranges. Source: grid. Greater: finer, more time."""
RANGE_MARGIN_M = 0.4
"""m: A path ends so far before the lidar's range. Source: chosen. Greater: slower at top speed."""
LEVEL_RANGE_M = 0.7
"""m: A beam farther above or below the lidar may pass over a part of a thing. Source: chosen. Greater: a
leaning lidar changes sizes."""
SHOWN_HEIGHT_M = 1.5
"""m: A beam so far above the lidar may pass over a wall. Source: chosen. Greater: walls seem to move."""
EARLIER_SCANS = 40
"""1: Earlier scans that cover the blind sector while something comes. A UAV that flies back from people needs
more than 2 s of them. Source: flown. Greater: it remembers longer what was free."""
NEWEST_SCANS = 20
"""1: So many of them do while nothing comes. Source: grid. Greater: it turns less often to look for a way."""
EARLIER_PERIOD_S = 0.1
"""s: Time between them. Source: grid. Greater: longer memory, fewer places."""
BLIND_STEP_M = 0.2
"""m: Step in which the blind sector is asked for. Source: grid. Greater: faster, coarser."""
BLIND_REACH_M = 3.0
"""m: It is asked for so far. Source: chosen. Greater: faster flight backwards."""
OWN_PLACE_M = 0.25
"""m: Around the body so much counts as free where nobody has looked. Source: chosen. Greater: farther blind
steps."""
BLIND_WAY_M = 0.5
"""m: The UAV may go so far without a look. Source: flown. Greater: it touches what stands behind it."""
BLIND_WAY_M_RAD = 1.0
"""m/rad: And so much farther for each rad that it has turned. Source: flown. Greater: the same."""
ELSEWHERE_M = 1.0
"""m: So far from the last look it has flown in the open since. Source: chosen. Greater: it turns back more
often."""
OWN_PLACE_BINS = 360
"""1: Directions in which the own place's rim is known. Source: grid. Greater: finer."""

# -- in space ----------------------------------------------------------------------------------------------
PICTURE_ROW_TAN = 0.005
"""1: Height of a row in a cloud's picture, as tangent. Source: grid. Greater: coarser."""
PICTURE_ROWS = 324
"""1: Rows of the picture. Source: grid. Greater: a wider view up and down."""
HIGH_PICTURE_ROWS = 516
"""1: Rows of the picture of a lidar that looks farther up or down than these rows. Source: grid. Greater: a
wider view up and down."""
PICTURE_BINS = 720
"""1: Columns of the picture. Source: grid. Greater: finer."""
COARSE_ROWS = 27
"""1: Rows of 3.4 degrees: no lidar's channels are farther apart, so an empty one in view is free. Source:
grid. Greater: gaps between channels look free."""
COARSE_BINS = 360
"""1: Columns of the coarse picture. Source: grid. Greater: finer."""
FEWEST_RETURNS = 10
"""1: A cloud with fewer points shows nothing free: the lidar may be covered. Source: chosen. Greater: an
empty field looks unseen."""
SEEN_CELL_M = 0.2
"""m: Edge of the cells that are stamped when seen. Source: grid. Greater: faster, coarser."""
SEEN_LEVEL_M = 0.15
"""m: Their height. Source: grid. Greater: faster, coarser."""
SEEN_WINDOW_M = 15.0
"""m: Edge of the window in which they count. Source: grid. Greater: more time."""
SEEN_CELLS = 96
"""1: Cells along an edge. Source: grid. Greater: more memory."""
SEEN_LEVELS = 24
"""1: Levels of cells. Source: grid. Greater: more memory."""
SEEN_REACH_UP_M = 1.5
"""m: Cells farther up or down are forgotten. Source: grid. Greater: at most half of all levels."""
BODY_SHARE_SEEN = 0.67
"""1: Share of the body's height that must be in what was seen. Source: chosen. Greater: it climbs less."""
NEAR_M = 1.5
"""m: Nearer, what was seen stays seen: little is in the field of view. Source: chosen. Greater: what comes
near is trusted for longer."""
OWN_REACH_M = 1.0
"""m: Around the body, for all that it could reach from its own place. Source: chosen. Greater: no
difference."""
SLAB_MORE_M = 0.3
"""m: What moves is tracked so far above and below the body, and so far from floor and ceiling. Source:
chosen. Greater: it evades what passes over it."""
SLAB_OWN_M = 0.05
"""m: The body's own heights, with this beyond them. What has stood for long outside of them, as the sill of a
manhole, does not hide what is behind it. Source: chosen. Greater: a low sill hides more."""
SLAB_BEHIND_M = 0.3
"""m: What is behind is so much farther away. Source: chosen. Greater: what is close behind a sill is
found later."""
SLAB_BINS = 720
"""1: Directions in which a cloud's nearest point is tracked. Source: grid. Greater: finer."""
SLAB_GAP_BINS = 4
"""bins: Between two columns of a cloud that are so near, a planar scan does not look past a thing. Source:
chosen. Greater: sparser clouds show things whole; of two that are beside each other, what is between them is
found later."""
SLAB_RANGE_M = 20.0
"""m: It is tracked up to here; farther away the channels are too far apart. Source: chosen. Greater: things
flicker between channels."""
