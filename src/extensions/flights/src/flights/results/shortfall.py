"""What a run was asked for and did not do: a UAV that has landed well at home may have done nothing else."""

from __future__ import annotations

from typing import Any, Mapping

AS_ASKED = ("explored", "time")
"""Ends of an exploration. It is asked to explore for so long at most."""


def shortfall(content: Mapping[str, Any]) -> str:
    """Return what was asked and not done, in a sentence; empty: all was done.

    content: of result.json. An inspection is judged by its photographs, however its exploration ended.
    """
    if "inspection" in content:
        return _of_photographs(content["inspection"])
    return _of_exploration(content["exploration"]) if "exploration" in content else ""


def _of_exploration(told: Mapping[str, Any]) -> str:
    if told["end"] in AS_ASKED:
        return ""
    return f"The exploration ended before all was known ({told['end'] or 'no result'}): {told['reason']}"


def _of_photographs(told: Mapping[str, Any]) -> str:
    """Return what lacks: each photograph was asked, or the share of the surface that they were to show."""
    end, taken, asked = told["end"], told.get("taken", 0), told.get("asked", 0)
    if end != "done":
        return f"{taken} of {asked} photographs were taken ({end or 'no result'}): {told['reason']}"
    shown, wanted = told.get("coverage", {}).get("share_by_slam"), told.get("share_asked")
    if taken >= asked or (shown is not None and wanted is not None and shown >= wanted):
        return ""
    more = (
        ""
        if shown is None or wanted is None
        else (f", and they show {100.0 * shown:.1f} % of what {100.0 * wanted:g} % were asked of")
    )
    return f"{taken} of {asked} photographs were taken{more}. The reasons are in result.json under left_out."
