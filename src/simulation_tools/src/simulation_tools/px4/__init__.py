"""A stand-in for PX4 (master of July 2021): estimator, commander, controllers, mixer and MAVLink link.

Inside this package frames are NED (world) and FRD (body), and quaternions are (w, x, y, z), as in PX4 and
MAVLink.
"""
