"""The ground's side of MAVLink as MAVROS does it: the client and the conversions; the node is thin."""
