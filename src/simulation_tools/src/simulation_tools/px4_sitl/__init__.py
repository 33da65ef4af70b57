"""Real PX4 in the loop: the `Autopilot` that lets PX4 SITL fly, over its simulator protocol.

PX4 brings its own MAVLink ports for MAVROS and ground stations; here is only what takes the place of its
sensors and motors.
"""
