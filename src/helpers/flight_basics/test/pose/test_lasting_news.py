"""What changes to and fro is told once, and again where it lasts."""

from flight_basics.pose.lasting_news import LastingNews


def told(states, period_s=0.05):
    """The states that are told, with their times in s. states: (name, how often it comes)."""
    news, found, step = LastingNews(quiet_s=10.0, lasts_s=2.0), [], 0
    for state, count in states:
        for _ in range(count):
            if news.is_due(state, period_s * step):
                found.append((state, round(period_s * step, 2)))
            step += 1
    return found


def test_a_first_state_and_one_after_a_long_quiet_time_are_told_at_once():
    assert told([("good", 400), ("stale", 2)]) == [("good", 0.0), ("stale", 20.0)]


def test_a_state_that_comes_and_goes_is_told_once_and_when_it_lasts():
    """Nineteen times stale for 0.3 s and good for 0.7 s: it was told 38 times."""
    flicker = [("stale", 6), ("good", 14)] * 19
    assert told([("good", 400), *flicker]) == [("good", 0.0), ("stale", 20.0)]
    assert told([("good", 400), *flicker, ("good", 100)])[2:] == [("good", 40.3)]  # good since 38.3 s


def test_another_state_is_told_at_once():
    assert told([("good", 1), ("stale", 1), ("good", 1), ("jumped", 1)]) == [
        ("good", 0.0),
        ("stale", 0.05),
        ("jumped", 0.15),
    ]


def test_a_clock_that_goes_back_is_quiet():
    news = LastingNews(10.0, 2.0)
    assert [news.is_due("good", 100.0), news.is_due("stale", 5.0)] == [True, True]
