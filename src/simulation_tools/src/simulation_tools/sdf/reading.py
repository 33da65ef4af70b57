"""What every reader of a description is given: where files are, and what becomes of a part that is bad."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Sequence

from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.safe_xml import SdfError

Include = Callable[[Node, bool], Model | None]
"""Follows an ``<include>`` inside a model that is static, or not; None for a light."""


@dataclass
class Omissions:
    """The bad parts of one request. is_lenient: they are left out and noted, as Gazebo does; else refused."""

    is_lenient: bool
    sentences: list[str] = field(default_factory=list)

    def leave_out(self, what: str, error: SdfError) -> None:
        """Note that a part is left out, or raise the error. what: a name for it, ``The model "m"``."""
        if not self.is_lenient:
            raise error
        self.sentences.append(f"{what} is left out: {error}")


@dataclass(frozen=True)
class Reading:
    """One request. model_path: folders of models. include: follows an ``<include>``."""

    model_path: Sequence[Path]
    include: Include
    omissions: Omissions
