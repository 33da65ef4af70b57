"""Obstacle tracks: what belongs together, what moves, and for how long it is kept."""

from __future__ import annotations

import math

# -- scans and odometry ------------------------------------------------------------------------------------
LATE_S = 0.03
"""s: Odometry that is no older than this at a scan is in time. Source: chosen. Greater: what stands seems to
move."""
LONGEST_WAIT_S = 0.5
"""s: A scan that has waited longer for its odometry is dropped. Source: chosen. Greater: older scans
count."""
LONGEST_POSE_GAP_S = 0.3
"""s: Between poses farther apart nothing is interpolated. Source: chosen. Greater: wrong turns of the UAV
count."""
TURN_RATE_S = 0.05
"""s: The turn rate is taken over at least so much time. Source: chosen. Greater: smoother, later."""
KEPT_POSES = 64
"""1: Poses to interpolate between. Source: grid. Greater: no difference."""
LONGEST_SCAN_GAP_S = 0.5
"""s: Without a scan for longer all tracks are forgotten. Source: chosen. Greater: older tracks count."""
BESIDE_DISC_M = 0.15
"""m: A point so near to the rim of what moves belongs to it. Source: chosen. Greater: what stands beside it
is not remembered."""

# -- clusters and sides ------------------------------------------------------------------------------------
ADJACENT_RAD = math.radians(3.0)
"""rad: What stands before an end of a cluster within this angle hides the rest. Source: chosen. Greater:
fewer known sides."""
GRAZING_SINE = 0.2
"""1: A side is seen from this sine of the angle of sight on. Source: chosen. Greater: fewer known sides."""
CUT_OFF_M = 0.3
"""m: So near to an end that is cut off, no side is known. Source: chosen. Greater: fewer known sides."""
SIDES_DAMPING = 0.2
"""1: So much of one side holds a thing where it was predicted. Source: chosen. Greater: velocities come
later."""
SIDES_OUTLIER_M = 0.1
"""m: A side that is off by more counts little. Source: chosen. Greater: wrong sides count."""
SIDES_NEW_M = 0.25
"""m: A side that is off by more, while others agree, is measured anew. Source: chosen. Greater: what comes
into view in parts gets a wrong velocity."""
SIDES_AGREE = 2
"""1: So many sides must agree within SIDES_OUTLIER_M for that. Source: chosen. Greater: the same."""
RESIZED_M = 0.08
"""m: A cluster that is smaller by so much may be cut off by a leaning lidar. Source: chosen. Greater:
rarer."""
RESIZED_SHARE = 0.1
"""1: The same as a share of the radius. Source: chosen. Greater: rarer."""
CLUSTERS_MAX = 256
"""1: Clusters of a scan. Source: grid. Greater: more memory."""

# -- tracks ------------------------------------------------------------------------------------------------
TRACKS_MAX = 192
"""1: Tracks. Source: grid. Greater: more time where many things stand."""
STANDING_FORGET_S = 0.3
"""s: What stands is kept so long unseen. Source: chosen. Greater: more tracks."""
FORGET_BEHIND_S = 4.0
"""s: What moves is predicted so long where no beam looks, as behind a UAV that flies away from it. Source:
flown. Greater: it evades what has turned off."""
SPREAD_MOST_M = 1.0
"""m: The error of a place makes a disc no larger than by this. Source: chosen. Greater: what is out of sight
closes more ways."""
MISSED_S = 0.15
"""s: Anything is kept so long where the scan sees past its place. Source: chosen. Greater: it evades what is
gone."""
RADIUS_MEMORY_S = 2.0
"""s: Time constant in which a disc shrinks to what is in sight. Source: chosen. Greater: larger discs."""
SIDES_LEARNING_S = 1.0
"""s: Time constant in which a track learns its sides. Source: chosen. Greater: steadier, later."""
LONG_M = 0.6
"""m: Of a thing with a larger radius only an end enters what was free. Source: chosen. Greater: lorries are
found later."""

