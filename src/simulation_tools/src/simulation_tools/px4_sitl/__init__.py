"""Real PX4 in the loop: the `Autopilot` that lets PX4 SITL fly, over its simulator protocol.

PX4 brings its own MAVLink ports for MAVROS and ground stations; this room only replaces its
sensors and motors.
"""
