"""Numbers that are none, in every numeric field of every message that the flight controller handles.

In the air, with both estimators: nothing raises, every answer can be packed, and the state stays finite.
"""

from __future__ import annotations

import copy
import math
import struct

import numpy as np
import pytest
from flight import hovering
from hypothesis import given
from hypothesis import strategies as st
from mavlink_client import Setup
from pymavlink.dialects.v20 import common as mavlink
from test_without_gnss import taken_off

from simulation_tools.mavlink import Codec
from simulation_tools.px4.plan.items import FENCE_COMMANDS, MISSION_FRAME, Command, PlanError, PlanItem

FLOAT_MAX = 3.4e38
FLOATS = {"float": FLOAT_MAX, "double": 1e308}
INTEGERS = {f"{sign}int{bits}_t": (bits, sign == "") for bits in (8, 16, 32, 64) for sign in ("", "u")}
STEPS = 5  # of 4 ms, after each message


def of_type(kind):
    """Values of one field of a message, with those that are none, or too great for anything, in front."""
    if kind in FLOATS:
        most = FLOATS[kind]
        odd = (
            math.nan,
            math.inf,
            -math.inf,
            most,
            -most,
            -0.0,
            0.0,
            1.0,
            1e30,
            5e-324 if kind == "double" else 1e-45,
        )
        return st.one_of(st.sampled_from(odd), st.floats(width=32))
    bits, is_signed = INTEGERS[kind]
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if is_signed else (0, 2**bits - 1)
    return st.one_of(st.sampled_from((low, high, 0, 1)), st.integers(low, high))


MEANT = {"target_system": (1,), "target_component": (1,), "mission_type": (0, 1), "param_type": (6, 9)}
"""Values without which a message is not for this vehicle, or is refused before its numbers are read."""
COMMANDS = (
    *(
        16,
        19,
        20,
        21,
        22,
        31,
        84,
        92,
        93,
        112,
        115,
        176,
        177,
        178,
        179,
        185,
        192,
        195,
        201,
        206,
        300,
        400,
        410,
    ),
    *(*range(5000, 5005), 510, 511, 512, 520, 528, 530, 2000),
)
PARAMETERS = (b"MPC_XY_P", b"GF_ACTION", b"GF_MAX_HOR_DIST", b"MPC_YAW_MODE")
FRAMES = (0, 1, 2, 3, 5, 6, 8, 12, 20)


@st.composite
def messages(draw, names):
    """Draw a message of one of these types, with any numbers."""
    kind = {each.msgname: each for each in mavlink.mavlink_map.values()}[draw(st.sampled_from(names))]
    values = []
    lengths = dict(zip(kind.ordered_fieldnames, kind.array_lengths))
    for name, field in zip(kind.fieldnames, kind.fieldtypes):
        if field == "char":
            values.append(
                draw(st.sampled_from((b"MPC_XY_P", b"GF_ACTION", b"GF_MAX_HOR_DIST", b"MPC_YAW_MODE")))
            )
        elif name in MEANT:
            values.append(draw(st.sampled_from(MEANT[name])))
        elif name == "command":
            values.append(draw(st.sampled_from(COMMANDS)))
        elif name in ("frame", "coordinate_frame", "frame_id", "child_frame_id"):
            values.append(draw(st.sampled_from(FRAMES)))
        elif lengths[name]:
            values.append(draw(st.lists(of_type(field), min_size=lengths[name], max_size=lengths[name])))
        else:
            values.append(draw(of_type(field)))
    return kind(*values)


def in_air(flight):
    setup = Setup(flight)
    setup.client()
    setup.clients[0].heartbeat()
    setup.run(0.1)
    return setup


@pytest.fixture(scope="module", params=["by GNSS", "by vision"])
def flying(request):
    setup = in_air(hovering() if request.param == "by GNSS" else copy.deepcopy(taken_off()))
    yield setup
    setup.close()