# -- drift of the odometry ---------------------------------------------------------------------------------
STANDING_MIN = 4
"""1: So many standing things tell the odometry's drift. Source: chosen. Greater: drift looks like motion in
the open."""
DRIFT_RESIDUAL_M = 0.05
"""m: Standard deviation of a standing thing's middle. Source: chosen. Greater: outliers count more."""
DRIFT_SHIFT_M = 0.05
"""m: Standard deviation of the odometry's place from scan to scan. Source: chosen. Greater: more is
corrected."""
DRIFT_TURN_RAD = 0.02
"""rad: Standard deviation of its heading. Source: chosen. Greater: more is corrected."""

DRIFT_SLACK_M = 0.1
"""m: All corrections of the last scans move a scan no farther: three standard deviations of an odometry's
noise. Source: chosen. Greater: people abreast are found later."""
DRIFT_SLACK_RAD = 0.03
"""rad: Nor do they turn it farther. Source: chosen. Greater: the same."""
DRIFT_RATE_M_S = 0.1
"""m/s: Besides, the corrections follow a drift of this rate. Source: chosen. Greater: slow things that move
alike stand."""
DRIFT_RATE_RAD_S = 0.03
"""rad/s: The same of the heading; 0.24 m/s at 8 m. Source: chosen. Greater: the same."""

# -- evidence ----------------------------------------------------------------------------------------------
EVIDENCE_SCANS = 12
"""1: Earlier scans that tell what was free. Source: chosen. Greater: slower things are found."""
EVIDENCE_PERIOD_S = 0.1
"""s: Time between them. Source: chosen. Greater: slower things are found, later."""
EVIDENCE_YOUNGEST_S = 0.15
"""s: Least age of such a scan. Source: chosen. Greater: motion is found later."""
EVIDENCE_HEIGHT_M = 0.15
"""m: A scan that looks so much higher or lower tells nothing: what slopes or ends seems to move. Source:
chosen. Greater: motion is found sooner while the UAV climbs, or leans in space."""
EVIDENCE_SAMPLES = 12
"""1: Points of a thing that are looked at. Source: grid. Greater: more time."""
EVIDENCE_MAX_S = 0.5
"""s: Most evidence that a track has. Source: chosen. Greater: what has stopped counts as moving for
longer."""
EVIDENCE_LOSS_OF_FAST = 0.1
"""s/s: Evidence that something fast loses while it does not show that it moves. Source: chosen. Greater:
forgotten earlier."""
EVIDENCE_LOSS_OF_SLOW = 0.5
"""s/s: The same of something slow. Source: chosen. Greater: forgotten earlier."""
EVIDENCE_LEFT = 0.5
"""1: Share of its evidence that a thing out of sight leaves to what appears near its place. Source: chosen.
Greater: what stands there seems to move for longer."""
HEADING_ERROR_RAD = 0.005
"""rad: Directions within this must agree that a place was free. Source: chosen. Greater: less evidence."""

# -- what clouds know better -------------------------------------------------------------------------------
STOOD_S = 1.0
"""s: What clouds have shown for so long stands. Source: chosen. Greater: more of what stands seems to
move."""
STOOD_APART_M = 0.12
"""m: It is the same thing within so much in the plan. Source: chosen. Greater: who starts to walk is found
later."""
STOOD_UP_M = 0.6
"""m: And so much higher or lower. Source: chosen. Greater: who walks over a low step stands."""
STOOD_NEW_SHARE = 0.4
"""1: A thing moves if this does not hold for such a share of its points; less of a thing that is longer than
LONG_M, as its front only comes to free places. Source: chosen. Greater: slow things stand."""

