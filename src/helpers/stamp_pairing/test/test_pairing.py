"""Which reference and which odometry belong to a scan."""

from hypothesis import given
from hypothesis import strategies as st

from stamp_pairing.pairing import StampPairing

MS = 1_000_000


def pairing():
    return StampPairing(("reference", "odometry"))


def values(ready):
    return [
        (pair.leader.value, *(found.value if found else None for found in pair.values.values()))
        for pair in ready
    ]


def test_without_sources_a_scan_is_answered_at_once():
    assert values(pairing().lead(0, "scan")) == [("scan", None, None)]


def test_a_scan_waits_for_the_messages_of_its_own_instant_in_any_order():
    p = pairing()
    p.offer("reference", 0, "r0")
    p.offer("odometry", 0, "o0")
    assert p.lead(25 * MS, "scan") == []
    assert p.offer("odometry", 25 * MS, "o25") == []
    assert values(p.offer("reference", 25 * MS, "r25")) == [("scan", "r25", "o25")]


def test_a_scan_that_comes_last_is_answered_at_once():
    p = pairing()
    p.offer("odometry", 25 * MS, "o25")
    p.offer("reference", 25 * MS, "r25")
    assert values(p.lead(25 * MS, "scan")) == [("scan", "r25", "o25")]


def test_messages_of_other_instants_do_not_displace_that_of_the_scan():
    p = pairing()
    for stamp in (20, 25, 30):
        p.offer("reference", stamp * MS, f"r{stamp}")
    assert values(p.lead(25 * MS, "scan")) == [("scan", "r25", None)]


def test_a_source_that_does_not_share_stamps_is_not_waited_for_twice():
    p = pairing()
    p.offer("reference", 10 * MS, "r10")
    assert p.lead(25 * MS, "scan 1") == []
    assert values(p.lead(50 * MS, "scan 2")) == [("scan 1", "r10", None), ("scan 2", "r10", None)]
    assert values(p.lead(75 * MS, "scan 3")) == [("scan 3", "r10", None)]


def test_without_trust_no_scan_waits_for_a_source_that_has_shared_no_stamp():
    p = StampPairing(("reference",), trusting=False)
    p.offer("reference", 10 * MS, "r10")
    assert values(p.lead(25 * MS, "scan 1")) == [("scan 1", "r10")]
    p.offer("reference", 50 * MS, "r50")
    assert values(p.lead(50 * MS, "scan 2")) == [("scan 2", "r50")]
    assert p.lead(75 * MS, "scan 3") == []


def test_a_newer_message_tells_that_none_of_the_scans_stamp_will_come():
    p = pairing()
    p.offer("reference", 10 * MS, "r10")
    assert p.lead(25 * MS, "scan") == []
    assert values(p.offer("reference", 30 * MS, "r30")) == [("scan", "r30", None)]


def test_a_source_is_waited_for_again_after_it_shared_a_stamp():
    p = pairing()
    p.offer("reference", 10 * MS, "r10")
    p.lead(25 * MS, "scan 1")
    p.lead(50 * MS, "scan 2")  # not waited for any more
    p.offer("reference", 50 * MS, "late, but of scan 2's stamp")
    assert p.lead(75 * MS, "scan 3") == []
    assert values(p.offer("reference", 75 * MS, "r75")) == [("scan 3", "r75", None)]


def test_a_stamp_is_shared_whichever_message_comes_first():
    p = pairing()
    p.offer("reference", 10 * MS, "r10")
    p.lead(25 * MS, "scan 1")
    p.lead(50 * MS, "scan 2")  # not waited for any more
    p.offer("reference", 75 * MS, "r75")
    assert values(p.lead(75 * MS, "scan 3")) == [("scan 3", "r75", None)]
    assert p.lead(100 * MS, "scan 4") == []


def test_a_source_with_a_rate_of_its_own_is_waited_for_once_it_has_shown_it():
    """In lockstep the simulator stands still until the scan is answered, so waiting in vain takes long."""
    p = StampPairing(("camera",), own_rate=("camera",))
    p.lead(0, "sent twice")
    for number in range(15):
        camera_is_due = number in (0, 4, 8, 12)
        waits = p.lead(number * 25 * MS, number) == []
        assert waits == (camera_is_due and number >= 8)
        if camera_is_due:
            p.offer("camera", number * 25 * MS, f"c{number}")
            assert not p.held


