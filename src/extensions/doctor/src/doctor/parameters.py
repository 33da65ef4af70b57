"""Checks parameters against their nodes' dynamic_reconfigure descriptions."""

from __future__ import annotations

import math
from typing import Iterator, Sequence

from doctor.diagnosis import ERROR, WARNING, Diagnosis
from doctor.snapshot import Parameter


def check(parameters: Sequence[Parameter]) -> Iterator[Diagnosis]:
    """Yield all diagnoses about parameters."""
    for parameter in parameters:
        yield from one(parameter)


def one(parameter: Parameter) -> Iterator[Diagnosis]:
    """Check a parameter: its type, its range, and whether server and node agree."""
    where = f"{parameter.node}/{parameter.name}"
    span = f"{parameter.minimum:g} to {parameter.maximum:g}"
    remedy = f"rosrun node_tools set_parameter {parameter.node} {parameter.name} VALUE"
    text = parameter.text_on_server
    if text is not None and text not in parameter.choices:
        takes = " or ".join(parameter.choices) or f"a number from {span}"
        yield Diagnosis(ERROR, where, f'is "{text}" on the parameter server, and must be {takes}', remedy)
        return
    for place, value in (("on the parameter server", parameter.on_server), ("in the node", parameter.in_use)):
        if value is not None and not parameter.minimum <= value <= parameter.maximum:
            yield Diagnosis(ERROR, where, f"is {value:g} {place}, out of {span}", remedy)
            return
    served, in_use = parameter.on_server, parameter.in_use
    if served is None or in_use is None:
        return
    if not math.isclose(served, in_use, rel_tol=1e-6, abs_tol=1e-9):
        what = f"the node uses {in_use:g}, and the parameter server says {served:g}"
        yield Diagnosis(WARNING, where, f"{what}: rosparam set does not reach a running node", remedy)
