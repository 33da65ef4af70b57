"""The request of a trial of Experiment 2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from cepa import CepaParameters
from flights.launch_arguments.common import choices_of, limits_of
from flights.worlds import placements, scenario
from master_thesis.experiment_2.description import TrialDescription
from master_thesis.experiment_2.trial import TrialParameters

LONGEST_LOOK_S = 8.0
"""After a longer silence MAVROS gives up the link."""


@dataclass(frozen=True)
class Trial:
    """A trial. limits: of its phases. look_s: wall time for which the proposals are shown."""

    description: TrialDescription
    limits: TrialParameters
    look_s: float


def read(asked: Mapping[str, Any], cepa: CepaParameters) -> Trial:
    """Read and check the request. asked: the node's parameters by name.

    Raises:
        FlightsError: one sentence.
    """
    name = scenario.choose("scenario", str(asked.get("scenario", "columns")), placements.SCENARIOS)
    world = scenario.absolute("world", str(asked.get("world", "")))
    description = TrialDescription(name, world=world, cepa=cepa, **choices_of(asked))
    look_s = scenario.number("look", asked.get("look_s", 0.0), 0.0, LONGEST_LOOK_S)
    return Trial(description, limits_of(asked, TrialParameters), look_s)
