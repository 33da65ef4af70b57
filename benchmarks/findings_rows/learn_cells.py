"""Trains the network that tells rust from other red things in `findings` without a mesh.

python -m benchmarks.findings_rows.learn_cells --photographs A B --truth a.csv b.csv --out rust_cells.npz

Each FILE belongs to the folder at its place: a table with the columns `name` and `rust`, yes or no, as `bench
findings` reads it. The network learns on the first half of each set, by the seed. Then both halves are told.
Nobody tells where in a picture the rust is. So at first all red cells of a picture with rust count as rust,
and then fewer and fewer: those that the network itself holds for the likeliest. The light of each picture is
changed at random, so that the network does not learn the exposure.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple, Sequence

import numpy as np
from PIL import Image
from scipy import ndimage

from benchmarks.findings_rows.halves import halves_of
from benchmarks.findings_rows.public_set import SetError, with_answers
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import BLOCK_PX, red_blocks
from inspection.findings.picture.candidates import linear_light as linear
from inspection.findings.picture.rust_cells import FEATURES, LIGHT, RedCells, Weights, likely_cells, red_cells
from inspection.findings.picture.rust_texture import ALSO_CORNERS, CELLS, LEAST_LIKELY

HIDDEN, STEPS, RATE, DECAY, BATCH = 12, 300, 0.012, 2e-4, 3000
"""Neurons; steps of Adam (Kingma and Ba 2015) a round, their size, the weights' penalty, cells a step."""
SHARES = (1.0, 0.7, 0.5, 0.35)
"""Of the cells of a picture with rust that count as rust, round by round."""
CELLS_A_PICTURE = 100
MOST_PIXELS = 9e5
"""Larger pictures are reduced first."""
EXPOSURES = (-1.5, 0.5)
"""Range of what is added to the logarithm of a picture's light."""


class Learnt(NamedTuple):
    """A picture: its set, whether it shows rust, whether it is in the first half, its red cells."""

    of_set: str
    answer: bool
    first: bool
    cells: RedCells | None


def trained(cells: Sequence[np.ndarray], answers: Sequence[bool], rng: np.random.Generator) -> Weights:
    """Return what is learnt of pictures: scaled cells, (n, FEATURES) of each, with answers."""
    parts = [rng.normal(0.0, 0.25, (FEATURES + 1, HIDDEN)), rng.normal(0.0, 0.25, HIDDEN + 1)]
    kept, plain = list(cells), (np.zeros(FEATURES), np.ones(FEATURES))
    for share in (*SHARES[1:], SHARES[-1]):
        parts = _fitted(parts, kept, answers, rng)
        network = Weights(*plain, *parts)
        kept = [_likeliest(network, each, share) if answer else each for each, answer in zip(cells, answers)]
    return Weights(*plain, *parts)


def _fitted(
    parts: list[np.ndarray], cells: Sequence[np.ndarray], answers: Sequence[bool], rng: np.random.Generator
) -> list[np.ndarray]:
    """Return hidden and out after a round. Both answers count alike, and so do the pictures of one."""
    values = np.concatenate(cells)
    right = np.concatenate([np.full(len(each), answer) for each, answer in zip(cells, answers)])
    weights = np.concatenate([np.full(len(each), 1.0 / len(each)) for each in cells])
    for answer in (True, False):
        weights[right == answer] /= max(weights[right == answer].sum(), 1e-9)
    chances = np.cumsum(weights / weights.sum())
    first, second = [np.zeros_like(each) for each in parts], [np.zeros_like(each) for each in parts]
    for step in range(1, STEPS + 1):
        drawn = np.minimum(np.searchsorted(chances, rng.random(BATCH)), len(values) - 1)
        inner = np.tanh(values[drawn] @ parts[0][:-1] + parts[0][-1])
        sums = np.clip(inner @ parts[1][:-1] + parts[1][-1], -50.0, 50.0)
        wrong = (1.0 / (1.0 + np.exp(-sums)) - right[drawn]) / BATCH
        back = wrong[:, None] * parts[1][:-1] * (1.0 - inner**2)
        slopes = (
            np.vstack((values[drawn].T @ back, back.sum(axis=0))),
            np.append(inner.T @ wrong, wrong.sum()),
        )
        for k, slope in enumerate(slopes):
            slope = slope + DECAY * parts[k]
            first[k] = 0.9 * first[k] + 0.1 * slope
            second[k] = 0.999 * second[k] + 0.001 * slope**2
            size = RATE / (1.0 - 0.9**step)
            parts[k] = parts[k] - size * first[k] / (np.sqrt(second[k] / (1.0 - 0.999**step)) + 1e-8)
    return parts


