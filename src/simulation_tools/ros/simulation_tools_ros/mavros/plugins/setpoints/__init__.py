"""MAVROS's plugins that take setpoints, and their common parameter ~mav_frame."""
