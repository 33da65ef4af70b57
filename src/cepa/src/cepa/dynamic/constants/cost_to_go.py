"""Cost-to-go: which cells are open, what a metre costs in them, dead ends, and the height to fly at."""

from __future__ import annotations

# -- grid and slowness -------------------------------------------------------------------------------------
WAY_CELL_M = 0.25
"""m: Cells of the search. Source: grid. Greater: faster; gaps look closed."""
ROUNDS = 8
"""1: Most rounds of sweeping. Source: grid. Greater: mazes are solved to the end."""
CLOSED_M = 0.0
"""m: The way keeps so much more than r_LB. Source: chosen. Greater: narrow openings count as closed."""
SLOWER = 1.0
"""1: Beside an obstacle a metre costs so much more than in proportion to the nearness. Source: chosen.
Greater: wide ways come first."""
FAVOUR = 0.8
"""1: A metre along the last way counts so much. Source: chosen. Greater: the UAV wavers between two ways."""
OWN_CELLS = 2
"""cells: Around the UAV all is open: it is there, so it can leave. Source: chosen. Greater: thin walls beside
it count as open."""
OWN_SLOWNESS = 3.0
"""1: A metre costs at most so much there. Source: chosen. Greater: it leaves more carefully."""
EXIT_COST = 1.5
"""1: What a metre costs beyond the window, where nobody knows what stands. Source: chosen. Greater: shorter
detours inside."""
WAY_SLOPE_LEAST = 0.2
"""m/m: Over two cells: on a flatter slope of the cost-to-go a path goes straight on. Source: chosen. Greater:
fewer turns near the end."""
WAY_SLOPE_MOST = 20.0
"""m/m: So it does on a steeper one, beside cells without a way. Source: chosen. Greater: more of them
count."""
NO_WAY_M = 10.0
"""m: Where no way begins, progress counts as if the way were so much longer. Source: chosen. Greater: it
stays farther away from there."""
LAYER_PENALTY_1_M = 0.5
"""1/m: A metre costs so much more for each metre off the height. Source: chosen. Greater: rather around than
over."""

# -- openings ----------------------------------------------------------------------------------------------
HYSTERESIS_M = 0.04
"""m: An opening keeps its state within so much. Source: chosen. Greater: less wavering, later changes."""
STAY_S = 3.0
"""s: It does so for so long. Source: chosen. Greater: the same."""
STAY_CELLS = 64
"""cells: The UAV flies fewer in this time. Source: grid. Greater: more memory."""
STALL_S = 3.0
"""s: A UAV that stays within STALL_M for so long has got nowhere. Source: chosen. Greater: it waits
longer."""
STALL_M = 0.5
"""m: See STALL_S. Source: chosen. Greater: slow flight counts as none."""
GIVEN_UP_M = 2.0
"""m: It then gives up what is narrow in so much of its way. Source: chosen. Greater: more is given up."""
NARROW_M = 0.1
"""m: What leaves less than r_LB and this is narrow. Source: chosen. Greater: more is given up."""
PAUSE_S = 0.5
"""s: A UAV that wants no way for so long hovers; nothing kept it. Source: chosen. Greater: a hover counts as
a stall."""
CLEAR_S = 3.0
"""s: A UAV that flies a clear way for no longer is still on the same flight. Source: chosen. Greater: ways
that cross earlier ones count as returns."""
NARROWER_M = 0.1
"""m: If there is no other way, openings that leave so much less than r_LB count. Source: chosen. Greater: it
tries what it cannot fly through."""
SLOW_NARROW = 6.0
"""1: What a metre costs there. Source: chosen. Greater: longer detours instead."""

