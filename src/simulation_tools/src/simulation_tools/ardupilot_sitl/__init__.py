"""ArduPilot Copter in the loop: the `Autopilot` that lets ArduPilot SITL fly, over its JSON physics link.

ArduPilot opens its own MAVLink links to MAVROS and ground stations. This folder replaces only its sensors and
motors, and starts its program.
"""