def test_the_same_scan_again_is_answered_again():
    p = pairing()
    assert values(p.lead(0, "scan")) == [("scan", None, None)]
    p.offer("reference", 0, "r0")
    assert values(p.lead(0, "scan")) == [("scan", "r0", None)]


def test_for_some_sources_the_nearest_in_time_belongs_to_a_scan_not_the_newest():
    p = StampPairing(("reference", "odometry"), nearest=("odometry",))
    for source in ("reference", "odometry"):
        for at_ms in (0, 10, 20, 30):
            p.offer(source, at_ms * MS, f"{source} {at_ms}")
    assert values(p.lead(12 * MS, "scan")) == [("scan", "reference 30", "odometry 10")]


def test_old_values_are_not_fresh():
    p = pairing()
    p.offer("reference", 0, "r0")
    p.lead(25 * MS, "scan 1")
    (first, second) = p.lead(501 * MS, "scan 2")
    assert first.fresh("reference", 500 * MS, "none") == "r0"
    assert second.fresh("reference", 500 * MS, "none") == "none"
    assert second.fresh("odometry", 500 * MS, "none") == "none"


def test_a_source_whose_clock_jumps_back_starts_anew():
    p = pairing()
    p.offer("reference", 900 * MS, "old")
    p.offer("reference", 25 * MS, "new")
    assert values(p.lead(25 * MS, "scan")) == [("scan", "new", None)]


def test_clear_forgets_everything():
    p = pairing()
    p.offer("reference", 0, "r0")
    p.lead(25 * MS, "held")
    p.clear()
    assert p.offer("reference", 25 * MS, "r25") == []
    assert values(p.lead(25 * MS, "scan")) == [("scan", "r25", None)]


def test_what_came_with_the_new_clock_before_the_scan_outlives_the_scans_jump_back():
    p = pairing()
    p.offer("reference", 900 * MS, "old reference")
    p.offer("odometry", 900 * MS, "old odometry")
    assert values(p.lead(900 * MS, "old scan")) == [("old scan", "old reference", "old odometry")]
    p.offer("reference", 25 * MS, "r25")
    p.restart()
    assert values(p.lead(25 * MS, "scan")) == [("scan", "r25", None)]


def test_a_source_that_jumped_back_long_before_the_scans_is_on_another_clock():
    p = pairing()
    p.offer("reference", 900 * MS, "r900")
    p.offer("reference", 500 * MS, "went back alone")
    p.lead(900 * MS, "scan 1")
    p.lead(925 * MS, "scan 2")
    p.restart()
    assert values(p.lead(25 * MS, "scan 3")) == [("scan 3", None, None)]


def test_a_replayed_bag_may_begin_with_a_scan():
    # nobody knows a source before it has said something: such a scan goes without, the second waits
    p = pairing()
    assert values(p.lead(0, "scan 1")) == [("scan 1", None, None)]
    p.offer("reference", 0, "r0")
    p.offer("odometry", 0, "o0")
    assert p.lead(25 * MS, "scan 2") == []
    p.offer("odometry", 25 * MS, "o25")
    assert values(p.offer("reference", 25 * MS, "r25")) == [("scan 2", "r25", "o25")]


events = st.lists(
    st.tuples(st.sampled_from(["scan", "reference", "odometry"]), st.integers(0, 8)), min_size=1, max_size=60
)


@given(events)
def test_whatever_comes_in_whatever_order_each_scan_is_answered_once_and_none_waits_for_ever(stream):
    p, offered, answered = pairing(), [], []
    for kind, ticks in stream:
        if kind == "scan":
            offered.append(len(offered))
            answered += p.lead(ticks * 25 * MS, offered[-1])
            assert len(answered) >= len(offered) - 1  # none outlasts the next scan
        else:
            answered += p.offer(kind, ticks * 25 * MS, ticks)
        assert [pair.leader.value for pair in answered] == offered[: len(answered)]


