"""What the thesis measured, to stand beside ours."""

TABLE_8_1_MS = {
    "original": {"empty": 14.3, "sparse": 16.9, "forest": 17.0, "hallway": 16.9},
    "improved": {"empty": 0.0, "sparse": 3.2, "forest": 5.1, "hallway": 1.1},
}
"""Mean computation time in ms by algorithm and scenario; 0 where the table says "~ 0"."""
