"""Why the flight controller brings the UAV down without an order: its mode, its words, its battery."""

from __future__ import annotations

import math

import pytest

from flights.flight.judging.own_descent import OwnDescent

SAID = "Dangerous battery level!, landing"


def descent(*calls):
    heard = OwnDescent()
    for name, *arguments in calls:
        getattr(heard, name)(*arguments)
    return heard.sentence


@pytest.mark.table("mode", ["AUTO.LAND", "AUTO.RTL", "LAND", "RTL"])
def test_it_is_told_with_what_the_flight_controller_said_and_its_charge(mode):
    sentence = (
        f'The UAV came down in {mode}, which this run had not ordered; the flight controller said "{SAID}"; '
    )
    text, told = ("on_text", 9.0, 0, SAID + " "), ("on_mode", 10.0, mode)
    charge = ("on_charge", 0.049)
    assert descent(text, charge, told) == descent(charge, told, text) == sentence + "its battery was at 5%."


def test_what_is_not_known_is_left_out():
    alone = "The UAV came down in RTL, which this run had not ordered."
    assert descent(("on_charge", math.nan), ("on_mode", 10.0, "RTL")) == alone
    assert descent(("on_text", 9.0, 6, "Landing detected"), ("on_mode", 10.0, "RTL")) == alone
    assert descent(("on_text", 4.9, 2, "Low battery"), ("on_mode", 10.0, "RTL")) == alone
    assert descent(("on_mode", 10.0, "RTL"), ("on_text", 15.1, 2, "Compass")) == alone


def test_a_uav_that_flies_does_not_come_down():
    assert descent(("on_text", 9.0, 0, SAID), ("on_mode", 10.0, "OFFBOARD")) == ""
    assert descent(("on_mode", 10.0, "AUTO.LAND"), ("on_mode", 11.0, "OFFBOARD")) == ""


def test_a_uav_that_mavros_publisher_lands_for_want_of_a_pose_says_so():
    blind = ("on_reason", "the flight controller gets no external pose")
    landed = ("on_mode", 10.0, "AUTO.LAND")
    afterwards = ("on_reason", "the UAV is not at its hover point yet")
    sentence = (
        "The UAV came down in AUTO.LAND, which this run had not ordered; "
        "before: the flight controller gets no external pose."
    )
    assert descent(blind, landed, afterwards) == sentence
    assert "before" not in descent(blind, ("on_reason", ""), landed)
