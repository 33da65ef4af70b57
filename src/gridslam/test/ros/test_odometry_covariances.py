"""A scan gets the covariance of the odometry with its stamp, whichever of them comes first."""

from __future__ import annotations

import numpy as np
import rospy
from gridslam_ros.beside.covariances import KEPT, OdometryCovariances
from nav_msgs.msg import Odometry

S = 1_000_000_000


def odometry(stamp_s, diagonal=(1.0, 2.0, 9.0, 9.0, 9.0, 3.0)):
    message = Odometry()
    message.header.stamp = rospy.Time(stamp_s)
    message.pose.covariance = np.diag(diagonal).ravel().tolist()
    return message


def test_a_scan_waits_for_its_covariance_but_not_for_ever():
    covariances = OdometryCovariances(print)
    assert not covariances.know(rospy.Time(5), None)
    assert not covariances.know(rospy.Time(5), 5 * S)
    assert covariances.know(rospy.Time(5), 7 * S)
    covariances.add(odometry(5))
    assert covariances.know(rospy.Time(5), 5 * S)
    assert covariances.at(rospy.Time(5)).tolist() == np.diag((1.0, 2.0, 3.0)).tolist()
    assert covariances.at(rospy.Time(4)) is None
    for stamp_s in range(6, 6 + KEPT):
        covariances.add(odometry(stamp_s))
    assert covariances.at(rospy.Time(5)) is None
    covariances.add(odometry(1))  # the clock went back
    assert not covariances.know(rospy.Time(2), 1 * S)


def test_odometry_without_a_covariance_gets_one_sentence():
    said = []
    covariances = OdometryCovariances(said.append)
    covariances.add(odometry(1, 6 * [0.0]))
    covariances.add(odometry(2, 6 * [np.nan]))
    covariances.add(odometry(3, 6 * [1e9]))  # as drivers write it that do not know
    assert [covariances.at(rospy.Time(stamp_s)) for stamp_s in (1, 2, 3)] == 3 * [None]
    assert len(said) == 3
    assert "tells no covariance" in said[0]
