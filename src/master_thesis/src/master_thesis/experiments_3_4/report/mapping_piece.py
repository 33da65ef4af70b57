"""What the pieces of Experiments 3 and 4 with and without GNSS share: worlds, lidars and seeds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable

from flights.flight.parameters import ClosedLoopParameters
from flights.mapping.mapping_flight import PACKAGE, SCENARIOS
from master_thesis.report.piece import Piece, fingerprint
from master_thesis.report.size import Size


def in_each_world(size: Size, piece: Callable[[Size, str, str, int], Piece]) -> list[Piece]:
    """Return a piece of each seed, world and lidar. piece: makes it of size, world, lidar and seed."""
    return [
        piece(size, world, lidar, seed)
        for seed in size.map_seeds
        for world in size.worlds
        for lidar in size.lidars
    ]


def mapping_piece(
    experiment: str,
    names: tuple[str, str],
    run: Callable[..., dict],
    given: dict[str, Any],
    parameters: ClosedLoopParameters,
    cost_s: float,
) -> Piece:
    """Return the piece of one flight.

    Args:
        experiment: the piece belongs to it.
        names: of the piece, and in its title, both without the seed.
        run: flies and returns the numbers.
        given: arguments of ``run``; world, lidar, seed and duration_s are among them.
        parameters: of the flight.
        cost_s: about how long it takes.
    """
    name, title = names
    world, seed, duration_s = given["world"], given["seed"], given["duration_s"]
    shorter = f"_{duration_s:g}s" if duration_s else ""
    return Piece(
        name=f"{name}_{seed}{shorter}",
        experiment=experiment,
        title=f"{title}, seed {seed}",
        run=run,
        given=given,
        inputs=fingerprint(
            parameters,
            world=SCENARIOS[world].world_path,
            slam=PACKAGE / "config" / f"gridslam_{world}.yaml",
        ),
        cost_s=cost_s,
        lidar=given["lidar"],
    )


def ended_after(parameters: ClosedLoopParameters, duration_s: float) -> ClosedLoopParameters:
    """Return the flight that ends after a time; 0: the whole mission."""
    return replace(parameters, duration_s=duration_s) if duration_s else parameters