def _likeliest(network: Weights, cells: np.ndarray, share: float) -> np.ndarray:
    order = np.argsort(-network.probabilities(cells))
    likeliest: np.ndarray = cells[order[: max(1, int(share * len(cells)))]]
    return likeliest


def learnt(pictures: Sequence[Learnt], rng: np.random.Generator) -> Weights:
    """Return the weights that are learnt of the first halves."""
    of_first = [(each.cells.features, each.answer) for each in pictures if each.first and each.cells]
    some = [cells[rng.permutation(len(cells))[:CELLS_A_PICTURE]].astype(float) for cells, _ in of_first]
    for cells in some:
        cells[:, LIGHT] += rng.uniform(*EXPOSURES)
    together = np.concatenate(some)
    mean, deviation = together.mean(axis=0), together.std(axis=0) + 1e-6
    network = trained([(each - mean) / deviation for each in some], [answer for _, answer in of_first], rng)
    return network._replace(mean=mean, deviation=deviation)


def says(network: Weights, cells: RedCells | None) -> bool:
    """Return whether enough of the red cells that touch are likely rust."""
    if cells is None:
        return False
    numbers, _ = ndimage.label(likely_cells(cells, network, LEAST_LIKELY), ALSO_CORNERS)
    return bool(np.bincount(numbers.ravel(), minlength=2)[1:].max() >= CELLS)


def read(folder: Path, table: Path, seed: int) -> list[Learnt]:
    """Return the pictures of a set; raises SetError or OSError if it cannot be read."""
    found, parameters = with_answers(folder, table, "rust"), FindingParameters()
    halves, pictures = halves_of(found.answers, seed), []
    for path, picture in found.pictures():
        picture = _reduced(picture)
        red = red_blocks(picture, parameters)
        cells = red_cells(picture, red, BLOCK_PX, linear()) if red.any() else None
        cells = cells if cells is not None and len(cells.features) else None
        pictures.append(Learnt(folder.name, found.answers[path], path.name in halves.first, cells))
    return pictures


def _reduced(picture: np.ndarray) -> np.ndarray:
    height, width = picture.shape[:2]
    share = np.sqrt(MOST_PIXELS / (height * width))
    if share >= 1.0:
        return picture
    size = max(1, int(width * share)), max(1, int(height * share))
    return np.array(Image.fromarray(picture).resize(size, Image.Resampling.BOX))


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, tell and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--photographs", type=Path, nargs="+", required=True, metavar="FOLDER")
    parser.add_argument("--truth", type=Path, nargs="+", required=True, metavar="FILE")
    parser.add_argument("--out", type=Path, default=Path("rust_cells.npz"))
    parser.add_argument("--seed", type=int, default=80)
    given = parser.parse_args(arguments)
    if len(given.photographs) != len(given.truth):
        parser.error("give a FILE for each FOLDER")
    try:
        pictures = [each for pair in zip(given.photographs, given.truth) for each in read(*pair, given.seed)]
    except (SetError, OSError) as error:
        parser.exit(1, f"learn_cells: {error}\n")
    network = learnt(pictures, np.random.default_rng(given.seed))
    for name in dict.fromkeys(each.of_set for each in pictures):
        for first, half in ((True, "first half, learnt"), (False, "second half")):
            part = [
                (says(network, e.cells), e.answer) for e in pictures if (e.of_set, e.first) == (name, first)
            ]
            hits, true = sum(said and answer for said, answer in part), sum(answer for _, answer in part)
            false = sum(said and not answer for said, answer in part)
            print(f"{name}, {half}: found {hits} of {true} with rust, false {false} of {len(part) - true}")
    np.savez(given.out, **{name: value.astype(np.float32) for name, value in network._asdict().items()})
    print(f"written: {given.out}")


if __name__ == "__main__":
    main()
