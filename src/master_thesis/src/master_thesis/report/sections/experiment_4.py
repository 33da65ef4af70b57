"""Experiment 4 on the page: the cargo hold, figures 8.13 to 8.17."""

from __future__ import annotations

from typing import Sequence

from master_thesis.experiments_3_4.map_variants import medians
from master_thesis.experiments_3_4.mapping_flight import SCENARIOS
from master_thesis.report import thesis
from master_thesis.report.content import (
    Block,
    Finding,
    Section,
    Table,
    counted,
    listed,
    number,
    resting_on,
    seeds_of,
)
from master_thesis.report.pieces.experiments_3_4 import OPEN, tim_of_the_text
from master_thesis.report.sections.maps import (
    Maps,
    map_picture,
    map_pictures,
    maps_of,
    maps_table,
    range_chart,
    short_name,
)
from master_thesis.report.size import Size
from master_thesis.trials.store import Store
from master_thesis.trials.trial import Row

HOLD_LENGTH_M = 30.0
ALIKE_M = 0.02
"""Maps whose metrics differ by less look equal."""
LEFT_BENT_M = 0.1
"""With a greater trajectory error we do not call a map true to the world."""
BULGE_M = 0.03
"""A wall bent by more than this (root mean square) looks bent; a cell of the map is 0.05 m."""


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    maps, shown = maps_of("hold", size, store)
    speed_m_s = SCENARIOS["hold"].speed_m_s
    text = _tim_of_the_text(size, store)
    blocks: list[Block] = []
    if maps.lidars:
        blocks = [maps_table(maps, "The maps of the hold"), range_chart(maps)]
        blocks += [_by_seed(maps, lidar) for lidar in ("urg", "ust") if lidar in maps.lidars]
        blocks += map_pictures(maps, shown)
    blocks += [
        map_picture(
            f"SICK TiM with the text's {thesis.TIM_RANGE_IN_TEXT_M:g} m",
            thesis.MAPS["hold"]["tim"],
            done,
            OPEN,
        )
        for done in text
        if OPEN in done.result["pictures"]
    ]
    return Section(
        key="experiment_4",
        title="Experiment 4: SLAM in a cargo hold",
        reference="8.2, figures 8.13 to 8.17; discussed in 9.1.2",
        method=(
            "The UAV flies one round trip along the walls of a hold of 30 x 20 m, whose beams repeat "
            f"every 3 m, at {speed_m_s:g} m/s and 3 m from the plating, by the ground truth; its "
            "odometry drifts. gridslam maps the recorded scans, without loop closure as gmapping does, "
            "and with it."
        ),
        blocks=blocks,
        findings=findings(maps, [done.result[OPEN] for done in text]),
        parameters=f"{seeds_of(size.map_seeds)}; one round trip at {speed_m_s:g} m/s",
    )


def _tim_of_the_text(size: Size, store: Store) -> list[Row]:
    """Return the flights of the TiM with the range in the thesis's text."""
    if "hold" not in size.worlds or "tim" not in size.lidars:
        return []
    found = (store.get(tim_of_the_text(size, seed)) for seed in size.map_seeds)
    return [done for done in found if done is not None]


def _by_seed(maps: Maps, lidar: str) -> Table:
    rows, worse = [], 0
    for without, closed in zip(maps.open[lidar], maps.closed[lidar]):
        worse += closed["ate_rmse_m"] > without["ate_rmse_m"]
        rows.append(
            (
                str(without["seed"]),
                *(number(metrics["ate_rmse_m"], 3) for metrics in (without, closed)),
                *(number(metrics["map_error_p95_m"], 3) for metrics in (without, closed)),
                *(number(metrics["end_error_m"], 3) for metrics in (without, closed)),
                str(closed["closures"]),
            )
        )
    header = (
        "seed",
        "trajectory error, m",
        "closed",
        "95 % of the map, m",
        "closed",
        "error at the end, m",
        "closed",
        "loops",
    )
    return Table(
        f"Flight by flight: {thesis.LIDARS[lidar].name}, without loop closure and with it",
        header,
        rows,
        note=f"With loop closure the path got worse in {worse} of {counted(len(rows), 'flight')}.",
    )


# -- what agrees --------------------------------------------------------------------------------------------


def findings(maps: Maps, tims_of_the_text: Sequence[dict] = ()) -> list[Finding]:
    """Return the thesis's statements beside our numbers.

    tims_of_the_text: metrics of the maps by a TiM with the 15 m of the thesis's text.
    """
    found = []
    long, short = (
        [n for n in maps.lidars if test(thesis.LIDARS[n].range_m)] for test in (_reaches, _is_short)
    )
    if long and short:
        found.append(_range_decides(maps, long, short))
    if long:
        found.append(_equal_to_the_world(maps, long))
    if {"puck", "m8"} <= set(maps.lidars):
        found.append(_indistinguishable(maps))
    if {"tim", "utm"} <= set(maps.lidars):
        found.append(_bulge(maps, tims_of_the_text))
    if "ust" in maps.lidars:
        found.append(_mended(maps))
    if "urg" in maps.lidars:
        found.append(_beyond_mending(maps))
    return resting_on(found, maps.fewest, "flight of each")


