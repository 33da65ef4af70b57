"""The UAV: the forces of rotors and air, the gimbal, and the model with its lidar."""
