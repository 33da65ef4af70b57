"""A picture of a wall whose marks are known."""

import numpy as np

from inspection.camera.survey_camera import SurveyCamera

CAMERA = SurveyCamera(800, 600, 60.0)
AWAY_M = 0.7  # 1 mm per pixel


def wall_picture(shift_px=0):
    """A grey wall in front: rust of 40 px, a dark line of 2 x 200 px, a step between two tones."""
    picture = np.full((600, 800, 3), 150, np.uint8)
    picture[:, 700:] = 90
    picture[280:320, 180 - shift_px : 220 - shift_px] = (110, 60, 30)
    picture[200:400, 500 - shift_px : 502 - shift_px] = 70
    noise = np.random.default_rng(1).normal(0.0, 2.0, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)
