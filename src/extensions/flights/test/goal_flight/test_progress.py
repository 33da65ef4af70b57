"""A flight that comes no nearer to its goal says so, in time and not too often."""

from __future__ import annotations

from flights.goal_flight.progress import LEAST_M, PATIENCE_S, ProgressWatch


def said_at(positions, goal=(40.0, 0.0, 2.0), step_s=0.1):
    """Return (time, sentence) of all that is said on a way of positions, one each tenth of a second."""
    watch = ProgressWatch(goal)
    sentences = (
        (step_s * number, watch.update(step_s * number, one)[1]) for number, one in enumerate(positions)
    )
    return [(t_s, sentence) for t_s, sentence in sentences if sentence]


def test_a_flight_that_gets_on_however_slowly_is_not_spoken_of():
    slow_m_s = 1.2 * LEAST_M / PATIENCE_S
    assert said_at([(0.1 * n * slow_m_s, 0.0, 2.0) for n in range(1000)]) == []


def test_a_flight_that_is_stuck_is_told_of_with_its_distance_and_again():
    said = said_at([(10.0, 0.0, 2.0)] * 400)
    assert [round(t_s, 1) for t_s, _ in said] == [PATIENCE_S, 2 * PATIENCE_S]
    assert said[0][1].startswith("The UAV is 30.0 m from the goal, and has come no nearer for 15 s.")
    assert "has come no nearer for 30 s." in said[1][1]


def test_a_flight_that_is_stuck_is_told_what_looks_farther_than_cepa():
    (_, said), *_ = said_at([(10.0, 0.0, 2.0)] * 200)
    assert "planner:=true" in said


def test_to_and_fro_is_no_progress():
    assert said_at([(10.0 + 0.4 * (n % 2), 0.0, 2.0) for n in range(200)])


def test_who_gets_on_again_is_given_time_again():
    stuck = [(10.0, 0.0, 2.0)] * 140
    assert said_at([*stuck, *([(11.0, 0.0, 2.0)] * 140)]) == []