def _reaches(range_m: float) -> bool:
    return range_m >= HOLD_LENGTH_M


def _is_short(range_m: float) -> bool:
    return range_m <= 10.0


def _range_decides(maps: Maps, long: list[str], short: list[str]) -> Finding:
    best_short = min(maps.middle(lidar)["ate_rmse_m"] for lidar in short)
    worst_long = max(maps.middle(lidar)["ate_rmse_m"] for lidar in long)
    return Finding(
        "“The range of the lidars on the other hand has a huge impact”, seen most clearly here.",
        "9.1.2",
        f"Trajectory error: {best_short:.3f} m or more with {_named(short)}, {worst_long:.3f} m or less "
        f"with {_named(long)}.",
        best_short > 2.0 * worst_long,
        "In these flights the short-sighted lidars did about as well.",
    )


def _equal_to_the_world(maps: Maps, long: list[str]) -> Finding:
    bad = [lidar for lidar in long if not maps.is_true(lidar)]
    worst = max(maps.middle(lidar)["map_error_p95_m"] for lidar in long)
    return Finding(
        "The lidars that reach across “created maps pretty much equal to both each other and the actual "
        "world”.",
        "9.1.2, figures 8.16a, 8.17",
        f"{_named(long)}: 95 % of every map within {worst:.3f} m of a true wall.",
        not bad,
        f"Not so of {_named(bad)}.",
    )


def _indistinguishable(maps: Maps) -> Finding:
    puck, m8 = maps.middle("puck"), maps.middle("m8")
    keys = ("ate_rmse_m", "map_error_mean_m", "map_error_p95_m")
    apart = max(abs(puck[key] - m8[key]) for key in keys)
    return Finding(
        "Puck and M8: “The maps are virtually indistinguishable.”",
        "figure 8.17",
        f"Their trajectory and map errors differ by {apart:.3f} m at most.",
        apart < ALIKE_M,
        "That is more than the eye overlooks.",
    )


def _bulge(maps: Maps, text: Sequence[dict]) -> Finding:
    tim, utm = (maps.middle(lidar)["wall_straightness_rms_m"] for lidar in ("tim", "utm"))
    lidar, text_m = thesis.LIDARS["tim"], thesis.TIM_RANGE_IN_TEXT_M
    of_text = medians(text)["wall_straightness_rms_m"] if text else None
    agrees = utm < BULGE_M < max(tim, of_text or 0.0)
    ours = f"Its walls' cells deviate from straight lines by {tim:.3f} m, the UTM's by {utm:.3f} m."
    if of_text is not None:
        ours += f" With the {text_m:g} m that the thesis's text gives the TiM: {of_text:.3f} m."
    nothing = f"With the {lidar.range_m:g} m of table 8.2, as above, nothing bulges: it sees the far wall."
    return Finding(
        "TiM: “even though the map is good, the wall on the long-side bulges inwards a bit”.",
        "9.1.2, figure 8.16b",
        ours,
        agrees,
        f"A wall is bent to the eye from about {BULGE_M:g} m on; gridslam keeps below that.",
        remark=nothing if agrees and tim <= BULGE_M else "",
    )


def _mended(maps: Maps) -> Finding:
    bent, closed = not maps.is_true("ust"), maps.is_true("ust", closure=True)
    without, with_it = maps.middle("ust"), maps.middle("ust", closure=True)
    why = f"Our loop closure leaves it: {maps.verdict('ust', closure=True)}."
    if not bent:
        why = "In these flights the filter alone kept the walls straight."
    return Finding(
        "UST: the walls bend, and “the misalignment was fixed by the loop closure”.",
        "figure 8.15",
        f"Trajectory error {without['ate_rmse_m']:.3f} m without loop closure, "
        f"{with_it['ate_rmse_m']:.3f} m with it; 95 % of the map within {without['map_error_p95_m']:.3f} "
        f"and {with_it['map_error_p95_m']:.3f} m of a wall.",
        bent and closed,
        why,
    )


def _beyond_mending(maps: Maps) -> Finding:
    bent, closed = not maps.is_true("urg"), maps.is_true("urg", closure=True)
    without, with_it = maps.middle("urg"), maps.middle("urg", closure=True)
    worst = with_it["ate_rmse_worst_m"]
    why = ""
    if not bent:
        why = "In these flights the filter alone kept the walls straight."
    elif closed:
        why = (
            "gmapping closes loops only by what its particles remember; gridslam's loop closure "
            "recognises the place by its scan and corrects the whole path."
        )
        if worst > LEFT_BENT_M:
            why += f" Not every time: the worst flight is still off by {worst:.2f} m."
    return Finding(
        "URG: “the drift is so bad that the loop-closure in the SLAM algorithm could not correct it”.",
        "9.1.2, figure 8.14",
        f"Trajectory error {without['ate_rmse_m']:.3f} m without loop closure: {maps.verdict('urg')}. "
        f"With it {with_it['ate_rmse_m']:.3f} m, {with_it['closures']:.0f} loops: "
        f"{maps.verdict('urg', closure=True)}.",
        bent and not closed,
        why,
    )


def _named(lidars: Sequence[str]) -> str:
    return listed([short_name(lidar) for lidar in lidars])
