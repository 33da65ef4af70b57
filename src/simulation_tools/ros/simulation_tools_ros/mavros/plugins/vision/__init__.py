"""MAVROS's plugins that give the flight controller an external estimate of its motion."""
