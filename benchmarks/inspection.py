"""Inspections of `hold_3d` without ROS: how good plans are, and what is found in their photographs.

plan: at 1 mm per pixel in the worst direction, incidence up to 60 deg, for the UAV of `inspection.launch`.
The bounds are the LP's of the photographs and the Held-Karp bound of the tour.

findings: photographs of such a plan, drawn so that they show each rust spot and each crack of 1 mm or more
that it shows. The poses that `findings` is told are off by 6 mm and 0.33 deg in the median, as SLAM's are in
flight. Then a second look at 0.3 mm per pixel at each crack found. The judge knows the defects, and counts
those of which half lies in a photograph at 1 mm per pixel and 60 deg. A false alarm is near no defect of its
kind.

effects: photographs before rust and cracks of other seeds, the same places with each effect of the camera
(simulation_tools/doc/camera.md): none, one at its greatest, and all together at 0.6. --effects chooses them.
Poses and judge are those of the row findings; the area counts again in each photograph that shows it.
false_a_picture, false_of_the_worst: false alarms that a photograph has part in, mean and most.

flown: the first photographs of such a plan, flown with dynamics and without GNSS by a Puck's odometry, from
take-off to landing. No pixel is rendered. With --battery the UAV comes home for full batteries, else the
battery does not count. With --passing it takes them in passing at 0.5 m/s. With --photographs 0 it flies the
whole plan, searched for 20 s, and then photographs what stays open. The judge takes the true poses.
share_of_planned: of what these photographs would show from their own places. share, shares: of what is
reachable, of all and of each thing.

graded: a corroded box of six plates, photographed all over, with poses off as in the row findings. right: of
the plates' grades, those that are the same by the findings as by the true rust.

mapped: a plan on the map of an exploration, flown as in `bench explore` with a Puck. share, shares: what its
photographs would show of the drawing, of what is reachable there. mesh_cpu_s: of the map's surface. rust:
where its spots would be placed on the map, from poses that are off by 2.5 cm and 0.3 deg in the median.

surveyed: a whole survey without a flight, with poses off as in the row findings: --places ballast_tank
hold_3d. share, shares: told, and by the true poses. areas: grade, rusted share of the area and of edges; the
truth counts what was not seen, too.

missions: photographs of small rooms, flown on a battery that is too small: see `inspection_rows/missions.py`.

Keys: inspection.hold_3d.mapped.{photographs, share, shares, mesh_cpu_s, cpu_s, contacts, rust.{shown,
found, false, off_p95_m}}, medians, and
inspection.hold_3d.plan.{photographs, lp_ratio, tour_ratio, flights, flight_s, share, cpu_s} and
inspection.hold_3d.{findings, second_look}.{rust, cracks, wide_cracks}.{found, shown},
.false_{rust, cracks}_per_100_m2, .off_p95_m, .area_m2, .photographs, .cpu_s
and inspection.hold_3d.effects.NAME.{rust, cracks, wide_cracks}.{found, shown},
.false_{rust, cracks}_per_100_m2, .false_a_picture, .false_of_the_worst, .area_m2, .photographs, .cpu_s
and inspection.hold_3d.flown[_in_passing].{asked, taken, left_out, shots, contacts, landed, flights,
least_charge, share_planned, share_of_planned, share, shares, m2_per_min, each_s, off_m, off_deg, flight_s},
medians over the flights; each_s: time of flight for each photograph; and
inspection.NAME.surveyed.{surveys, areas_graded, grades_right, told_above_true, each}, and
inspection.rooms.missions.{missions, landings, below_goal, least_charge, contacts, not_home, asked, taken,
left_out, open, lost}, of all missions together
"""

from __future__ import annotations

import argparse
import json
from typing import Sequence

import numpy as np

from benchmarks.inspection_rows import effects, flown, found, graded, mapped, missions, planned, surveyed
from benchmarks.shared.results import Results
from benchmarks.shared.trials import run_crossed, trial_options

SEARCH_S, BRIEF_SEARCH_S = 20.0, 0.0


