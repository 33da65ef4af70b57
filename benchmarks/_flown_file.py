"""The flights of a campaign as they are flown, in a file: an interrupted campaign goes on from it.

One line of JSON for each flight; the first line says which commit flew them.
"""

from __future__ import annotations

import dataclasses
import json
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks import _campaign
from benchmarks._campaign import Flown, Trial


class FlownFile:
    """What has been flown so far."""

    def __init__(self, path: Path, commit: str, resume: bool = False) -> None:
        """Begin a file, or take one up again.

        Raises:
            ValueError: it cannot be taken up, because another commit's flights are in it.
        """
        self.flown: dict[Trial, Flown] = {}
        self._path = Path(path)
        if resume and self._path.exists():
            self._read(commit)
        else:
            self._path.write_text(json.dumps({"commit": commit}) + "\n", encoding="utf-8")

    def _read(self, commit: str) -> None:
        head, *lines = self._path.read_text(encoding="utf-8").splitlines()
        of_file = json.loads(head)["commit"]
        if of_file != commit:
            raise ValueError(
                f"{self._path} holds flights of another commit, {of_file}; fly without --resume."
            )
        for line in lines:
            try:
                flight = json.loads(line)
            except ValueError:
                break  # the line that was being written when the campaign was interrupted
            trial = Trial(**flight.pop("trial"))
            path_xy = np.array(flight.pop("path_xy")).reshape(-1, 2)
            self.flown[trial] = Flown(trial, path_xy=path_xy, **flight)
        whole = [head, *(_line(flight) for flight in self.flown.values())]
        self._path.write_text("\n".join(whole) + "\n", encoding="utf-8")

    def add(self, flight: Flown) -> None:
        """Take note of a flight, on the disk too."""
        self.flown[flight.trial] = flight
        with open(self._path, "a", encoding="utf-8") as stream:
            stream.write(_line(flight) + "\n")


def _line(flight: Flown) -> str:
    values = dataclasses.asdict(flight)
    values["path_xy"] = np.round(flight.path_xy, 3).tolist()
    return json.dumps(values)


def fly_all(trials: Sequence[Trial], workers: int, file: FlownFile) -> None:
    """Fly the trials that are not in the file yet, in some processes."""
    missing = [trial for trial in trials if trial not in file.flown]
    with ProcessPoolExecutor(workers) as pool:
        flights = [pool.submit(_campaign.fly, trial) for trial in missing]
        done = len(trials) - len(missing)
        for flight in tqdm(as_completed(flights), "flights", len(trials), initial=done, unit=" flights"):
            file.add(flight.result())
