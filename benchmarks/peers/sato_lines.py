"""Marks dark lines with scikit-image's `sato` and hysteresis, untuned: the baseline of `bench findings`.

Runs on the peer's Python: sato_lines.py LIST FOLDER, with LIST a JSON of paths of pictures. It writes
FOLDER/NUMBER.png, masks, and FOLDER/report.json: CPU seconds of each picture, and the peak memory, MB.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image
from skimage.filters import apply_hysteresis_threshold, sato

SIGMAS_PX = (1, 2, 3)
LOW, HIGH = 2.0, 4.0
"""Of the hysteresis: standard deviations of the answer above its mean."""


def main(listed: str, folder: str) -> None:
    """Mark all pictures."""
    seconds = []
    for number, path in enumerate(json.loads(Path(listed).read_text(encoding="utf-8"))):
        with Image.open(path) as image:
            grey = np.asarray(image.convert("L"), dtype=float) / 255.0
        start = time.process_time()
        answer = sato(grey, sigmas=SIGMAS_PX)
        low, high = (answer.mean() + times * answer.std() for times in (LOW, HIGH))
        marked = apply_hysteresis_threshold(answer, low, high)
        seconds.append(time.process_time() - start)
        Image.fromarray(marked).save(Path(folder, f"{number}.png"))
    report = {"cpu_s": seconds, "peak_mb": peak_mb()}
    Path(folder, "report.json").write_text(json.dumps(report), encoding="utf-8")


def peak_mb() -> float:
    """Return the greatest memory of this process. That of getrusage would count the process that began it."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return next(float(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")) / 1024.0


if __name__ == "__main__":
    main(*sys.argv[1:])
