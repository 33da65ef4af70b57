"""What the chain tells the algorithm, and what it makes of its answer."""

import numpy as np
import pytest

from cepa import ALGORITHMS, CepaParameters, Reason
from cepa.decision import Decision
from flights.flight.steering_chain import SteeringChain
from inspection_tools import MedianFilterParameters, PaddingParameters, YawRegulatorParameters
from simulation_tools.simulation import Simulation, SimulationParameters


class Climbs:
    """Flies ahead at 1 m/s and climbs as it was told; None: it leaves the climb to the reference."""

    wants_motion, wants_cloud, wants_single_beams = True, False, False
    parameters, commit_s = CepaParameters(), 0.1

    def __init__(self, climb_m_s):
        self.climb_m_s = climb_m_s

    def take_ranges(self, rangings):
        self.rangings = rangings

    def on_next_scan(self, gap_s, turn_rad):
        pass

    def steer(self, scan, v_ref_xy, v_uav_xy, motion, cloud):
        self.motion = motion
        return Decision((1.0, 0.0), False, 0.0, 1, Reason.STEERED, climb_m_s=self.climb_m_s)


@pytest.mark.table(("answered", "flown"), [(0.7, 0.7), (None, 0.3)])
def test_climbs_are_told_and_flown_and_ranges_are_in_the_lidars_frame(worlds_folder, answered, flown):
    finders = ("range_finder", "range_finder_up")
    simulation = Simulation(SimulationParameters(str(worlds_folder / "empty.world"), sensors=finders))
    lidar, algorithm = simulation.lidar, Climbs(answered)
    parts = MedianFilterParameters(), PaddingParameters(), YawRegulatorParameters()
    output = simulation.sense()
    chain = SteeringChain(lidar, simulation.payload, algorithm, *parts, uses_range_finders=True)
    chain.on_odometry(0, output.odometry)
    chain.on_reference(0, (2.0, 0.0, 0.3))
    assert not chain.on_payload(0, output.payload)
    (command,) = chain.on_scan(0, output.scan)
    simulation.close()
    assert command.velocity_m_s == (1.0, 0.0, flown)
    assert algorithm.motion.climb_ref_m_s == 0.3
    down, up = sorted(algorithm.rangings, key=lambda ranging: ranging.direction[2])
    assert (down.direction, up.direction) == (pytest.approx((0, 0, -1)), pytest.approx((0, 0, 1)))
    # By models/range_finder it hangs 0.055 m below the body's middle
    assert down.origin_m[2] == pytest.approx(-0.055 - lidar.pose_in_body.position_m[2])
    assert 0.0 < down.range_min_m < 1.0 < down.range_max_m


@pytest.mark.table(("algorithm", "is_told"), [("dynamic", True), ("improved", False), ("original", False)])
def test_only_dynamic_is_told_of_single_beams(worlds_folder, algorithm, is_told):
    """A wire that one beam meets. The median of three beams hides it from the algorithms of the thesis."""
    simulation = Simulation(SimulationParameters(str(worlds_folder / "empty.world")))
    parts = MedianFilterParameters(), PaddingParameters(), YawRegulatorParameters()
    chain = SteeringChain(simulation.lidar, (), ALGORITHMS[algorithm](), *parts, uses_range_finders=False)
    ranges = np.full(simulation.lidar.beams, np.inf, np.float32)
    ranges[500] = 1.5
    chain.on_scan(0, ranges)
    simulation.close()
    assert np.isfinite(chain.newest_scan.ranges).sum() == (1 if is_told else 0)
