"""Given what was judged, the picture's caption tells the same."""

import numpy as np

from flights.inspecting.coverage import Judged
from flights.inspecting.pictures import caption
from inspection.camera.photograph_pose import PhotographPose


def test_the_caption_counts_all_photographs_whose_area_it_tells():
    taken = (PhotographPose(np.zeros(3), np.eye(3)),) * 11  # 10 of the plan, and a nearer one
    judged = Judged(0.5, 0.5, 0.5, 36.4, 100.0, (0.0, 0.0), (0.0, 0.0), taken, {})
    assert caption(judged, 90.0) == "11 photographs show 36 m²\nin 1.5 min of flight, without GNSS"