# -- what sinks or rises, by range finders -----------------------------------------------------------------
ARRIVES_S = 6.0
"""s: What would be at the body's height within so much closes its column; from under the middle of a load of
2 m the UAV needs 2.5 s. Source: chosen. Greater: it makes way for loads that are still far up."""
SINKING_FORGET_S = 2.0
"""s: The column stays closed for so long after it. Source: chosen. Greater: it waits longer beside a load."""
SINKING_RADIUS_M = 1.5
"""m: A load may reach so far from the spot that the beam meets: half the diagonal of 2 m by 2 m. Source:
chosen. Greater: it leaves farther."""
SINKING_GAP_M = 0.4
"""m: Heights that jump by more belong to different things. Source: chosen. Greater: steps look like
motion."""
SINKING_LEAST_M_S = 0.1
"""m/s: What is slower stands. Source: chosen. Greater: slow loads are found by the lidar only."""
SINKING_SLOPE = 0.5
"""1: And what is slower than such a share of the UAV's own speed may be a slope. Source: chosen. Greater:
loads are found later while the UAV flies fast."""
SINKING_SLOPE_OF_ROOFS = 1.2
"""1: The same under a roof, where clouds show loads from afar: hopper plates slope by 45 degrees. Source:
chosen. Greater: loads that clouds do not show are found later while the UAV flies fast."""
SINKING_SOON_S = 1.0
"""s: Unless the body would meet it so soon. Source: chosen. Greater: the UAV makes way for slopes, too."""
SINKING_RESIDUAL_M = 0.05
"""m: Heights that are farther off a straight line are no even motion. Source: chosen. Greater: rough ceilings
move."""
SINKING_NOISE_M = 0.015
"""m: Heights are no more exact than this, even if they happen to lie on a line. Source: chosen. Greater:
found later."""
SINKING_UNEVEN = 0.12
"""1: Nor are those that are farther off by this share of the way down; a step is off by 0.17. Source: chosen.
Greater: stiffeners that the UAV passes come down."""
SINKING_SPANS_S = (0.1, 0.25, 0.5, 1.0)
"""s: The speed is taken over the first of these times in which it is significant. Source: chosen. Greater:
slower loads are found, later."""
SINKING_OPEN_M = 8.0
"""m: Nothing is over the UAV that is nearer: it is in the open, and not in a tank. Source: chosen. Greater:
under high ceilings, loads that clouds do not show are found later."""
SINKING_FEWEST = (3, 5, 5, 5)
"""1: Heights that tell a speed, of each of these spans. Source: chosen. Greater: found later by slow range
finders."""
SINKING_KEPT = 100
"""1: Heights that are kept. Source: grid. Greater: no difference."""
SINKING_SIGNIFICANCE = 3.0
"""1: The speed counts if it is so many times its standard deviation. Source: chosen. Greater: found later."""
SINKING_MISS_S = 1.0
"""s: A spot that the beam has passed freely so short ago is beside the load. Source: chosen. Greater: older
spots count."""
SINKING_SURE_S = 1.5
"""s: What arrives later than that counts only when it was found `SINKING_TIMES`. Source: flown. Greater:
plates and stiffeners over a beam that leans count as loads."""
SINKING_TIMES = 2
"""1: Findings without a break after which it counts: plates and stiffeners over a beam that leans look once
like a load. Source: flown. Greater: found later."""
SINKING_TIMES_OF_ROOFS = 5
"""1: The same under a roof, where clouds show loads from afar: a beam that leans runs down a tank's webs.
Source: flown. Greater: loads that clouds do not show are found later."""
SINKING_SIGN_M = 2.0
"""m: In the open, what appears over the body within so much may be a load. The UAV goes back until it knows.
Source: chosen. Greater: it goes back for more of what stands."""
SINKING_SIGN_HEIGHTS = 6
"""1: It knows after so many heights, or after `SINKING_FORGET_S`. Source: chosen. Greater: it goes back
farther."""
SINKING_SIGN_PAUSE_S = 3.0
"""s: Then it does not go back for so long, so that it passes under what stands. Source: chosen. Greater: a
second load is found later."""
SINKING_FASTEST_M_S = 2.0
"""m/s: Until it knows, it counts on such a load. Source: chosen. Greater: it hurries more."""
UPRIGHT_COSINE = 0.9
"""1: A range finder that leans farther tells no height. Source: chosen. Greater: none while the UAV
accelerates."""

