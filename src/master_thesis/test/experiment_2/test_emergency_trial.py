"""The course of a run of Experiment 2, told by hand."""

import numpy as np
import pytest

from cepa import LaserScan2D
from flights.worlds.placements import placement
from master_thesis.experiment_2.trial import EmergencyTrial, TrialAction, TrialParameters
from simulation_tools.geometry import Pose

HOVER = Pose((0.0, 0.0, 2.0))
LIMITS = TrialParameters(ready_timeout_s=20.0, settle_s=2.0, observe_s=5.0)
SCAN = LaserScan2D(np.ones(4), 0.0, np.pi / 2, 0.06, 10.0)


@pytest.fixture
def trial():
    return EmergencyTrial(LIMITS, "iris")


def pass_time(trial, start_s, end_s, step_s=0.01):
    """Tell the truth at 100 Hz; return (time, action) of all that came back."""
    found = []
    for t_s in np.arange(start_s, end_s, step_s):
        found += [(round(float(t_s), 3), action) for action in trial.on_truth(float(t_s), HOVER)]
    return found


def released(trial):
    """A trial that was frozen at 5 s."""
    pass_time(trial, 0.0, 3.0)
    trial.on_ready(True)
    pass_time(trial, 3.0, 5.01)
    trial.on_placed(5.0, HOVER, placement("columns"))
    return trial


def test_time_is_stopped_once_when_the_uav_has_hovered_for_a_while(trial):
    assert pass_time(trial, 0.0, 3.0) == []
    trial.on_ready(True)
    ((t_s, action),) = pass_time(trial, 3.0, 8.0)
    assert action is TrialAction.FREEZE
    assert t_s == pytest.approx(3.0 + LIMITS.settle_s, abs=0.03)


def test_in_lockstep_it_decides_only_when_it_is_asked(trial):
    for t_s in (0.0, 1.0, 2.0):
        assert trial.on_truth(t_s, HOVER, decide=False) == []
    trial.on_ready(True)
    assert trial.decide() == []
    assert trial.on_truth(4.0, HOVER, decide=False) == []
    assert trial.decide() == [TrialAction.FREEZE]
    trial.on_placed(4.0, HOVER, placement("columns"))
    trial.on_scan(4.025, SCAN)
    assert trial.on_truth(9.0, HOVER, decide=False) == []
    assert not trial.finished
    assert trial.decide() == [TrialAction.FINISH]


def test_a_uav_that_is_ready_no_longer_must_hover_anew(trial):
    pass_time(trial, 0.0, 3.0)
    trial.on_ready(True)
    pass_time(trial, 3.0, 4.0)
    trial.on_ready(False)
    assert pass_time(trial, 4.0, 7.0) == []


def test_a_uav_that_never_hovers_fails_the_run(trial):
    ((t_s, action),) = pass_time(trial, 0.0, 30.0)
    assert action is TrialAction.FINISH
    assert t_s == pytest.approx(22.0, abs=0.05)
    assert trial.failure == "The UAV did not hover within 20 s."


def test_the_first_scan_after_the_freeze_is_kept_and_no_other(trial):
    released(trial)
    assert trial.on_scan(4.99, SCAN) == []
    assert trial.on_scan(5.0, SCAN) == []  # of the very instant: taken before anything was placed
    assert trial.on_scan(5.025, SCAN) == [TrialAction.SHOW]
    assert trial.on_scan(5.05, SCAN) == []
    assert trial.first_scan.t_s == 5.025


def test_it_ends_when_it_was_watched_long_enough(trial):
    released(trial)
    trial.on_scan(5.025, SCAN)
    ((t_s, action),) = pass_time(trial, 5.02, 15.0)
    assert action is TrialAction.FINISH
    assert t_s == pytest.approx(10.0, abs=0.02)
    assert trial.failure is None


def test_without_a_scan_the_run_fails(trial):
    released(trial)
    pass_time(trial, 5.02, 11.0)
    assert "No scan came" in trial.failure


def test_contacts_count_from_letting_go_to_the_end_each_obstacle_once(trial):
    trial.on_contact(0.0, "iris::base_link::leg", "ground_plane::link::floor")
    released(trial)
    trial.on_contact(6.0, "column_front_left::link::body", "iris::rotor_0::disc")
    trial.on_contact(6.1, "iris::rotor_0::disc", "column_front_left::link::body")
    trial.on_contact(7.0, "iris::rotor_1::disc", "ground_plane::link::floor")
    assert trial.touched == {"column_front_left::link::body": 6.0, "ground_plane::link::floor": 7.0}
    trial.abort("Enough.")
    trial.on_contact(8.0, "iris::rotor_1::disc", "column_rear_left::link::body")
    assert len(trial.touched) == 2


def test_a_clock_that_jumps_back_ends_the_run(trial):
    pass_time(trial, 0.0, 3.0)
    assert trial.on_truth(0.5, HOVER) == [TrialAction.FINISH]
    assert "jumped back" in trial.failure
