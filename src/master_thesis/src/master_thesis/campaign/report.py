"""What is written when a campaign is over: summary and pictures, and a table for the terminal."""

from __future__ import annotations

import pandas as pd

from master_thesis.campaign.campaign import Campaign
from master_thesis.campaign.statistics import RATES, summary
from master_thesis.campaign.store import CampaignFolder
from master_thesis.campaign.table import Table

_SHOWN = {
    "flight": ("collision_rate", "stuck_rate", "flight_time_s_mean", "time_over_straight_mean"),
    "mapping": ("mapped_rate", "ate_rmse_m_mean", "map_error_p95_m_mean", "wall_seen_share_mean"),
}
_ROWS_MAX = 60


def write_report(campaign: Campaign, folder: CampaignFolder, table: Table) -> str:
    """Write summary.csv and the pictures of a campaign's table; return the headlines as text."""
    from master_thesis.campaign.figures import pictures  # matplotlib takes a second

    trials = table.to_pandas()
    if not len(trials):
        return "No trial has finished yet."
    found = summary(campaign, trials)
    folder.write("summary.csv", found.to_csv(index=False, float_format="%.9g").encode())
    for name, content in pictures(campaign, trials).items():
        folder.write(name, content)
    errors = trials["error"].dropna()
    said = (
        [f"{len(errors)} of {len(trials)} trials failed, the first: {errors.iloc[0]}"] if len(errors) else []
    )
    return "\n".join([_headlines(campaign, found), *said])


def _headlines(campaign: Campaign, found: pd.DataFrame) -> str:
    names = [*campaign.varied, "trials", *_SHOWN[campaign.kind]]
    shown = found[names].head(_ROWS_MAX).copy()
    for name in (f"{rate}_rate" for rate in RATES[campaign.kind]):
        if name in shown:
            low, high = found[f"{name}_low"], found[f"{name}_high"]
            shown[name] = [f"{a:.0%} ({b:.0%}-{c:.0%})" for a, b, c in zip(found[name], low, high)][
                : len(shown)
            ]
    text = shown.to_string(index=False, float_format=lambda value: f"{value:.3g}", na_rep="-")
    hidden = len(found) - len(shown)
    return f"{text}\n... and {hidden} more in summary.csv" if hidden else text