# -- what comes down, by clouds ----------------------------------------------------------------------------
FALLING_CELL_M = 0.5
"""m: Cells of the plan in which the lowest point counts. Source: grid. Greater: small loads hide beside
others."""
FALLING_CELLS = 32
"""1: Cells along an edge; twice FALLING_REACH_M, and what the UAV flies in the longest span. Source: grid.
Greater: more time."""
FALLING_REACH_M = 6.0
"""m: So far to each side. Source: chosen. Greater: loads are found earlier by a fast UAV."""
FALLING_HIGHEST_M = 8.0
"""m: And so far up. Source: chosen. Greater: fast loads are found earlier."""
FALLING_SPANS_S = (0.2, 0.5, 1.0, 2.0)
"""s: The speed is taken over each of these times. Source: chosen. Greater: slower loads are found, later."""
FALLING_UNEVEN = 0.15
"""1: Over the shortest of them, heights that are farther off a line by this share of the way down are no even
motion; one step in five clouds is off by 0.2. Source: chosen. Greater: stiffeners that the UAV passes come
down."""
FALLING_LEVEL_M = 0.15
"""m: What is new beside a load, and differs by less in height, belongs to it. Source: chosen. Greater: it
leaves farther."""
FALLING_FEWEST = 4
"""1: Clouds that tell a speed. Source: chosen. Greater: found later by slow lidars."""
FALLING_DROP_M = 0.1
"""m: It has come down by at least so much. Source: chosen. Greater: found later."""
FALLING_SPREAD = 0.035
"""m/m: Two channels of a lidar are so far apart at 1 m: 2 degrees, as a Puck's. Source: measured. Greater:
found later, and what stands falls more rarely."""
FALLING_RESIDUAL_M = 0.05
"""m: Heights that are farther off a straight line are no even motion. Source: chosen. Greater: what is uneven
falls."""
FALLING_BESIDE_M = 0.15
"""m: The way that something comes down was free so far beside and below, too. Source: flown. Greater: loads
beside a wall are found later."""
FALLING_WALL_M = 0.3
"""m: What reaches on down by less than this below the UAV's highest point is a wall: of that, what is lowest
over the UAV sinks as the UAV does. Source: chosen. Greater: loads beside walls are found later."""
FALLING_APART_M = 1.5
"""m: Cells within so much are one load. Source: chosen. Greater: two loads are one."""
FALLING_BEYOND_M = 0.5
"""m: A load reaches so far beyond the middle of its outermost cell: the diagonal of half a cell, and what is
not seen. Source: grid. Greater: it leaves farther."""
FALLING_SIGN_M = 2.0
"""m: In the open, what comes into view over the body within so much sinks faster than the UAV flies under it.
Source: chosen. Greater: it makes way for more of what stands."""
FALLING_SIGN_S = 0.3
"""s: It is new if clouds that are older than this have not shown it. Source: chosen. Greater: it counts for
longer until its speed is known."""
FALLING_SIGN_KEPT_S = 0.8
"""s: Clouds that are older than this do not tell. Source: chosen. Greater: less of what was hidden counts."""
FALLING_SIGN_LATE_S = 0.5
"""s: It may arrive so much later than a load that sinks at SINKING_FASTEST_M_S. Source: chosen. Greater: it
makes way for longer where nothing comes."""
SHOWS_LOADS_RAD = math.radians(45.0)
"""rad: Clouds that look up so steeply show a load that sinks as fast as the UAV flies. If they look up less,
the range finder finds loads in the open as it does without clouds. Source: chosen. Greater: the UAV makes
way for more of what stands."""
FALLING_LARGEST_M = 2.0
"""m: A load of which the near side is over the highest channel may be so long. Source: chosen. Greater: it
leaves farther."""
