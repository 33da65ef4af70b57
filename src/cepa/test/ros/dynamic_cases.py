"""What the node cepa adds for the algorithm dynamic: motion from odometry, and braking when no scan comes."""

from __future__ import annotations

import math

import numpy as np
from cepa_probe import BEAMS, column, odometry_of, of_stamp, scan_of, velocity_of

from cepa import CepaParameters, Dynamic, LaserScan2D, Motion
from node_tools.testing import Stamps

PERIOD_S = 0.025
COMMIT_S = 0.1


class DynamicCases:
    """Mixed into the node's test case, which has its inputs and outputs."""

    def fly(self, x, ranges=None, step_s=PERIOD_S, seen=None, odometry=True):
        """The command for one scan of a UAV at (x, 0) that flies 1 m/s along x; v_ref is 1.5 m/s."""
        stamp = self.stamps.next(step_s)
        if odometry:
            self.odometry.send(odometry_of(stamp, (1.0, 0.0, 0.0), x=x))
        intensities = [] if seen is None else np.where(seen, 0.0, -1.0)
        self.references.send(velocity_of(stamp, (1.5, 0.0, 0.2)))
        take = self.scans.send if odometry else self.scans.deliver
        take(scan_of(stamp, ranges, intensities=intensities))
        if not odometry:  # the scan waits for it until the next one comes
            self.scans.send(scan_of(self.stamps.next(1e-3), ranges, intensities=intensities))
        return of_stamp(self.commands, stamp).twist.linear

    def start_dynamic(self):
        self.client.update_configuration({"algorithm": "dynamic"})
        self.share_a_stamp()
        for algorithm in ("improved", "dynamic"):  # which then knows nothing of what was seen
            self.client.update_configuration({"algorithm": algorithm})

    def test_dynamic_answers_as_the_library_does_with_the_motion_of_odometry(self):
        self.start_dynamic()
        expected = Dynamic(CepaParameters())
        blind_ahead = np.abs(np.linspace(-180.0, 180.0, BEAMS, endpoint=False)) > 20.0
        geometry = np.float32(-math.pi), np.float32(2.0 * math.pi / BEAMS), 0.06, 10.0
        answers = []
        for step in range(4):
            x, ranges = 0.025 * step, column(0.0, 3.0 - 0.025 * step)
            seen = blind_ahead if step == 3 else None  # it remembers the column
            answers.append(self.fly(x, ranges, seen=seen))
            stamp_s = self.stamps.now_s
            motion = Motion.of_mounted(
                stamp_s, (x, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0), climb_ref_m_s=0.2
            )
            scan = LaserScan2D(np.float32(ranges), *geometry, seen)
            decision = expected.steer(scan, (1.5, 0.0), (1.0, 0.0), motion)
            np.testing.assert_allclose((answers[-1].x, answers[-1].y), decision.velocity_xy, atol=1e-5)
        assert {answer.z for answer in answers} == {0.2}

    def test_dynamic_forgets_what_it_saw_when_odometry_jumps(self):
        self.start_dynamic()
        for x in (0.0, 0.025, 5.0):
            self.fly(x)
        self.warned.wait_for("odometry jumped by 4.97 m and 0 degrees within 0.025 s")
        self.fly(5.025)
        assert self.warned.count("odometry jumped") == 1

    def test_dynamic_steers_by_the_scan_alone_without_odometry(self):
        self.start_dynamic()
        assert self.fly(0.0).x > 0.0
        assert self.fly(0.0, step_s=0.6, odometry=False).x > 0.0
        self.warned.wait_for("s older than the scan. Nothing is remembered")
        beside = np.abs(np.linspace(-180.0, 180.0, BEAMS, endpoint=False)) > 90.0
        assert self.fly(0.0, step_s=0.1, seen=beside, odometry=False).x <= 0.01  # unseen ahead

    def test_dynamic_brakes_when_no_scan_comes_and_goes_on_with_the_next(self):
        self.start_dynamic()
        assert self.fly(0.0).x > 0.0
        self.commands.messages.clear()
        for _ in range(4):  # up to the commit time a scan may still come
            self.odometry.send(odometry_of(self.stamps.next(), (1.0, 0.0, 0.0)))
        self.commands.assert_quiet()
        late = self.stamps.next(-0.01)  # of a scan that comes later than what follows
        stamp = self.stamps.next(0.035)
        self.odometry.send(odometry_of(stamp, (1.0, 0.0, 0.0)))
        command = self.commands.next()
        assert command.header.stamp == stamp
        linear = command.twist.linear
        assert (linear.x, linear.y, linear.z) == (0.0, 0.0, 0.0)
        self.warned.wait_for("No scan was answered for 0.125 s; braking until one comes.")
        # The answer to a late scan is not stamped before the braking, or the clock would seem to go back
        self.references.send(velocity_of(late, (1.5, 0.0, 0.0)))
        self.scans.send(scan_of(late))
        assert self.commands.next().header.stamp == stamp
        assert self.fly(0.0).x > 0.0

    def test_only_dynamic_brakes_by_itself(self):
        assert self.fly(0.0).x > 0.0
        self.commands.messages.clear()
        for _ in range(20):
            self.odometry.send(odometry_of(self.stamps.next(), (1.0, 0.0, 0.0)))
        self.commands.assert_quiet()

    def test_dynamic_survives_a_clock_that_jumps_back(self):
        self.start_dynamic()
        self.fly(0.0)
        self.stamps = Stamps(3.0)
        self.share_a_stamp()
        assert self.fly(0.0).x > 0.0
        self.warned.wait_for("clock jumped back")

    def test_dynamic_answers_the_same_with_a_lidar_that_is_upside_down(self):
        self.mounts.add("base_frame", "hanging_lidar", roll=math.pi)
        self.start_dynamic()
        expected = self.answer((1.5, 0.3, 0.0), column(10.0, 1.5))
        assert math.dist(expected[:2], (1.5, 0.3)) > 0.1  # it evades
        self.start_dynamic()
        answer = self.first_move("the mounting", (1.5, 0.3, 0.0), column(-10.0, 1.5), frame="hanging_lidar")
        np.testing.assert_allclose(answer, expected, atol=0.05)

    def test_a_response_that_makes_no_sense_is_refused(self):
        refused = self.client.update_configuration({"response_i": 90.0, "response_lag": 1.0})
        assert refused["response_lag"] == CepaParameters().response_lag
        self.warned.wait_for("The response model is unstable")

    def test_dynamic_says_why_it_answered(self):
        self.start_dynamic()
        self.stats.messages.clear()
        self.fly(0.0, column(0.0, 1.5))
        status = self.stats.next().status[0]
        values = {pair.key: pair.value for pair in status.values}
        nowhere = {"held_s", "returns"}
        reported = {"clearance_m", "admissible", "braking_margin_m", "remembered", "movers", *nowhere}
        assert reported <= set(values), values
        assert math.isclose(float(values["clearance_m"]), 1.5 - CepaParameters().body_radius, rel_tol=1e-3)
        assert 0 < int(values["admissible"]) <= int(values["directions_tested"])
