"""What the thesis measured, to stand beside ours."""

TABLE_8_1_MS = {
    "original": {"empty": 14.3, "sparse": 16.9, "forest": 17.0, "hallway": 16.9},
    "improved": {"empty": 0.0, "sparse": 3.2, "forest": 5.1, "hallway": 1.1},
}
"""Mean computation time in ms by algorithm and scenario; 0 where the table says "~ 0"."""

MAPS = {
    "range_m": {"urg": 5.6, "ust": 10.0, "utm": 30.0, "puck": 100.0, "tim": 25.0, "m8": 150.0},
    "room": {
        "urg": "slightly less complete",
        "ust": "pretty good",
        "utm": "pretty good",
        "puck": "pretty good",
        "tim": "a wall drifted, corrected when seen again",
        "m8": "pretty good",
    },
    "hold": {
        "urg": "drifted too far for the loop closure",
        "ust": "misaligned, corrected by the loop closure",
        "utm": "equal to the world",
        "puck": "equal to the world",
        "tim": "good, the long wall bulges inwards a bit",
        "m8": "equal to the world",
    },
}
"""Ranges (table 8.2) and what the thesis says of its maps (8.2 and 9.1.2), by world and lidar."""