@given(st.randoms(use_true_random=False), st.integers(2, 12))
def test_sources_that_share_stamps_are_never_missed_however_the_messages_race(random, instants):
    p, answered = pairing(), []
    for source in ("reference", "odometry"):
        p.offer(source, 0, 0)
    for tick in range(1, instants):
        messages = ["scan", "reference", "odometry"]
        random.shuffle(messages)
        for kind in messages:
            stamp = tick * 25 * MS
            answered += p.lead(stamp, tick) if kind == "scan" else p.offer(kind, stamp, tick)
    assert values(answered) == [(tick, tick, tick) for tick in range(1, instants)]


def fly_with_clouds(p, instants):
    """Scans at 40 Hz, clouds at 10 Hz which come after their scan until they fail; which scans waited."""
    waited = []
    p.offer("cloud", -25 * MS, "before the scans")
    for tick in range(instants):
        waited.append(tick not in [pair.leader.value for pair in p.lead(tick * 25 * MS, tick)])
        if tick % 4 == 0 and tick < 24:
            for pair in p.offer("cloud", tick * 25 * MS, f"cloud {tick}"):
                assert values([pair]) == [(tick, f"cloud {tick}")]
    return waited


def test_only_those_scans_wait_for_a_slow_source_that_share_its_stamps():
    waited = fly_with_clouds(StampPairing(("cloud",), nearest=("cloud",)), 24)
    assert waited[8:] == [tick % 4 == 0 for tick in range(8, 24)]


def test_a_slow_source_that_fails_holds_up_one_scan():
    waited = fly_with_clouds(StampPairing(("cloud",), nearest=("cloud",)), 40)
    assert waited[21:] == [tick == 24 for tick in range(21, 40)]


# -- recordings: nothing is lacking, nothing is urgent ----------------------------------------------------


@given(st.data())
def test_a_patient_pairing_answers_alike_in_whatever_order_the_connections_are_read(data):
    """Each topic in its own order, but one topic may be read seconds ahead of another."""
    scans = [(25 * k * MS, "scan") for k in range(12)]
    references = [(stamp, "reference") for stamp in range(-10 * MS, 310 * MS, 5 * MS)]
    odometry = [(stamp, "odometry") for stamp in range(-3 * MS, 310 * MS, 10 * MS)]  # of no scan's stamp
    left, answers = [list(topic) for topic in (scans, references, odometry)], []
    p = StampPairing(("reference", "odometry"), ("odometry",), patient=True)
    while any(left):
        topic = data.draw(st.sampled_from([topic for topic in left if topic]))
        for stamp, name in topic[: data.draw(st.integers(1, 80))]:
            topic.pop(0)
            answers += p.lead(stamp, stamp) if name == "scan" else p.offer(name, stamp, stamp)
    assert [found.leader.value for found in answers] == [stamp for stamp, _ in scans]
    assert [found.values["reference"].value for found in answers] == [stamp for stamp, _ in scans]
    assert p.held == 0


def test_a_patient_pairing_takes_what_was_there_at_the_scan_and_says_what_it_waits_for():
    p = StampPairing(("reference",), patient=True)
    assert p.lead(25 * MS, "scan 1") == []
    assert p.lead(50 * MS, "scan 2") == []
    assert p.offer("reference", 20 * MS, "r20") == []
    assert (p.held, p.due) == (2, ("reference",))
    assert values(p.offer("reference", 40 * MS, "r40")) == [("scan 1", "r20")]
    assert values(p.offer("reference", 60 * MS, "r60")) == [("scan 2", "r40")]
    assert (p.held, p.due) == (0, ())


def test_a_patient_pairing_is_bounded():
    p = StampPairing(("reference",), patient=True)
    answers = [answer for k in range(2500) for answer in p.lead(k, k)]
    assert [found.leader.value for found in answers] == list(range(500))


def test_no_leader_waits_for_a_source_to_which_nobody_listens():
    p = StampPairing(("reference", "cloud"), patient=True)
    p.offer("cloud", 0, "c0")
    p.offer("reference", 25 * MS, "r25")
    assert p.lead(25 * MS, "scan 1") == []  # it waits for a cloud
    p.wait_for("cloud", False)
    assert len(p.offer("reference", 50 * MS, "r50")) == 1
    assert len(p.lead(50 * MS, "scan 2")) == 1
    p.wait_for("cloud", True)
    assert p.lead(75 * MS, "scan 3") == []
