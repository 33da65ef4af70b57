"""A pause of an exploration holds until somebody ends it, or until the energy begins to say: come home."""

import numpy as np
import pytest
from voxel_room import open_box

from exploration.energy import EnergyParameters, EnergyWatch
from exploration.next_view import End, Exploration, ExplorationParameters, Explorer

HOVER_M, FAR_M = np.array((1.0, 2.0, 3.0)), np.array((3.0, 2.0, 3.0))


def begun(energy=None, **parameters):
    exploration = Exploration(
        open_box(), Explorer(), ExplorationParameters(first_sink=0.0, **parameters), energy
    )
    exploration.begin(0.0, HOVER_M)
    exploration.follow(0.5, FAR_M)
    return exploration


def hovers(exploration, seconds=60):
    """Look for a while; return whether the only setpoint is the place of the pause."""
    for stamp_s in range(2, seconds):
        exploration.follow(float(stamp_s), FAR_M)
        exploration.look(float(stamp_s), FAR_M)
        if not np.allclose(exploration.setpoint_m, FAR_M) or exploration.is_home:
            return False
    return exploration.is_paused and not exploration.must_land


def pausing(exploration, work):
    """Let somebody pause while work is done, in its middle."""

    def work_and_pause(*arguments):
        exploration.pause(FAR_M)
        return work(*arguments)

    return work_and_pause


def test_a_pause_while_the_way_home_is_planned_holds():
    exploration = begun()
    exploration._end(End.TIME, "enough")
    plan = exploration._planner.plan
    exploration._planner.plan = pausing(exploration, plan)
    exploration.look(1.0, FAR_M)
    exploration._planner.plan = plan
    assert hovers(exploration)


def test_a_pause_while_the_last_view_is_decided_holds():
    # Given a space with nothing more to see, which is noticed in the moment of the pause
    exploration = begun()
    exploration.explored.views = 1
    exploration._guide.hover(FAR_M)
    exploration.follow(0.9, FAR_M)
    exploration._explorer.decide = pausing(exploration, exploration._explorer.decide)
    exploration.look(1.0, FAR_M)
    assert exploration.is_paused
    exploration._end(End.EXPLORED, "nothing more")
    assert hovers(exploration)
    # When it goes on, then it comes home
    exploration.resume()
    exploration.look(61.0, FAR_M)
    assert exploration.explored.end is not None
    assert not np.allclose(exploration.setpoint_m, FAR_M)


def test_an_abort_ends_a_pause_on_the_way_home():
    exploration = begun()
    exploration._end(End.TIME, "enough")
    exploration.pause(FAR_M)
    exploration.abort("enough")
    assert not exploration.is_paused


@pytest.mark.table("has_ended", [False, True])
def test_a_pause_ends_when_the_energy_begins_to_say_come_home(has_ended):
    watch = EnergyWatch(EnergyParameters(reserve=0.5))
    exploration = begun(watch)
    watch.offer(0.0, 0.9)
    exploration.look(0.9, FAR_M)
    if has_ended:
        exploration._end(End.TIME, "enough")
    exploration.pause(FAR_M)
    watch.offer(1.0, 0.9)
    exploration.look(1.0, FAR_M)
    assert exploration.is_paused
    for stamp_s in range(2, 400):
        watch.offer(float(stamp_s), 0.9 - 0.001 * stamp_s)
        exploration.look(float(stamp_s), FAR_M)
        if not exploration.is_paused:
            break
    assert not exploration.is_paused
    assert exploration.explored.end is (End.TIME if has_ended else End.BATTERY)
    # A pause after that holds
    exploration.pause(FAR_M)
    exploration.look(stamp_s + 1.0, FAR_M)
    assert exploration.is_paused


def test_a_uav_that_is_a_kilometre_off_the_map_does_not_end_in_an_error():
    exploration = begun()
    for stamp_s in (1.0, 2.0, 3.0):
        exploration.follow(stamp_s, np.add(FAR_M, (1000.0, 0.0, 0.0)))
        exploration.look(stamp_s, np.add(FAR_M, (1000.0, 0.0, 0.0)))
