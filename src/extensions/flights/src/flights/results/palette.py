"""One colour for each algorithm and each lidar, in every picture.

Also legible in grey: the algorithms differ in lightness, and the lidars get darker with their range.
"""

from __future__ import annotations

ALGORITHMS = {"original": "#a8161b", "improved": "#35a860", "dynamic": "#1f78b4"}
"""Red and green as the thesis's arrows (figures 8.6 and 8.7)."""

LIDARS = {
    "urg": "#eda62d",
    "ust": "#e2663b",
    "tim": "#1f9489",
    "utm": "#2f68bf",
    "puck": "#6f3289",
    "m8": "#2b2233",
}
"""By range, shortest first."""

MARKERS = {"urg": "v", "ust": "s", "tim": "D", "utm": "o", "puck": "^", "m8": "P"}

SOLID = "#5b6066"
"""Obstacles."""

TRUTH, BELIEF = "#1f3b73", "#c2410c"
"""The true path; SLAM's path."""
