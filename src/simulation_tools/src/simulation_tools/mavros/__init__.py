"""MAVROS's side of MAVLink without ROS: the client and the conversions."""