@pytest.fixture
def flying_anew():
    setup = in_air(hovering())
    yield setup
    setup.close()


def check_state(setup):
    """Fly on, let every stream be packed once, and look at all of the state."""
    setup.run(0.004 * STEPS)
    setup.link.reset()
    setup.link.send_due(setup.flight.body.time_us)
    px4, body = setup.flight.px4, setup.flight.body
    assert np.isfinite(px4.commands).all()
    estimate = px4._estimator.estimate
    for name in estimate.dtype.names:
        assert np.isfinite(estimate[name]).all(), name
    assert all(map(math.isfinite, (*body.position, *body.velocity, *body.attitude)))


def handled():
    """All messages with a handler, by name."""
    setup = Setup()
    names = sorted(setup.link._handlers)
    setup.close()
    return names


@given(messages(handled()))
def test_any_number_in_any_field_of_any_handled_message_is_survived(flying, message):
    try:
        flying.clients[0].send(message)
    except (struct.error, OverflowError):
        return  # it cannot be sent
    check_state(flying)


@given(messages(["VISION_POSITION_ESTIMATE", "ODOMETRY", "DISTANCE_SENSOR"]), st.integers(0, 100_000))
def test_estimates_of_the_present_with_any_numbers_are_survived(flying, message, late_us):
    """The stamp decides whether the filter takes a sample in; here it always does."""
    now_us = flying.flight.body.time_us
    name = (
        "time_boot_ms"
        if hasattr(message, "time_boot_ms")
        else "usec"
        if hasattr(message, "usec")
        else "time_usec"
    )
    setattr(message, name, max(now_us - late_us, 0) // (1000 if name == "time_boot_ms" else 1))
    flying.clients[0].send(message)
    check_state(flying)


ITEM_COMMANDS = sorted({*map(int, Command), 183, 206, 2000})


@st.composite
def items(draw, commands):
    """Draw an item of a plan whose place can be near, so that it is flown."""
    fields = of_type("float")
    x = draw(
        st.one_of(st.sampled_from((473977420, 0, 2**31 - 1, -(2**31))), st.integers(-(2**31), 2**31 - 1))
    )
    y = draw(st.sampled_from((85455940, 85456940, 2**31 - 1)))
    return (
        draw(st.sampled_from((0, 2, 3, 5, 6))), draw(st.sampled_from(commands)), draw(st.integers(0, 1)),
        *(draw(fields) for _ in range(4)), x, y, draw(st.one_of(st.sampled_from((5.0, 10.0)), fields)),
    )  # fmt: skip


def upload(setup, kind, drawn, as_int):
    """Upload as a ground station does, and return the acknowledgement's result."""
    client = setup.clients[0]
    client.take("")
    client.send(mavlink.MAVLink_mission_count_message(1, 1, len(drawn), kind))
    for number, (frame, command, on, p1, p2, p3, p4, x, y, z) in enumerate(drawn):
        make = mavlink.MAVLink_mission_item_int_message if as_int else mavlink.MAVLink_mission_item_message
        place = (x, y) if as_int else (1e-7 * x, 1e-7 * y)
        client.send(make(1, 1, number, frame, command, 0, on, p1, p2, p3, p4, *place, z, kind))
        setup.run(0.004)
    setup.run(0.02)
    results = [ack.type for ack in client.take("MISSION_ACK")]
    client.send(mavlink.MAVLink_mission_ack_message(1, 1, mavlink.MAV_MISSION_OPERATION_CANCELLED, kind))
    setup.run(0.004)
    return results


def download(setup, kind, as_int):
    """Ask for each item, in both forms: all that is kept can be sent."""
    client = setup.clients[0]
    client.send(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    setup.run(0.008)
    counts = client.take("MISSION_COUNT")
    for number in range(counts[0].count if counts else 0):
        make = (
            mavlink.MAVLink_mission_request_int_message if as_int else mavlink.MAVLink_mission_request_message
        )
        client.send(make(1, 1, number, kind))
        setup.run(0.008)
    client.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, kind))
    setup.run(0.004)


