"""MAVROS's plugins that send what the flight controller is told, and its fence."""
