"""The parameters of slam_octomap, and the map that its command line names, as octomap_server's does."""

import pytest
from gridslam_ros.volume.parameters import TEXTS, with_map_argument

from gridslam import ParameterError


def test_a_map_of_the_command_line_is_the_map_to_begin_with():
    assert with_map_argument(TEXTS, []) == TEXTS
    assert with_map_argument(TEXTS, ["hold.bt"]) == {**TEXTS, "map_file": "hold.bt"}
    same = {**TEXTS, "map_file": "hold.bt"}
    assert with_map_argument(same, ["hold.bt"]) == same


@pytest.mark.parametrize(
    ("map_file", "arguments", "saying"),
    [("", ["a.bt", "b.bt"], "one map file, not 2: a.bt, b.bt"), ("c.bt", ["a.bt"], "give one of them")],
)
def test_two_maps_are_refused(map_file, arguments, saying):
    with pytest.raises(ParameterError, match=saying):
        with_map_argument({**TEXTS, "map_file": map_file}, arguments)
