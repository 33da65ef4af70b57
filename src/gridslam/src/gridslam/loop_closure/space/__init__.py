"""Places found again in space, by clouds: x, y, yaw and the height. Roll and pitch are the IMU's."""
