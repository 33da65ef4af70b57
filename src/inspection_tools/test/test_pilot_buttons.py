"""A button gives its order once, when it is pressed."""

import pytest

from inspection_tools.pilot_buttons import ButtonParameters, Order, PilotButtons


def orders(*states, parameters=None):
    buttons = PilotButtons(parameters)
    return [buttons.press(state) for state in states]


def test_an_order_is_given_once_while_a_button_is_held():
    up, pause = (0, 0, 0, 0), (1, 0, 0, 0)
    assert orders(up, pause, pause, up, pause) == [None, Order.PAUSE, None, None, Order.PAUSE]


@pytest.mark.table(
    ("pressed", "order"),
    [((0, 0, 1, 0), Order.LAND), ((0, 1, 0, 0), Order.HOME), ((0, 0, 0, 1), Order.RESUME)],
)
def test_each_has_a_button_and_landing_comes_first(pressed, order):
    assert orders((0, 0, 0, 0), pressed)[-1] is order
    assert orders((0, 0, 0, 0), (1, 1, 1, 1))[-1] is Order.LAND


def test_what_is_held_from_the_beginning_or_does_not_exist_gives_no_order():
    assert orders((0, 0, 1, 0), (0, 0, 1, 0)) == [None, None]
    assert orders((0,), (1,), parameters=ButtonParameters(button_pause=7)) == [None, None]


def test_two_orders_may_have_no_button():
    ButtonParameters(button_home=-1, button_land=-1)
