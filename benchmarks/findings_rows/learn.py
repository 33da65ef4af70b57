"""Trains the small detector of rust that is the worked example of findings.md.

python -m benchmarks.findings_rows.learn --photographs FOLDER --truth FILE --out rust.npz

FILE: a table with the columns `name` and `rust`, yes or no, as `bench findings` reads it. The network learns
on the first half of the set, by the seed, and the limit of cells is chosen there. Then both halves are told.
Nobody tells where in a picture the rust is. So at first all cells of a picture with rust count as rust, and
then only those that the network itself holds for the likeliest.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.findings_rows.halves import halves_of
from benchmarks.findings_rows.public_set import SetError, with_answers
from inspection.findings.picture.learnt import FEATURES, Network, features_of

HIDDEN, STEPS, RATE, DECAY = 16, 300, 0.02, 1e-3
"""Neurons; steps of Adam (Kingma and Ba 2015), their size, and the weights' penalty."""
ROUNDS, KEPT = 3, 0.4
"""The network is trained so often, at last on such a share of the cells of each picture with rust."""
CELLS_A_PICTURE = 400
LIMITS = (3, 6, 12, 25, 50, 100, 200)
"""Of touching cells that make a mark, from which the best one on the first half is chosen."""


def trained(features: np.ndarray, answers: np.ndarray, rng: np.random.Generator) -> Network:
    """Return the network that has learnt cells, (n, FEATURES), with answers, (n,) bool. Both count alike."""
    mean, deviation = features.mean(axis=0), features.std(axis=0) + 1e-6
    scaled = np.column_stack(((features - mean) / deviation, np.ones(len(features))))
    weights = np.where(answers, 0.5 / max(answers.sum(), 1), 0.5 / max((~answers).sum(), 1))
    parts = [rng.normal(0.0, 0.3, (FEATURES + 1, HIDDEN)), rng.normal(0.0, 0.3, HIDDEN + 1)]
    first, second = [np.zeros_like(each) for each in parts], [np.zeros_like(each) for each in parts]
    for step in range(1, STEPS + 1):
        inner = np.tanh(scaled @ parts[0])
        with_one = np.column_stack((inner, np.ones(len(inner))))
        wrong = (1.0 / (1.0 + np.exp(-(with_one @ parts[1]))) - answers) * weights
        back = wrong[:, None] * parts[1][:-1] * (1.0 - inner**2)
        for k, slope in enumerate((scaled.T @ back, with_one.T @ wrong)):
            slope = slope + DECAY * parts[k]
            first[k] = 0.9 * first[k] + 0.1 * slope
            second[k] = 0.999 * second[k] + 0.001 * slope**2
            size = RATE / (1.0 - 0.9**step)
            parts[k] = parts[k] - size * first[k] / (np.sqrt(second[k] / (1.0 - 0.999**step)) + 1e-8)
    return Network(mean, deviation, parts[0], parts[1])


def learnt(cells: Sequence[np.ndarray], answers: Sequence[bool], rng: np.random.Generator) -> Network:
    """Return the network that has learnt pictures: cells, (n, FEATURES) of each, with answers."""
    kept = list(cells)
    for left in range(ROUNDS - 1, -1, -1):
        of_cell = np.concatenate([np.full(len(each), answer) for each, answer in zip(kept, answers)])
        network = trained(np.concatenate(kept), of_cell, rng)
        share = KEPT ** (1.0 - left / ROUNDS)
        kept = [_likeliest(network, each, share) if answer else each for each, answer in zip(cells, answers)]
    return network


def _likeliest(network: Network, cells: np.ndarray, share: float) -> np.ndarray:
    """Return a share of a picture's cells, (n, FEATURES): those that are the likeliest to be rust."""
    likeliest: np.ndarray = cells[
        np.argsort(-network.probabilities(cells))[: max(1, int(share * len(cells)))]
    ]
    return likeliest


def right(network: Network, pictures: Sequence[tuple[np.ndarray, bool]]) -> tuple[int, int]:
    """Return how many pictures with rust have a mark, and how many without."""
    says = [(bool(network.marks(picture, "rust")), answer) for picture, answer in pictures]
    return sum(said for said, answer in says if answer), sum(said for said, answer in says if not answer)


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, choose, tell and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--photographs", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--truth", type=Path, required=True, metavar="FILE")
    parser.add_argument("--out", type=Path, default=Path("rust.npz"))
    parser.add_argument("--seed", type=int, default=80)
    given = parser.parse_args(arguments)
    try:
        found = with_answers(given.photographs, given.truth, "rust")
    except (SetError, OSError) as error:
        parser.exit(1, f"learn: {error}\n")
    halves = halves_of(found.answers, given.seed)
    parts: list[list[tuple[np.ndarray, bool]]] = [[], []]
    for path, picture in found.pictures():
        parts[path.name in halves.second].append((picture, found.answers[path]))
    rng = np.random.default_rng(given.seed)
    cells = [features_of(picture)[0].reshape(-1, FEATURES) for picture, _ in parts[0]]
    cells = [each[rng.permutation(len(each))[:CELLS_A_PICTURE]] for each in cells]
    network = learnt(cells, [answer for _, answer in parts[0]], rng)
    choices = [network._replace(least=least, cells=n) for least in (0.5, 0.6, 0.7, 0.8, 0.9) for n in LIMITS]
    true = sum(answer for _, answer in parts[0])
    told = [right(choice, parts[0]) for choice in choices]
    balance = [hit / max(true, 1) - wrong / max(len(parts[0]) - true, 1) for hit, wrong in told]
    best = choices[int(np.argmax(balance))]
    for name, part in zip(("first half, learnt", "second half"), parts):
        hit, wrong = right(best, part)
        true = sum(answer for _, answer in part)
        print(f"{name}: found {hit} of {true} with rust, false {wrong} of {len(part) - true}")
    best.save(given.out)
    print(f"written: {given.out} ({best.least:g}, {best.cells} cells)")


if __name__ == "__main__":
    main()
