"""The choice of a velocity: candidates, distances to keep, cost, emergency, and the reference's end."""

from __future__ import annotations

# -- candidates --------------------------------------------------------------------------------------------
FAN_DIRECTIONS = 48
"""1: Directions that are tried. Source: grid. Greater: finer gaps, more time."""
FAN_SPEEDS = (1.0, 0.6, 0.3, 0.12)
"""1: Speeds that are tried, as shares of the reference's. Source: chosen. Greater: it stops before narrow
gaps."""
EVASION_M_S = 1.5
"""m/s: It evades what moves with so much, even if the reference is slower. Source: chosen. Greater: faster
evasion."""
OUTRUN = 1.5
"""1: It evades who comes nearer with so many times their speed: who is as fast as the UAV drives it before
them, where its lidar does not look. Source: flown. Greater: it is out of their way sooner."""
OUTRUN_MOST_M_S = 3.0
"""m/s: But for that no faster than this, as EU 2019/945 has it near people. Source: chosen. Greater: it also
outruns who cycles."""
SEEN_DISC_M = 0.15
"""m: Where nothing passes what moves, discs of this radius, so far apart, hold what the scan shows of it.
Source: chosen. Greater: fewer ways past it."""
SAME_SPEED_M_S = 1e-6
"""m/s: A candidate is faster than the usual ones only by more than this. Source: grid. Greater: no
difference."""
HURRIED_S = 3.0
"""s: If what sinks onto the UAV arrives within so much, the UAV hurries. Source: chosen. Greater: it hurries
earlier."""
HURRIED_EVASION_M_S = 5.0
"""m/s: Then it evades with so much, so it accelerates as fast as the response allows. Source: chosen.
Greater: it leaves faster, and farther."""
SINK_ALONG_S = 1.5
"""s: If it arrives even sooner, the UAV also sinks while it leaves: its lean lifts it, and the rotors behind.
Source: flown. Greater: it sinks where it need not."""
NOT_COME_S = 0.5
"""s: What should have arrived so long ago has not come: the UAV no longer sinks for it, nor leaves fast for
clouds. Source: chosen. Greater: it gives way longer to what was no load."""
RIM_M = 0.05
"""m: A UAV whose body is in the way of what comes counts as so far within it. Source: chosen. Greater: no
difference."""
HURRIED_BY_CLOUDS_S = 1.0
"""s: Where clouds come, only if they show it, and it arrives so soon: tanks are narrow. Source:
flown. Greater: it leaves fast where it need not."""
FAN_CLIMBS = (-1.0, 0.0, 1.0)
"""1: Climbs that are tried, as shares of `climb_max`. Source: chosen. Greater: beyond 1 they are not
allowed."""
FAN_COARSER = 3
"""1: Every third direction is tried with these climbs. Source: grid. Greater: faster, coarser."""
FAN_FASTER_OF = 2
"""1: One of so many speeds, the faster ones, is tried with them. Source: grid. Greater: fewer, faster
ones."""
LEVEL_CLIMB_M_S = 0.05
"""m/s: A slower climb counts as level. Source: chosen. Greater: fewer candidates."""
LEADS_BACK_COS = 0.5
"""1: A velocity leads back if it is within this angle's cosine. Source: chosen. Greater: a narrower cone."""
SPOT_CLIMBS = (1.0, 0.5, 0.25)
"""1: What it tries when it climbs on the spot, as shares of `climb_max`. Source: chosen. Greater: it climbs
faster."""
STANDS_M_S = 0.1
"""m/s: A UAV that may not climb, and is slower, gives up this direction. Source: chosen. Greater: it gives up
earlier."""

# -- groups of things that move ----------------------------------------------------------------------------
FRONT_APART_M = 1.6
"""m: Two things that leave less room between them are a group: twice r_LB and the growth of both discs.
Source: chosen. Greater: it goes around groups that it could pass through."""
SAME_WAY_M_S = 0.7
"""m/s: And their velocities differ by less. Source: chosen. Greater: people who meet are a group."""
FRONT_S = 3.0
"""s: A group closes the ways that it reaches within so much, as MEETING_S. Source: chosen. Greater: it goes
around from farther away."""
FRONT_M = 1.2
"""m: And no nearer to the UAV than this, as r_UB, or there would be no way out. Source: chosen. Greater: it
goes around nearer to the group."""
FRONT_FILES = 5
"""1: Rows of points from one of a group to its neighbour. Source: grid. Greater: slower, until gaps open."""
FRONT_STEP_M = 0.3
"""m: Points along the way of a group are so far apart. Source: grid. Greater: faster, until gaps open."""

