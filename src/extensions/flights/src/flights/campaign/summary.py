"""What is written when a campaign is over: summary and pictures, and a table for the terminal."""

from __future__ import annotations

import pandas as pd

from flights.campaign.campaign import Campaign
from flights.campaign.folder import CampaignFolder, Flown
from flights.campaign.statistics import RATES, summary

_SHOWN = {
    "flight": ("collision_rate", "stuck_rate", "flight_time_s_mean", "time_over_straight_mean"),
    "mapping": ("mapped_rate", "ate_rmse_m_mean", "map_error_p95_m_mean", "wall_seen_share_mean"),
}
_ROWS_MAX = 60


def write_summary(campaign: Campaign, folder: CampaignFolder, flown: Flown) -> str:
    """Write summary.csv and the pictures of what was flown; return the headlines as text."""
    from flights.campaign.pictures import pictures  # matplotlib takes a second

    if not len(flown.trials):
        return "No trial has finished yet."
    found = summary(campaign, flown.trials)
    folder.write("summary.csv", found.to_csv(index=False, float_format="%.9g"))
    for name, content in pictures(campaign, flown.trials).items():
        folder.write(name, content)
    return "\n".join([_headlines(campaign, found), *([flown.mixture] if flown.mixture else [])])


def _headlines(campaign: Campaign, found: pd.DataFrame) -> str:
    names = [*campaign.varied, "trials", *_SHOWN[campaign.kind]]
    shown = found[names].head(_ROWS_MAX).copy()
    for name in (f"{rate}_rate" for rate in RATES[campaign.kind]):
        if name in shown:
            bounds = zip(found[name], found[f"{name}_low"], found[f"{name}_high"])
            shown[name] = [f"{a:.0%} ({b:.0%}-{c:.0%})" for a, b, c in bounds][: len(shown)]
    text = shown.to_string(index=False, float_format=lambda value: f"{value:.3g}", na_rep="-")
    hidden = len(found) - len(shown)
    return f"{text}\n... and {hidden} more in summary.csv" if hidden else text
