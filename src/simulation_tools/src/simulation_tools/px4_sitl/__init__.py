"""Real PX4 in the loop: the `Autopilot` that lets PX4 SITL fly, over its simulator protocol.

PX4 opens its own MAVLink ports for MAVROS and ground stations. This folder only replaces PX4's sensors and
motors.
"""
