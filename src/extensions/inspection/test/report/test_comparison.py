"""Given two surveys, what is new, grown, gone or unseen follows from places, sizes and what was seen."""

from dataclasses import replace

from drawn_inspection import finding, side_walls

from inspection.report.comparison import Survey, compared


def test_new_grown_gone_and_unseen():
    rust, crack = finding(1, "rust", (0.5, 1.5, 1.2), 0.2, 0.02), finding(2, "crack", (-1.0, 1.5, 1.0), 0.3)
    gone, unseen = finding(3, "rust", (1.5, 1.5, 0.5), 0.1, 0.01), finding(4, "crack", (1.0, -1.5, 1.0), 0.3)
    ignored = replace(gone, id=5, position_m=(-1.5, 1.5, 1.5), status="dismissed")
    now = [
        replace(rust, id=11, area_m2=0.03),
        replace(crack, id=12, length_m=0.32),
        finding(13, "rust", (0.0, 1.5, 0.2), 0.1, 0.01),
        finding(14, "rust", (0.0, -1.5, 0.2), 0.1, 0.01),
    ]
    port = side_walls(lambda points: points[:, 1] > 0)
    found = compared(Survey([rust, crack, gone, unseen, ignored], port), Survey(now, port))
    assert found.change == {11: "grown", 12: "as before", 13: "new", 14: "not looked at before"}
    assert ([each.id for each in found.gone], [each.id for each in found.unseen]) == ([3], [4])
    assert found.last[12] == (crack,)
    unknown = compared(Survey([gone], None), Survey([], None))
    assert (unknown.gone, unknown.unseen) == ((), (gone,))


def test_what_has_grown_into_one_or_is_told_in_parts_is_not_gone_and_not_new():
    spots = [
        finding(k, "rust", (x, 1.5, 1.0), 0.1, 0.01, places_m=((x, 1.5, 1.0),))
        for k, x in ((1, 0.4), (2, 0.6))
    ]
    both_m = tuple(place for each in spots for place in each.places_m)
    one = finding(9, "rust", (0.5, 1.5, 1.0), 0.3, 0.04, places_m=both_m)
    port = side_walls(lambda points: points[:, 1] > 0)
    together = compared(Survey(spots, port), Survey([one], port))
    assert (together.change, together.gone, together.unseen) == ({9: "grown"}, (), ())
    assert set(together.last[9]) == set(spots)
    in_parts = compared(Survey([one], port), Survey(spots, port))
    assert (in_parts.change, in_parts.gone) == ({1: "as before", 2: "as before"}, ())


def test_rust_is_not_gone_where_the_coating_is_as_red():
    rust, crack = finding(1, "rust", (0.5, 1.5, 1.2), 0.2, 0.02), finding(2, "crack", (-1.0, 1.5, 1.0), 0.3)
    port = side_walls(lambda points: points[:, 1] > 0)
    found = compared(Survey([rust, crack], port), Survey([], port, ["rust"]))
    assert ([each.id for each in found.gone], [each.id for each in found.unseen]) == ([2], [1])
