"""Explorations: one flight through each place, judged by the world's own surfaces."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

from exploration.next_view import Why
from exploration.warm_up import warm_up_exploration
from flights.exploring.judged_flight import fly_and_judge
from flights.exploring.pictures import explored_figure
from flights.exploring.places import place_of
from flights.results.picture_files import svg
from gridslam.volume.warm_up import warm_up_volume
from gridslam.warm_up import warm_up
from master_thesis.report.piece import Piece, fingerprint
from master_thesis.report.size import Size

EXPERIMENT, PICTURE = "exploration", "explored"
SEED = 1
TIME_S = 400.0
_COST_S = {"hold_3d": 400.0}
_ANY_COST_S = 60.0


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    return [piece(size, place) for place in size.explored]


def piece(size: Size, place: str) -> Piece:
    """Return the piece of one flight. place: of `exploring.places.ROWS`."""
    time_s = size.map_duration_s or TIME_S
    shorter = f"_{time_s:g}s" if size.map_duration_s else ""
    return Piece(
        name=f"{EXPERIMENT}_{place}{shorter}",
        experiment=EXPERIMENT,
        title=f"Exploration: {place}",
        run=make,
        given={"place": place, "time_s": time_s},
        inputs=fingerprint(place_of(place, SEED)),
        cost_s=_COST_S.get(place, _ANY_COST_S),
    )


def make(place: str, time_s: float) -> dict:
    """Fly and judge; return the figures and the picture. Times in s, from the begin of the exploration."""
    warm_up()
    warm_up_volume()
    warm_up_exploration()
    drawn = place_of(place, SEED)
    with tempfile.TemporaryDirectory() as folder:
        flown = fly_and_judge(drawn, drawn.written_to(Path(folder)), SEED, time_s, 2.0 * TIME_S)
    explored, judged = flown.explored, flown.judged
    figure = explored_figure(flown.voxels, flown.path_m, flown.known)
    is_ended, is_back = math.isfinite(explored.ended_s), math.isfinite(flown.home_s)
    return {
        "end": explored.end.value if explored.end else "",
        "time_99_s": explored.time_of(0.99) - flown.began_s if explored.known_m3 else None,
        "end_s": explored.ended_s - flown.began_s if is_ended else None,
        "home_s": flown.home_s if is_back else None,
        "is_home": flown.is_home,
        "contact": flown.outcome.collision,
        "known_share": judged.known_share,
        "mapped_share": judged.mapped_share,
        "reachable_m3": judged.reachable_m3,
        "views": explored.views,
        "left_m2": {why.value: explored.left_m2(why) for why in Why},
        "pictures": {PICTURE: svg(figure)},
    }
