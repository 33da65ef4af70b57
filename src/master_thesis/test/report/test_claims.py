"""The table of the thesis's claims: how a row is read, judged and put into words."""

from __future__ import annotations

import pytest

from flights.errors import ResultsError
from master_thesis.report.claims import judged, read_claims, threshold_of
from master_thesis.report.size import EXPERIMENTS

ROW = """
flights:
  - claim: "The UAV flies {speed:g} m/s."
    source: "8.1"
    holds_if: [error_m < 0.5, touched == 0]
    ours:
      - if: worst_m > 1
        say: "{error_m:.1f} m, at worst {worst_m:g} m."
      - say: "{error_m:.1f} m."
    remark: "Measured twice. "
    otherwise: "{touched} touched."
    rests_on: [seeds, flight]
"""


@pytest.fixture
def row(tmp_path):
    """Return the only claim of a table."""
    path = tmp_path / "claims.yaml"
    path.write_text(ROW)
    return read_claims(path)["flights"][0]


def test_a_claim_that_holds(row):
    finding = row.judged({"speed": 2.0, "error_m": 0.25, "touched": 0, "seeds": 3})
    assert (finding.claim, finding.source) == ("The UAV flies 2 m/s.", "8.1")
    assert (finding.agrees, finding.ours, finding.why) == (True, "0.2 m.", "Measured twice. ")
    assert finding.basis == ""


def test_a_claim_that_does_not_hold_says_why(row):
    finding = row.judged({"speed": 2.0, "error_m": 0.25, "touched": 1, "worst_m": 3.0, "seeds": 1})
    assert (finding.agrees, finding.why) == (False, "Measured twice. 1 touched.")
    assert finding.ours == "0.2 m, at worst 3 m."
    assert finding.basis == "one flight"


@pytest.mark.parametrize(("error_m", "agrees"), [(0.499, True), (0.5, False), (float("nan"), False)])
def test_the_threshold_itself_is_outside_of_less_than(row, error_m, agrees):
    assert row.judged({"speed": 1, "error_m": error_m, "touched": 0}).agrees is agrees


def test_a_claim_without_its_metrics_is_left_out(row):
    assert row.is_measured({"error_m": 0.1, "touched": 0})
    assert not row.is_measured({"error_m": 0.1})
    assert not row.is_measured({"error_m": None, "touched": 0})
    assert judged("experiment_1", {}) == []


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("error_m < 0.5", "error_m below 0.5", "'error_m below 0.5' is not METRIC RELATION THRESHOLD"),
        ("remark:", "remarks:", "remarks"),
        ("    holds_if: [error_m < 0.5, touched == 0]\n", "", "holds_if"),
    ],
)
def test_a_row_that_cannot_be_read_is_named(tmp_path, old, new, what):
    path = tmp_path / "claims.yaml"
    assert old in ROW
    path.write_text(ROW.replace(old, new))
    with pytest.raises(ResultsError, match=r"claims\.yaml: a claim of flights cannot be read") as error:
        read_claims(path)
    assert what in str(error.value)


def test_the_thesis_claims_belong_to_sections_and_say_why_not():
    table = read_claims()
    assert set(table) == set(EXPERIMENTS) - {"volume", "without_gnss", "exploration"}, (
        "the thesis has none of them"
    )
    assert all(claim.holds_if and claim.ours and claim.otherwise for rows in table.values() for claim in rows)
    last_cases = [claim.otherwise[-1] for rows in table.values() for claim in rows]
    assert not any(case.conditions for case in last_cases), "no verdict is without its reason"


def test_a_scan_at_40_hz_leaves_25_ms():
    assert threshold_of("experiment_1", "original_worst_p99_ms") == 1000.0 / 40.0