@given(st.lists(items(ITEM_COMMANDS), min_size=1, max_size=4), st.booleans(), st.booleans())
def test_a_mission_with_any_numbers_is_refused_or_flown(flying, drawn, as_int, down_as_int):
    upload(flying, 0, drawn, as_int)
    download(flying, 0, down_as_int)
    flying.clients[0].command(176, 1, 4, 4)  # AUTO.MISSION
    check_state(flying)
    flying.clients[0].command(300, 0, 0)
    check_state(flying)


@given(
    st.lists(items(sorted(FENCE_COMMANDS)), min_size=1, max_size=4),
    st.sampled_from((1, 2, 3, 5)),
    st.booleans(),
)
def test_a_fence_with_any_numbers_is_refused_or_kept(flying, drawn, action, as_int):
    flying.flight.px4.parameters.set("GF_ACTION", action)
    upload(flying, 1, drawn, as_int)
    download(flying, 1, as_int)
    flying.run(0.25)  # it is looked at five times a second
    check_state(flying)


@pytest.mark.table("number", [math.inf, -math.inf, math.nan])
@pytest.mark.table("place", [0, 1])
def test_a_jump_to_nowhere_or_for_ever_is_refused_by_its_parameter(number, place):
    params = [0.0, 1.0, 0.0, 0.0]
    params[place] = number
    with pytest.raises(PlanError) as refused:
        PlanItem.accepted(Command.JUMP, MISSION_FRAME, params, (0.0, 0.0, 0.0), True, True)
    assert refused.value.result == mavlink.MAV_MISSION_INVALID_PARAM1 + place


def test_a_jump_with_infinities_does_not_end_the_flight(flying_anew):
    far = (2, int(Command.JUMP), 1, math.inf, math.inf, 0.0, 0.0, 0, 0, 0.0)
    place = (6, int(Command.WAYPOINT), 1, 0.0, 0.0, 0.0, math.nan, 473977420, 85455940, 5.0)
    assert upload(flying_anew, 0, [place, far], True) == [mavlink.MAV_MISSION_INVALID_PARAM1]
    assert upload(flying_anew, 0, [place, place], True) == [mavlink.MAV_MISSION_ACCEPTED]
    check_state(flying_anew)


@pytest.mark.parametrize("command", sorted(FENCE_COMMANDS))
@pytest.mark.parametrize("number", [math.inf, math.nan, -math.inf])
def test_a_fence_without_size_is_refused(flying_anew, command, number):
    area = (6, command, 1, number, 0.0, 0.0, 0.0, 473977420, 85455940, 0.0)
    needs_size = command != Command.FENCE_RETURN_POINT or math.isinf(number)
    results = upload(flying_anew, 1, [area], True)
    assert (results == [mavlink.MAV_MISSION_ACCEPTED]) is not needs_size
    check_state(flying_anew)


def test_a_number_beyond_float32_is_sent_as_infinite():
    ratios = mavlink.MAVLink_estimator_status_message(0, 0, 1e39, 0.5, -1e300, math.nan, 0.0, 0.0, 0.1, 0.2)
    (told,) = Codec(1, 1).decode(Codec(1, 1).pack(ratios))
    assert (told.vel_ratio, told.pos_horiz_ratio, told.pos_vert_ratio) == (math.inf, 0.5, -math.inf)
    assert math.isnan(told.mag_ratio)
    covariance = [0.0, 1e40, *[1.0] * 43]
    place = mavlink.MAVLink_local_position_ned_cov_message(0, 3, *[0.0] * 9, covariance)
    (told,) = Codec(1, 1).decode(Codec(1, 1).pack(place))
    assert list(told.covariance) == [0.0, math.inf, *[1.0] * 43]
