"""The explorations on the page."""

from __future__ import annotations

from flights.trials.store import Store
from master_thesis.exploring.pieces import EXPERIMENT, PICTURE, SEED, piece
from master_thesis.report.content import Block, Picture, Section, Table, number
from master_thesis.report.size import Size

PLACES = {"hold_3d": "a hold", "cells": "a room with pockets", "ballast_tank": "a ballast tank"}
"""In words; else the place's own name."""
SHARES = {
    "known_share": ("reachable volume known, %", 1),
    "mapped_share": ("visible surface mapped, %", 1),
}
TIMES = {"time_99_s": "99 % known after, s", "end_s": "end after, s", "home_s": "home after, s"}


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    found = {place: store.get(piece(size, place)) for place in size.explored}
    flown = {place: row.result for place, row in found.items() if row is not None}
    blocks: list[Block] = [_table(flown), _left(flown)] if flown else []
    blocks += [_picture(place, result) for place, result in flown.items()]
    return Section(
        key=EXPERIMENT,
        title="Exploration",
        reference="the thesis's future work (10.1)",
        method=(
            "A UAV with a Puck takes off in a place that it knows nothing of, without GNSS. It flies to what "
            "is unknown, comes home when nothing that it can reach is left, and lands."
        ),
        blocks=blocks,
        findings=(),
        parameters=f"seed {SEED}; launch file explore.launch",
    )


def _table(flown: dict[str, dict]) -> Table:
    header = (
        "place",
        "end",
        *(heading for heading, _ in SHARES.values()),
        *TIMES.values(),
        "views",
        "home",
        "contacts",
    )
    rows = [
        (
            _words(place),
            result["end"] or "-",
            *(number(100.0 * result[key], digits) for key, (_, digits) in SHARES.items()),
            *(number(result[key], 0) for key in TIMES),
            str(result["views"]),
            "yes" if result["is_home"] else "no",
            "yes" if result["contact"] else "none",
        )
        for place, result in flown.items()
    ]
    return Table(
        "Explored places",
        header,
        rows,
        note="Both shares come from the world's own surfaces, on voxels of 0.05 m. Reachable is what a ball "
        "of the UAV's clearance can fill from the start.",
    )


def _left(flown: dict[str, dict]) -> Table:
    reasons = list(next(iter(flown.values()))["left_m2"])
    return Table(
        "What stays unknown at the end: area of the border, m², by its reason",
        ("place", *reasons),
        [
            (_words(place), *(number(result["left_m2"][reason], 1) for reason in reasons))
            for place, result in flown.items()
        ],
    )


def _picture(place: str, result: dict) -> Picture:
    return Picture(
        result["pictures"][PICTURE].encode(),
        f"The map of {_words(place)}, cut open, and the path of the UAV. Above right: the volume that was "
        "known.",
        "Three views of the map of voxels with the path, and the known volume over the time",
        wide=True,
    )


def _words(place: str) -> str:
    return PLACES.get(place, place)
