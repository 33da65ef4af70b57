"""When a lidar nods: only where the UAV has come to rest at a goal, once at each."""

from __future__ import annotations

from simulation_tools.running.nod_while_hovering import NodTiming, NodWhileHovering, Order

TICK_S = 1 / 128


def orders(told):
    """The orders with their times, for (until s, speed m/s, is at goal) one after the other, tick by tick."""
    decide, found, tick = NodWhileHovering(NodTiming(2.0, 0.25)), [], 0
    for until_s, speed_m_s, is_at_goal in told:
        while tick * TICK_S < until_s:
            order = decide.update(tick * TICK_S, speed_m_s, is_at_goal)
            if order is not None:
                found.append((tick * TICK_S, order))
            tick += 1
    return found


def test_it_nods_once_at_each_goal_after_coming_to_rest():
    flight = [(1.0, 1.0, False), (2.0, 0.2, True), (6.0, 0.02, True), (7.0, 0.5, False), (12.0, 0.0, True)]
    assert orders(flight) == [
        (2.25, Order.NOD),
        (4.25, Order.LEVEL),
        (7.25, Order.NOD),
        (9.25, Order.LEVEL),
    ]


def test_a_uav_that_is_sent_on_levels_its_lidar_at_once():
    assert orders([(1.0, 0.0, True), (3.0, 0.0, False)]) == [(0.25, Order.NOD), (1.0, Order.LEVEL)]


def test_a_uav_that_is_pushed_levels_its_lidar_and_nods_anew_at_rest():
    flight = [(1.0, 0.0, True), (1.5, 0.4, True), (4.0, 0.0, True)]
    assert orders(flight) == [
        (0.25, Order.NOD),
        (1.0, Order.LEVEL),
        (1.75, Order.NOD),
        (3.75, Order.LEVEL),
    ]


def test_it_never_nods_while_the_uav_flies():
    assert orders([(5.0, 1.0, False), (9.0, 0.2, True), (12.0, float("nan"), True)]) == []
