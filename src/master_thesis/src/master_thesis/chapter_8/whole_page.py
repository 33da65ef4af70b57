"""The page of chapter 8: the sections of all experiments and measurements, in the thesis's order."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Sequence

from flights.trials.store import Store
from flights.trials.trial import Failed
from master_thesis.chapter_8.plan import plan
from master_thesis.experiment_1 import section as experiment_1
from master_thesis.experiment_2 import section as experiment_2
from master_thesis.experiments_3_4.report import section_3, section_4
from master_thesis.experiments_3_4.volume import section as volume
from master_thesis.experiments_3_4.without_gnss import section as without_gnss
from master_thesis.exploring import section as exploration
from master_thesis.measurements import section as measurements
from master_thesis.report.content import Section
from master_thesis.report.page import origin, write_page
from master_thesis.report.size import Size

_SECTIONS = (
    experiment_1.section,
    experiment_2.section,
    section_3.section,
    section_4.section,
    volume.section,
    without_gnss.section,
    exploration.section,
    measurements.build_section,
    measurements.launch_section,
)


def write_whole_page(path: Path, size: Size, store: Store, failed: Sequence[Failed] = ()) -> str:
    """Write the page of all finished pieces; return its text.

    Raises:
        ResultsError: it cannot be written.
    """
    return write_page(path, sections(size, store, failed), origin(size.name, plan(size), store))


def sections(size: Size, store: Store, failed: Sequence[Failed] = ()) -> list[Section]:
    """Return the sections, each with its missing pieces."""
    why = {each.trial.name: each.why for each in failed}
    lacking: dict[str, list[str]] = {}
    planned = set()
    for piece in plan(size):
        planned.add(piece.experiment)
        if store.get(piece) is None:
            reason = why.get(piece.name)
            lacking.setdefault(piece.experiment, []).append(
                f"{piece.title}: {reason}" if reason else piece.title
            )
    made = (make(size, store) for make in _SECTIONS)
    return [
        replace(section, missing=tuple(lacking.get(section.key, ())))
        for section in made
        if section.key in planned
    ]
