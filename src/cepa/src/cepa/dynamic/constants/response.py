"""Time: how finely and how far ahead paths are foreseen, and how the UAV's state is estimated."""

from __future__ import annotations

PATH_STEP_S = 0.05
"""s: Step of the paths that commands are judged by. Source: grid. Greater: faster, but a path may jump a
wire."""
BRAKE_S = 3.0
"""s: A path is judged for so long after the commit time, or until it stands. Source: chosen. Greater: slower,
and no difference for a UAV that stands earlier."""
HOLD_S = 0.6
"""s: The cost flies a command as it is for so long, then along the way out. Source: chosen. Greater: bolder
turns look worse."""
LONGEST_COST_S = 4.0
"""s: The cost looks no farther ahead, whatever `time_horizon` is. Source: grid. Greater: more time per
answer."""
MEETING_S = 3.0
"""s: The cost looks so far ahead while something moves. Source: chosen. Greater: it steps aside earlier."""
LONGEST_COMMIT_S = 0.5
"""s: An answer is flown no longer without another one. Source: chosen. Greater: it flies on blindly for
longer."""
COMMIT_PERIODS = 2.0
"""1: An answer is safe for so many periods of the scans at least. Source: chosen. Greater: more lost scans do
no harm, but gaps look narrower."""
SCAN_PERIOD_SHARE = 0.1
"""1: Share of a new period between scans in their mean. Source: chosen. Greater: the mean follows faster."""
CLEAR_STRIDE = 4
"""steps: The reference's own path is looked at in every fourth step. Source: grid. Greater: faster, but a
wider distance is kept."""
AT_REST_M_S = 0.05
"""m/s: A slower UAV stands. Source: chosen. Greater: paths end earlier."""
AT_REST_M_S2 = 0.2
"""m/s²: With less acceleration it stays at rest. Source: chosen. Greater: paths end earlier."""
FULL_ERROR_M_S = 2.0
"""m/s: From this speed on the response may have its whole `response_error`. Source: measured. Greater: slow
flight keeps less distance."""
LEAST_ERROR_SHARE = 0.33
"""1: Share of `response_error` at standstill. Source: measured. Greater: slow flight keeps more distance."""
CLIMB_LAG_S = 0.35
"""s: Lag of the vertical velocity behind its command. Source: measured. Greater: paths climb later."""
OBSERVER_STEP_S = 1e-3
"""s: Step in which the state is flown ahead. Source: grid. Greater: faster and coarser."""
LONGEST_OBSERVER_GAP_S = 1.0
"""s: After a longer gap acceleration and integral begin at zero. Source: chosen. Greater: older commands
count."""
KEPT_COMMANDS = 256
"""1: Commands that are kept until they have shown their effect. Source: grid. Greater: no difference."""
VELOCITY_NOISE_M_S = 0.01
"""m/s: Standard deviation of a measured velocity. Source: chosen. Greater: the estimate follows more
slowly."""
ACCELERATION_NOISE_M_S2 = 5.0
"""m/s²: Standard deviation that the acceleration gains in 1 s. Source: chosen. Greater: it follows faster."""
INTEGRAL_NOISE_M_S2 = 0.5
"""m/s²: The same of the integral. Source: chosen. Greater: it follows faster."""
