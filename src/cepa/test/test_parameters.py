import numpy as np

from cepa import CepaParameters


def test_defaults_are_those_that_were_tuned():
    p = CepaParameters()
    assert (p.r_lb, p.r_ub, p.time_horizon, p.body_radius) == (0.5, 1.2, 1.5, 0.35)
    assert (p.k_filter, p.emergency_lookahead, p.speed_fractions) == (50.0, 1.2, (1.0, 0.75, 0.5, 0.25))
    assert not p.unseen_is_free


def test_speed_fractions_are_sorted_and_unique():
    assert CepaParameters(speed_fractions=[0.5, 1, 0.5]).speed_fractions == (1.0, 0.5)


def test_numbers_of_numpy_are_numbers():
    p = CepaParameters(r_lb=np.float32(0.5), k3=np.float64(0.25), dropout_beams=np.int64(3))
    assert p == CepaParameters(r_lb=0.5, k3=0.25, dropout_beams=3)
    assert (type(p.r_lb), type(p.k3), type(p.dropout_beams)) == (float, float, int)
