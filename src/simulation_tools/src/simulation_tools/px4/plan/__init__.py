"""What a ground station uploads: a mission and a fence. How a mission is flown."""
