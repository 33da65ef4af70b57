"""Commands find their references whatever the order in which both arrive."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inspection_tools import ReferencePairing


def test_takes_the_newest_while_no_stamp_is_shared():
    pairing = ReferencePairing()
    assert pairing.offer_command(5, "a") == [("a", None)]
    pairing.offer_reference(1, "r1")
    pairing.offer_reference(3, "r3")
    assert pairing.offer_command(6, "b") == [("b", (3, "r3"))]


def test_takes_the_one_of_its_own_stamp_over_a_newer():
    pairing = ReferencePairing()
    for stamp in (1, 2, 3):
        pairing.offer_reference(stamp, f"r{stamp}")
    assert pairing.offer_command(2, "b") == [("b", (2, "r2"))]


def test_a_command_that_overtook_its_reference_waits_for_it():
    pairing = ReferencePairing()
    pairing.offer_reference(1, "r1")
    assert pairing.offer_command(1, "a") == [("a", (1, "r1"))]
    assert pairing.offer_command(2, "b") == []
    assert pairing.offer_reference(2, "r2") == [("b", (2, "r2"))]
    assert pairing.offer_reference(3, "r3") == []


def test_a_dead_source_holds_up_one_command_only_and_lets_none_fall():
    pairing = ReferencePairing()
    pairing.offer_reference(1, "r1")
    pairing.offer_command(1, "a")
    assert pairing.offer_command(2, "b") == []
    assert pairing.offer_command(3, "c") == [("b", (1, "r1")), ("c", (1, "r1"))]
    assert pairing.offer_command(4, "d") == [("d", (1, "r1"))]


def test_a_source_whose_clock_jumps_back_starts_anew():
    pairing = ReferencePairing()
    pairing.offer_reference(100, "old")
    pairing.offer_reference(2, "new")
    assert pairing.offer_command(100, "a") == [("a", (2, "new"))]  # not the one of the other time
    pairing.clear()
    assert pairing.offer_command(1, "b") == [("b", None)]


@settings(max_examples=100, deadline=None)
@given(order=st.lists(st.booleans(), min_size=1, max_size=40), ratio=st.integers(1, 4))
def test_outcome_does_not_depend_on_which_is_faster(order, ratio):
    """References at every tick, commands at every `ratio`-th; each race of a pair drawn as won or lost."""
    pairing = ReferencePairing()
    pairing.offer_reference(0, 0)
    answers = pairing.offer_command(0, 0)
    for index, command_first in enumerate(order, start=1):
        tick = index * ratio
        for between in range(tick - ratio + 1, tick):
            answers += pairing.offer_reference(between, between)
        if command_first:
            answers += pairing.offer_command(tick, tick)
            answers += pairing.offer_reference(tick, tick)
        else:
            answers += pairing.offer_reference(tick, tick)
            answers += pairing.offer_command(tick, tick)
    assert answers == [(t, (t, t)) for t in range(0, (len(order) + 1) * ratio, ratio)]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.integers(0, 1)), max_size=60))
def test_every_command_but_the_last_is_answered_once_and_in_order(events):
    """Whatever commands and references come: `(is a command, how far its stamp goes on)`."""
    pairing, stamps, commands, answered = ReferencePairing(), [0, 0], [], []
    for is_command, step in events:
        stamps[is_command] += step
        if is_command:
            commands.append(len(commands))
            answered += pairing.offer_command(stamps[1], commands[-1])
        else:
            answered += pairing.offer_reference(stamps[0], None)
    assert [command for command, _ in answered] in (commands, commands[:-1])


@pytest.mark.parametrize("count", [1000])
def test_memory_is_bounded(count):
    pairing = ReferencePairing()
    for stamp in range(count):
        pairing.offer_reference(stamp, stamp)
    assert pairing.offer_command(0, "old") == [("old", (count - 1, count - 1))]
