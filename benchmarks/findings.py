"""What `findings` marks on public photographs, beside the truth that comes with them.

--photographs FOLDER with --masks FOLDER: a mask of the same name for each picture, whatever its suffix.
Marked pixels that lie within the tolerance of the mask are right, and those of the mask within the tolerance
of a mark are found. --photographs FOLDER with --truth FILE: a table with the columns `name` and the kind
(crack or rust), yes or no; a picture with one mark or more says yes. `--peers sato` runs scikit-image's ridge
filter with hysteresis beside, untuned, on masks of cracks; it is installed at first. Every picture counts,
but those that are named with the reason. The pictures are taken one by one, without poses, at their own
size. Those that are blurred, written upon (a time stamp) or not stored as RGB count, and they are told and
counted apart, too. --burn-stamp SEED and --blur PX put such flaws into each picture. Then `blurred` and
`written` say how many of them are told, and without these options how many are told falsely.

Keys: findings.SET.KIND.{ours, sato}.{precision, recall, f}, of all pictures together; .f_p10, .f_median,
.f_p90 over the pictures; .cpu_s, the median of a picture; .cpu_s_per_mp; .peak_mb of the process; .pictures;
.left_out; .blurred, .written, .converted: so many pictures are told to have this flaw; .clean: pictures that
show nothing of the kind; .false_alarms in them, and .false_alarms_a_picture; and with --truth .true,
.found_of_true, .false, .others, .wrong. The same of ours_blurred, ours_written and ours_converted, of such
pictures alone; with --halves, of first_half, on which one may tune, and of second_half.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path
from typing import Any, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.findings_rows import ours, public_set
from benchmarks.findings_rows.apart import WORDS, flaws_of, told_of
from benchmarks.findings_rows.burnt import Burnt
from benchmarks.findings_rows.halves import halves_of
from benchmarks.findings_rows.public_set import PublicSet, SetError
from benchmarks.findings_rows.sato import lines_by_sato
from benchmarks.findings_rows.scores import Score, of_answer, of_pixels, total
from benchmarks.peers.environments import PeerError
from benchmarks.shared.results import Results, options, table

KINDS = ("crack", "rust")
MOST_BLUR_PX = 200.0
HEADER = ("", "precision", "recall", "F", "F p10", "median", "p90", "CPU s a picture", "a MP", "peak MB")
BRIEF = "bench findings: nothing is measured without --photographs FOLDER; its --help says what it reads."


def main(arguments: Sequence[str] | None = None) -> None:
    """Search, compare, print and write."""
    parser = options(__doc__ or "")
    parser.add_argument("--photographs", type=Path, metavar="FOLDER", help="of pictures; folders in it count")
    parser.add_argument("--masks", type=Path, metavar="FOLDER", help="of masks with the pictures' names")
    parser.add_argument(
        "--label", type=int, help="of the masks' pixels that count; default: all but the most"
    )
    parser.add_argument("--truth", type=Path, metavar="FILE", help="CSV: name, and crack or rust: yes or no")
    parser.add_argument("--kind", choices=KINDS, default="crack")
    parser.add_argument("--tolerance", type=float, default=5.0, help="of marks beside the mask, px")
    parser.add_argument(
        "--halves",
        type=int,
        metavar="SEED",
        help="with --truth: tell both halves of the set by this seed",
    )
    parser.add_argument(
        "--burn-stamp", type=int, metavar="SEED", help="burn a date and time into each picture"
    )
    parser.add_argument("--blur", type=float, default=0.0, metavar="PX", help="blur each by a motion so long")
    parser.add_argument("--set", default=None, help="name of the set; default: that of its folder")
    parser.add_argument("--peers", nargs="+", default=(), choices=("sato",))
    given = parser.parse_args(arguments)
    if given.photographs is None:
        if not given.brief:
            parser.error("give --photographs FOLDER, and --masks FOLDER or --truth FILE")
        print(BRIEF)
        return
    if (given.masks is None) == (given.truth is None):
        parser.error("give either --masks FOLDER or --truth FILE")
    if not 0.0 <= given.blur <= MOST_BLUR_PX:
        parser.error(f"--blur is 0 to {MOST_BLUR_PX:g} px")
    if given.burn_stamp is not None and given.burn_stamp < 0:
        parser.error("--burn-stamp needs a seed, 0 or more")
    if "sato" in given.peers and (given.blur or given.burn_stamp is not None):
        parser.error("sato reads the files, so it gets no flaws; leave out --peers")
    if given.halves is not None and given.truth is None:
        parser.error("--halves needs --truth FILE")
    try:
        found = _set_of(given)
    except (SetError, OSError) as error:
        parser.exit(1, f"bench findings: {error}\n")
    name = given.set or given.photographs.resolve().name
    with Results("findings", given.results, vars(given)) as results:
        rows = _by_answers(found, given.kind, given.halves) if given.truth else _by_masks(found, given)
        for who, numbers in rows.items():
            results.add(f"findings.{name}.{given.kind}.{who}", numbers)
        for why in sorted(set(found.left_out.values())):
            print(
                "left out:", ", ".join(name for name, said in found.left_out.items() if said == why), "-", why
            )
        print(
            f"{given.kind} in {name}: {rows['ours']['pictures']} pictures, {len(found.left_out)} left out.\n"
        )
        for line in told_of(found.flaws):
            print(line)
        if rows["ours"]["clean"]:
            print(
                "{clean} pictures show nothing of it: {false_alarms} false alarms in them, "
                "{false_alarms_a_picture:.2f} a picture".format(**rows["ours"])
            )
        print(_table(rows) if given.masks else "\n".join(f"{who}: {_answers(n)}" for who, n in rows.items()))


def _set_of(given: argparse.Namespace) -> PublicSet:
    if given.masks is not None:
        found = public_set.with_masks(given.photographs, given.masks, given.label)
    else:
        found = public_set.with_answers(given.photographs, given.truth, given.kind)
    found.burnt = Burnt(given.burn_stamp, given.blur)
    return found


def _by_masks(found: PublicSet, given: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """Return the figures of each who marks: ours, and the peers that were asked for."""
    paths, masks, scores, cpu_s, megapixels = [], [], [], [], []
    counts: list[int] = []
    for path, picture in tqdm(found.pictures(), total=len(found.masks), unit="picture"):
        mask = found.mask(path, picture.shape[:2])
        if mask is None:
            continue
        start = time.process_time()
        marks = ours.marks_in(picture, given.kind)
        cpu_s.append(time.process_time() - start)
        counts.append(len(marks))
        scores.append(of_pixels(ours.pixels_of(marks, mask.shape), mask, given.tolerance))
        paths.append(path)
        masks.append(mask)
        megapixels.append(mask.size / 1e6)
        found.flaws[path.name] = flaws_of(picture, path)
    rows = {
        who: _figures(_at(places, scores), _at(places, cpu_s), _at(places, megapixels), _peak_mb(), found)
        for who, places in _parts(found, [path.name for path in paths]).items()
    }
    rows["ours"] |= _told(found) | _false_alarms(scores, counts)
    if "sato" in given.peers and given.kind == "crack":
        try:
            lines = lines_by_sato(paths)
        except PeerError as error:
            print(error)
        else:
            of_each = [of_pixels(line, mask, given.tolerance) for line, mask in zip(lines.masks, masks)]
            rows["sato"] = _figures(of_each, lines.cpu_s, megapixels, lines.peak_mb, found)
    return rows


def _by_answers(found: PublicSet, kind: str, seed: int | None) -> dict[str, dict[str, Any]]:
    names, scores, cpu_s, megapixels, wrong = [], [], [], [], []
    counts: list[int] = []
    for path, picture in tqdm(found.pictures(), total=len(found.answers), unit="picture"):
        start = time.process_time()
        counts.append(len(ours.marks_in(picture, kind)))
        says = counts[-1] > 0
        cpu_s.append(time.process_time() - start)
        scores.append(of_answer(says, found.answers[path]))
        megapixels.append(picture.shape[0] * picture.shape[1] / 1e6)
        if says != found.answers[path]:
            wrong.append(path.name)
        names.append(path.name)
        found.flaws[path.name] = flaws_of(picture, path)
    rows = {}
    parts = _parts(found, names)
    if seed is not None:
        for half, members in halves_of(found.answers, seed)._asdict().items():
            parts[f"{half}_half"] = [k for k, name in enumerate(names) if name in members]
    for who, places in parts.items():
        part = _at(places, scores)
        numbers = _figures(part, _at(places, cpu_s), _at(places, megapixels), _peak_mb(), found)
        both = total(part)
        numbers |= {"true": both.true, "found_of_true": both.shown, "false": both.found - both.right}
        of_these = set(_at(places, names))
        numbers |= {"others": len(part) - both.true, "wrong": [name for name in wrong if name in of_these]}
        rows[who] = numbers | _false_alarms(part, _at(places, counts))
    rows["ours"] |= _told(found)
    return rows


def _told(found: PublicSet) -> dict[str, int]:
    """Return of how many pictures each flaw is told."""
    return {word: sum(word in each for each in found.flaws.values()) for word in WORDS.values()}


def _false_alarms(scores: Sequence[Score], counts: Sequence[int]) -> dict[str, Any]:
    """Return how many pictures show nothing of the kind, and what is marked in them. counts: of marks."""
    clean = [count for score, count in zip(scores, counts) if not score.true]
    a_picture = sum(clean) / len(clean) if clean else None
    return {"clean": len(clean), "false_alarms": sum(clean), "false_alarms_a_picture": a_picture}


def _parts(found: PublicSet, names: Sequence[str]) -> dict[str, list[int]]:
    """Return the numbers of all pictures, and of those with each flaw. names: of all."""
    parts = {"ours": list(range(len(names)))}
    for flaw in sorted({flaw for each in found.flaws.values() for flaw in each}):
        parts[f"ours_{flaw}"] = [k for k, name in enumerate(names) if flaw in found.flaws[name]]
    return parts


def _at(places: Sequence[int], values: Sequence[Any]) -> list[Any]:
    return [values[k] for k in places]


def _figures(
    scores: Sequence[Score],
    cpu_s: Sequence[float],
    megapixels: Sequence[float],
    peak_mb: float,
    found: PublicSet,
) -> dict[str, Any]:
    if not scores:
        raise SystemExit(
            "bench findings: no picture is left; the reasons: " + " ".join(found.left_out.values())
        )
    both, each = total(scores), np.array([score.f for score in scores])
    low, median, high = np.percentile(each, (10, 50, 90))
    return {
        "pictures": len(scores), "left_out": len(found.left_out),
        "precision": both.precision, "recall": both.recall, "f": both.f,
        "f_p10": low, "f_median": median, "f_p90": high,
        "cpu_s": float(np.median(cpu_s)), "cpu_s_per_mp": sum(cpu_s) / sum(megapixels), "peak_mb": peak_mb,
    }  # fmt: skip


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _table(rows: dict[str, dict[str, Any]]) -> str:
    keys = ("precision", "recall", "f", "f_p10", "f_median", "f_p90", "cpu_s", "cpu_s_per_mp")
    return table(
        HEADER, [(who, *(f"{n[key]:.3f}" for key in keys), f"{n['peak_mb']:.0f}") for who, n in rows.items()]
    )


def _answers(numbers: dict[str, Any]) -> str:
    return (
        f"found in {numbers['found_of_true']} of {numbers['true']} pictures that show it, "
        f"and in {numbers['false']} of {numbers['others']} that do not; "
        f"{numbers['cpu_s_per_mp']:.3f} s of CPU a megapixel, at most {numbers['peak_mb']:.0f} MB"
    )


if __name__ == "__main__":
    main()