# -- ways that lead back, and dead ends --------------------------------------------------------------------
LEADS_BACK_M = 15.0
"""m: A way so much longer than the straight one leads back. Source: chosen. Greater: it goes farther
around."""
AHEAD_M = 2.0
"""m: If every way leads back, what is closed farther ahead counts as slow. Source: chosen. Greater: fewer
tries."""
SLOW_AHEAD = 6.0
"""1: What a metre costs there. Source: chosen. Greater: fewer tries."""
CELLS_AHEAD = 2
"""cells: A way leads away if it is no shorter from so many cells ahead. Source: chosen. Greater: more ways
do."""
DEAD_END_S = 120.0
"""s: For so long nobody tries the same dead end again. Source: chosen. Greater: a door that opens is found
later."""
DEAD_END_APART_M = 1.0
"""m: The UAV closes it behind itself each time that it has come so far. Source: chosen. Greater: fewer
closings."""
MOST_DEAD_ENDS = 40
"""1: So many closings are kept. Source: grid. Greater: more memory."""
DEAD_END_BEHIND_M = 2.5
"""m: The closing is so far behind the UAV. Source: chosen. Greater: it may turn back farther."""
DEAD_END_THICK_M = 1.25
"""m: It is so thick that no way leads through. Source: grid. Greater: more cells."""
DEAD_END_CELLS = 400
"""cells: A wider closing is none. Source: grid. Greater: wide halls count as dead ends."""
END_REACH_M = 1.0
"""m: The UAV goes so near to an end that it cannot reach. Source: chosen. Greater: farther from it."""

# -- heights -----------------------------------------------------------------------------------------------
HEIGHT_GAIN_S = 1.0
"""s: It climbs so that it would be at its height after this time, as the position controller does. Source:
measured. Greater: slower climbs."""
STAY_SHARE = 0.3
"""1: A metre off the own height counts so much of one off the height asked for. Source: chosen. Greater: it
stays."""
WITHIN_LAYER = 0.3
"""1: In fine layers it flies so much of a layer off the middle of the open one, towards the height asked for.
Source: flown. Greater: nearer to that height, and to the layer that is closed."""
OPEN_AHEAD_M = 2.0
"""m: A height is open if so much straight ahead is. Source: chosen. Greater: it climbs earlier."""
OPEN_AHEAD_S = 1.6
"""s: Or what it flies in this time. Source: chosen. Greater: it climbs earlier."""
LONGEST_SEARCH_M = 5.0
"""m: So far above and below it looks for a way. Source: chosen. Greater: longer searches."""
SILENCE_PERIODS = 3.0
"""1: The planar scan counts after so many periods without a cloud. Source: chosen. Greater: it flies longer
by old clouds."""
SILENCE_LEAST_S = 0.3
"""s: But not before this. Source: chosen. Greater: the same."""
SILENCE_MOST_S = 1.0
"""s: And not after this. Source: chosen. Greater: the same."""
CLOUD_PERIOD_SHARE = 0.1
"""1: Share of a new period between clouds in their mean. Source: chosen. Greater: the mean follows faster."""

# -- a UAV that comes back ---------------------------------------------------------------------------------
RETURN_STEP_M = 0.5
"""m: The trail has a place each so much. Source: grid. Greater: faster, coarser."""
RETURN_APART_M = 0.75
"""m: The UAV has come back to a place within so much. Source: chosen. Greater: it wavers less, and passes
nearer to its own trail as if it came back."""
RETURN_WAY_M = 4.0
"""m: After a way of at least so much. Source: chosen. Greater: small wavering is not noticed."""
RETURN_S = 40.0
"""s: The trail is so long. Source: chosen. Greater: longer rounds are noticed."""
RETURNS_S = 120.0
"""s: Returns count for so long. Source: chosen. Greater: it keeps to narrow openings and closings longer."""
RETURN_NARROW_S = 20.0
"""s: After a return narrow openings count for so long beside the others. Source: chosen. Greater: more narrow
openings are flown."""
RETURNS_KEEP = 2
"""1: From this return on the UAV keeps to the side that it flies to. Source: chosen. Greater: it wavers
longer."""
SIDE_FREE_M = 6.0
"""m: It does so until so much is open straight ahead. Source: chosen. Greater: it goes farther around."""
SIDE_S = 90.0
"""s: But not longer. Source: chosen. Greater: it goes around longer walls, and farther from a way that
opens."""
RETURNS_TOLD = 3
"""1: So many returns are told. Source: chosen. Greater: later."""
