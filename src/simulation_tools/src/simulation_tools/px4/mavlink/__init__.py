"""The flight controller's MAVLink side: UDP links, messages in and out, parameters, commands."""