def main(arguments: Sequence[str] | None = None) -> None:
    """Plan, photograph, find, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=tuple(ROWS))
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument(
        "--photographs", type=int, default=flown.MOST, help="of a flight; 0: all (%(default)s)"
    )
    parser.add_argument(
        "--effects", nargs="+", choices=effects.NAMES, default=effects.NAMES, help="of the row effects"
    )
    parser.add_argument(
        "--before", type=int, default=effects.MOST, help="photographs of the row effects (%(default)s)"
    )
    parser.add_argument("--battery", action="store_true", help="the battery counts, and is swapped")
    parser.add_argument("--passing", action="store_true", help="photographs are taken in passing")
    parser.add_argument(
        "--places", nargs="+", choices=surveyed.PLACES, default=["ballast_tank"], help="of the row surveyed"
    )
    parser.add_argument(
        "--part", type=int, default=surveyed.MOST, help="photographs of the row surveyed, the first ones"
    )
    given = parser.parse_args(arguments)
    with Results("inspection", given.results, vars(given)) as results:
        for row in given.rows:
            ROWS[row](given, results)


def _plans(given: argparse.Namespace, results: Results) -> None:
    search_s = BRIEF_SEARCH_S if given.brief else SEARCH_S
    seeds = _seeds(given, planned.SEEDS)
    rows = run_crossed("inspection_plan", planned.plan, given, seed=seeds, search_s=[search_s])
    _add(results, "inspection.hold_3d.plan", _medians(list(rows.values())))


def _findings(given: argparse.Namespace, results: Results) -> None:
    most = found.BRIEF_MOST if given.brief else found.MOST
    seeds = _seeds(given, found.SEEDS)
    looks = run_crossed("inspection_findings", found.look, given, seed=seeds, most=[most])
    for name in ("findings", "second_look"):
        rows = [each[name] for each in looks.values() if name in each]
        if rows:
            _add(results, f"inspection.hold_3d.{name}", _sums(rows))


def _effects(given: argparse.Namespace, results: Results) -> None:
    most = effects.BRIEF_MOST if given.brief else given.before
    seeds, names = _seeds(given, effects.SEEDS), ["none"] if given.brief else list(given.effects)
    looks = run_crossed(
        "inspection_effects", effects.look, given, seed=seeds, most=[most], names=[tuple(names)]
    )
    for name in names:
        rows = [each[name] for each in looks.values()]
        _add(results, f"inspection.hold_3d.effects.{name}", effects.summary(rows))


def _graded(given: argparse.Namespace, results: Results) -> None:
    most = graded.BRIEF_MOST if given.brief else graded.MOST
    seeds = _seeds(given, graded.SEEDS)
    boxes = run_crossed("inspection_graded", graded.grade, given, seed=seeds, most=[most])
    _add(results, "inspection.corroded.graded", graded.summary(list(boxes.values())))


def _flown(given: argparse.Namespace, results: Results) -> None:
    most = flown.BRIEF_MOST if given.brief else given.photographs
    seeds = _seeds(given, flown.SEEDS)
    flights = run_crossed(
        "inspection_flown", flown.fly, given, seed=seeds, most=[most], battery=[given.battery],
        passing=[given.passing],
    )  # fmt: skip
    key = "inspection.hold_3d.flown" + ("_in_passing" if given.passing else "")
    _add(results, key, _medians(list(flights.values())))


def _mapped(given: argparse.Namespace, results: Results) -> None:
    time_s = mapped.BRIEF_TIME_S if given.brief else mapped.TIME_S
    search_s = BRIEF_SEARCH_S if given.brief else SEARCH_S
    seeds = _seeds(given, mapped.SEEDS)
    maps = run_crossed(
        "inspection_mapped", mapped.fly, given, seed=seeds, time_s=[time_s], search_s=[search_s]
    )
    _add(results, "inspection.hold_3d.mapped", _medians(list(maps.values())))


def _missions(given: argparse.Namespace, results: Results) -> None:
    most = missions.BRIEF_MOST if given.brief else missions.MOST
    seeds = _seeds(given, missions.SEEDS)
    ended = run_crossed("inspection_missions", missions.fly, given, seed=seeds, most=[most])
    _add(results, "inspection.rooms.missions", missions.summary(list(ended.values())))


def _surveyed(given: argparse.Namespace, results: Results) -> None:
    most = surveyed.BRIEF_MOST if given.brief else given.part
    seeds = _seeds(given, surveyed.SEEDS)
    rows = run_crossed(
        "inspection_surveyed", surveyed.survey, given, name=given.places, seed=seeds, most=[most]
    )
    for place in given.places:
        _add(results, f"inspection.{place}.surveyed", surveyed.summary([rows[place, s, most] for s in seeds]))


ROWS = {
    "plan": _plans,
    "findings": _findings,
    "effects": _effects,
    "graded": _graded,
    "flown": _flown,
    "mapped": _mapped,
    "surveyed": _surveyed,
    "missions": _missions,
}


def _seeds(given: argparse.Namespace, seeds: Sequence[int]) -> Sequence[int]:
    return given.seeds or seeds[: 1 if given.brief else None]


def _add(results: Results, key: str, numbers: dict) -> None:
    results.add(key, numbers)
    print(key, json.dumps(numbers))


def _medians(rows: Sequence[dict]) -> dict:
    return {"seeds": len(rows), **{key: _median([row[key] for row in rows]) for key in rows[0]}}


def _median(values: Sequence) -> float | dict:
    if isinstance(values[0], dict):
        return {key: _median([each[key] for each in values]) for key in values[0]}
    return float(np.median(values))


def _sums(rows: Sequence[dict]) -> dict:
    """Return what all worlds together have; of the position error, all distances count."""
    kinds = ("rust", "cracks", "wide_cracks")
    total = {key: {what: sum(row[key][what] for row in rows) for what in ("found", "shown")} for key in kinds}
    area_m2 = sum(row["area_m2"] for row in rows)
    false = {
        f"false_{kind}_per_100_m2": 100.0 * sum(row["false"][kind] for row in rows) / area_m2
        for kind in ("rust", "cracks")
    }
    off_m = np.concatenate([row["off_m"] for row in rows])
    counts = {key: sum(row[key] for row in rows) for key in ("area_m2", "photographs", "cpu_s")}
    off_p95_m = float(np.percentile(off_m, 95)) if len(off_m) else None
    return {"worlds": len(rows), **total, **false, "off_p95_m": off_p95_m, **counts}


if __name__ == "__main__":
    main()
