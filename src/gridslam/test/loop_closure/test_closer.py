"""The loop closer decides when a search begins, and gives each correction at a fixed stamp."""

import dataclasses
import math

import numpy as np
import pytest
from room_paths import snapshot_along

from gridslam.loop_closure.closer import LoopCloser
from gridslam.loop_closure.correction import Correction
from gridslam.loop_closure.path.step_uncertainty import DoubtfulNodes
from gridslam.loop_closure.stages import Stages
from gridslam.tracking.evidence import Agreement

WAY = np.column_stack([np.arange(0.0, 20.1, 0.25), np.zeros((81, 2))])


@pytest.mark.table(("agrees", "expected_m"), [(False, 0.5), (True, 8.0)])
def test_searches_are_rarer_while_places_are_found_where_the_path_has_them(monkeypatch, agrees, expected_m):
    # given a closer whose searches are noted, and find what agrees, or what does not
    closer, searched_m = LoopCloser(), []

    def stages(snapshot, doubtful):
        closer._stages.agreed = agrees
        searched_m.append(snapshot.odometry[-1, 0])

    monkeypatch.setattr(closer._stages, "on_the_way", stages)
    # when a scan after the other comes in
    for count in range(1, len(WAY) + 1):
        assert closer.take(math.inf) is None
        closer.add_node(float(count), WAY[count - 1])
        if closer.is_search_due:
            closer.search(snapshot_along(WAY[:count]))
    # then the ways between searches are as the parameters say
    np.testing.assert_allclose(np.diff(searched_m), expected_m)


def begun(monkeypatch, poses):
    """A closer that has begun a search at 2 s, which corrects the path to these poses."""
    closer = LoopCloser()
    monkeypatch.setattr(closer._stages, "on_the_way", lambda snapshot, doubtful: Correction(poses))
    for second, base in enumerate(WAY[:3]):
        closer.add_node(float(second), base)
    assert closer.is_search_due
    closer.search(snapshot_along(WAY[:3]))
    assert not closer.is_search_due
    return closer


def test_a_correction_is_given_once_at_the_stamp_when_it_is_due(monkeypatch):
    closer = begun(monkeypatch, WAY[:3])
    due_s = 2.0 + closer.parameters.answer_s
    assert closer.take(due_s - 0.01) is None
    assert closer.take(due_s).poses is not None
    assert closer.take(due_s) is None
    # and at once if the clock goes back
    assert begun(monkeypatch, WAY[:3]).take(1.0) is not None


@pytest.mark.table("draws_beside", [True, False])
def test_the_map_is_drawn_in_the_thread_or_by_the_filter(monkeypatch, draws_beside):
    closer, drawn = LoopCloser(), []
    closer.draws_beside = draws_beside
    correction = Correction(WAY[:3], draw=lambda: drawn.append("a map") or drawn[-1])
    monkeypatch.setattr(closer._stages, "on_the_way", lambda snapshot, doubtful: correction)
    closer.add_node(0.0, WAY[0])
    closer.search(snapshot_along(WAY[:3]))
    taken = closer.take(math.inf)
    assert (taken.draft, drawn) == (("a map", ["a map"]) if draws_beside else (None, []))
    assert taken.drawn().draft == "a map"
    assert len(drawn) == 1


def test_a_correction_is_dropped_when_the_vehicle_is_put_elsewhere(monkeypatch):
    closer = begun(monkeypatch, WAY[:3])
    closer.drop()
    assert closer.take(math.inf) is None
    assert closer.state().doubtful == DoubtfulNodes(unmatched=(3,))


def test_what_is_pending_is_decided_once_when_the_vehicle_has_been_at_rest(monkeypatch):
    closer = begun(monkeypatch, WAY[:3])
    closer.take(math.inf)
    monkeypatch.setattr(Stages, "is_pending", True)
    monkeypatch.setattr(closer._stages, "at_rest", lambda *given: Correction(WAY[:3]))
    rest_s = 2.0 + closer.parameters.rest_s
    assert [closer.is_decision_due(rest_s + off_s) for off_s in (-0.01, 0.0)] == [False, True]
    closer.decide(snapshot_along(WAY[:3]), rest_s)
    assert closer.take(rest_s) is None
    assert closer.take(rest_s + closer.parameters.answer_s) is not None
    assert not closer.is_decision_due(rest_s + 20.0)
    # and once more after the next node
    closer.add_node(30.0, WAY[4])
    assert closer.is_decision_due(50.0)


def test_an_empty_path_needs_no_correction():
    assert LoopCloser().finish(snapshot_along(np.zeros((0, 3)))) is None


def test_a_saved_state_that_points_at_other_scans_is_refused():
    closer = LoopCloser()
    for second, base in enumerate(WAY[:6]):
        closer.add_node(float(second), base, Agreement(90, 10, 0))
    state = closer.state()
    assert LoopCloser.from_state(state, WAY[:6]).state().way_m == pytest.approx(1.25)
    wrong = dataclasses.replace(state, doubtful=DoubtfulNodes(guessed=(99,)))
    with pytest.raises(ValueError, match="doubtful nodes"):
        LoopCloser.from_state(wrong, WAY[:6])
