"""Given two surveys, what is new, grown, gone or unseen follows from places, sizes and what was seen."""

from dataclasses import replace

from drawn_inspection import finding, side_walls

from inspection.report.comparison import compared


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
    found = compared([rust, crack, gone, unseen, ignored], now, port, port)
    assert found.change == {11: "grown", 12: "as before", 13: "new", 14: "not looked at before"}
    assert ([each.id for each in found.gone], [each.id for each in found.unseen]) == ([3], [4])
    assert found.last[12] == crack
    unknown = compared([gone], [], None, None)
    assert (unknown.gone, unknown.unseen) == ((), (gone,))