# -- distances to keep -------------------------------------------------------------------------------------
SCAN_NOISE_M = 0.06
"""m: The nearest of a thing's points is nearer than the thing; r_LB is kept within this. Source: chosen.
Greater: it flies nearer."""
LEAST_COMFORT_M = 0.05
"""m: In an emergency comfort begins so far beyond the hull's margin. Source: chosen. Greater: softer."""
DEEPER_M = 0.02
"""m: What is too near already may come so much nearer before it counts as a contact. Source: chosen. Greater:
noise holds the UAV less."""

# -- cost --------------------------------------------------------------------------------------------------
COST_OF_DISCOMFORT = 1.2
"""of k3: Weight of the discomfort (with k3 = 0.5: 0.6). Source: chosen. Greater: wider ways, slower in
gaps."""
UNHURRIED_M_S = 1.0
"""m/s: Up to this speed a metre beside an obstacle is no worse than another. Source: flown. Greater: it cuts
corners faster."""
HURRIED_M_S = 2.0
"""m/s: From this speed on it costs what it does in the cost-to-go. Source: flown. Greater: it passes nearer
at speed."""
COST_OF_LOSS = 1.0
"""1: Cost of the whole horizon lost to a contact with what stands. Source: chosen. Greater: it turns
earlier."""
COST_OF_BEING_HIT = 6.0
"""1: The same with what moves; more than any progress in MEETING_S. Source: flown. Greater: no difference."""
COST_OF_CHANGE = 0.2
"""of k1: Weight of the change of the command, k1 as with k4 = 1 and k5 = 6. Source: chosen. Greater:
steadier."""
USUAL_K4 = 1.0
"""s/m: k4 at which COST_OF_CHANGE counts as it is. Source: chosen. Greater: k4 counts less."""
USUAL_K5 = 6.0
"""1: k5 at which it does. Source: chosen. Greater: k5 counts less."""
COST_OF_HEIGHT_1_M = 0.3
"""1/m: For a metre off the height to fly at. Source: chosen. Greater: it comes back sooner."""
COST_OF_CLIMB_CHANGE_S_M = 0.05
"""s/m: For a change of the climb. Source: chosen. Greater: steadier climbs."""
COST_OF_LEAVING_CHANGE_S_M = 0.02
"""s/m: For a change of the command in an emergency. Source: chosen. Greater: steadier."""
SLOWEST_SCALE_M_S = 1.0
"""m/s: Progress and change count relative to the reference's speed, or to this. Source: chosen. Greater: slow
references turn later."""

# -- emergency ---------------------------------------------------------------------------------------------
EMERGENCY_DEPTH_M = 0.1
"""m: What is so much nearer than r_LB is an emergency, if the UAV idles. Source: chosen. Greater: rarer."""
EMERGENCY_IDLE_SHARE = 0.3
"""1: It idles if its progress is below this share of the reference's. Source: chosen. Greater: more
emergencies."""
EMERGENCY_DIRECTIONS = 72
"""1: Directions in which it looks for r_LB. Source: grid. Greater: finer."""
EMERGENCY_REACH_M = 4.0
"""m: It looks so far. Source: chosen. Greater: it also leaves long pockets."""
EMERGENCY_NARROWNESS = 5.0
"""m/m: It counts as so many metres farther to come nearer to anything by one. Source: chosen. Greater: wider
ways."""
EMERGENCY_TURN_M = 0.5
"""m: It counts as so much farther to turn back. Source: chosen. Greater: it wavers less."""
HARD_BRAKING = 5.0
"""1: A UAV that must brake harder than by standstill is told to fly back, with so many times its speed.
Source: chosen. Greater: it brakes harder at its end, and may fly back a little."""
HARD_BRAKING_FROM_M_S = 0.3
"""m/s: A slower UAV stands soon enough. Source: chosen. Greater: what comes into view late may be touched."""

# -- the reference's end -----------------------------------------------------------------------------------
FORGOTTEN_M = 0.5
"""m: A reference that was measured so much of the way ago counts 1/e. Source: flown. Greater: steadier,
later."""
LEAST_EXPLAINED = 0.5
"""1: The place explains at least so much of the reference's variance. Source: flown. Greater: fewer ends."""
MOST_WAITING_REFERENCES = 8
"""1: References that wait until somebody asks for the end. Source: grid. Greater: no difference."""
END_HORIZONS = 2.0
"""1: An end counts within so many horizons of the cost; a reference that brakes evenly ends at half the way
that its gain tells. Source: chosen. Greater: farther ends count."""

# -- a UAV that gets nowhere -------------------------------------------------------------------------------
HELD_M = 0.5
"""m: A UAV that is asked to fly and stays within so much gets nowhere. Source: chosen. Greater: slow flight
is told."""
HELD_S = 10.0
"""s: It is told after so long. Source: chosen. Greater: later."""
HELD_OWED_M = 1.0
"""m: And only if it was asked to fly so much more than it has flown. Source: chosen. Greater: slow references
are told later."""
HELD_PAUSE_S = 0.5
"""s: A UAV that is not asked to fly for so long hovers as it should. Source: chosen. Greater: a hover
counts."""
