"""Judges by the scans whether the vehicle is where SLAM thinks it is: tracking, drifting, uncertain or lost.

All thresholds are shares, or lengths as shares of the scan's own ranges. So they hold for any lidar. See
doc/localisation.md for their margins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from gridslam.tracking.evidence import Evidence
from gridslam.tracking.self_check import SelfCheck

TRACKING, DRIFTING, UNCERTAIN, LOST = "tracking", "drifting", "uncertain", "lost"
STATES = (TRACKING, DRIFTING, UNCERTAIN, LOST)
CONTRADICTING_SHARE, AGREEING_SHARE, CONFIRMING_SHARE = 0.45, 0.5, 0.6
"""A scan contradicts the map if fewer of its beams agree than the first; after such a scan, the second; while
a given pose is not confirmed yet, the third.
"""
UNSEEN_WEIGHT = 0.5
"""Weight of a beam that ends in unseen space, against one that contradicts a map that should be known."""
BRIDGED_BLUR_M = 0.3
"""While mapping, a scan is refused only if odometry errs by less than this until the next one. Otherwise the
map would lose more by the gap than by the scan.
"""
LOST_AFTER = 3
"""Number of scans in a row that must contradict the map."""
MEMORY = 0.7
"""Weight of the scans before each new one in the smoothed share of beams that agree."""
LOST_BELOW, UNCERTAIN_BELOW, TRACKING_FROM = 0.5, 0.6, 0.7
"""Limits of the smoothed share."""
BRIDGED_AFTER = 2
"""Number of scans in a row that must agree with the map after a time without scans."""
BRIDGED_BY_MAP_SHARE = 0.5
"""If the map says something about fewer beams after a gap, odometry alone tells where the map goes on."""
BRIDGING = "scans were missing, and none has confirmed yet what odometry says of the way"
APART = "no place of the map before has been recognised yet"
SPREAD_UNCERTAIN, SPREAD_TRACKING = 0.75, 0.5
"""Limits of the particles' spread, as shares of the scan's typical range."""


@dataclass(frozen=True)
class MonitorState:
    """A `TrackingMonitor` to save. The fields are its attributes.

    Raises:
        ValueError: they make no sense.
    """

    state: str
    reason: str
    contradictions: int
    smoothed_share: float
    scans_since_tracking: int
    travelled_since_tracking_m: float
    is_confirming: bool
    agreed: int
    is_apart: bool
    is_bridging: bool
    self_check: SelfCheck

    def __post_init__(self) -> None:
        counts = (self.contradictions, self.scans_since_tracking, self.agreed)
        if self.state not in STATES or any(type(count) is not int or count < 0 for count in counts):
            raise ValueError("the state of tracking is none")
        if not (0.0 <= self.smoothed_share <= 1.0 and 0.0 <= self.travelled_since_tracking_m < math.inf):
            raise ValueError("the numbers of tracking make no sense")


class TrackingMonitor:
    """Follows the evidence of the scans.

    A scan that contradicts the map changes neither map nor pose. After LOST_AFTER of them in a row, or when
    few beams have agreed for a while, the vehicle is lost.

    Args:
        known_map: the map is given and stays as it is, so scans should not end in unseen space.
    """

    def __init__(self, known_map: bool = False) -> None:
        self._known_map = known_map
        self.state = TRACKING
        self.reason = "no scan has been judged yet"
        self.last: Evidence | None = None
        """The newest evidence."""
        self.contradictions = 0
        """Number of scans in a row that contradict the map."""
        self.smoothed_share = 1.0
        """Share of comparable beams that agree, over the last scans; 1 if the newest one was no witness."""
        self.scans_since_tracking = 0
        """Number of scans judged since the state was last tracking."""
        self.travelled_since_tracking_m = 0.0
        """Travel since then."""
        self.is_confirming = False
        """Whether the pose was given or found, and `confirm` was not called since."""
        self.agreed = 0
        """Number of scans in a row that agree with the map."""
        self.is_apart = False
        """Whether the map is not joined with an earlier one yet. So the place is not known there."""
        self.is_bridging = False
        """Whether odometry alone tells the newest part of the way, and no scans have confirmed it since."""
        self.self_check = SelfCheck()
        """What places found again, and odometry, say of the pose."""

    @property
    def is_on_the_map(self) -> bool:
        """Whether the scans agree with the map, which itself may have drifted."""
        return self.state in (TRACKING, DRIFTING)

    @property
    def is_lost(self) -> bool:
        """Whether the vehicle is lost."""
        return self.state == LOST

    def accepts(self, evidence: Evidence) -> bool:
        """Judge one scan. Return whether it may change the map and the pose."""
        self.last = evidence
        self.scans_since_tracking += 1
        self.travelled_since_tracking_m += evidence.travelled_m
        self.self_check = self.self_check.travelled(evidence.travelled_m)
        is_mapped = evidence.agreement.compared(1.0) > 0.0
        if self.is_bridging and is_mapped and evidence.agreement.compared_share < BRIDGED_BY_MAP_SHARE:
            self.self_check = self.self_check.bridged()
        is_witness = evidence.is_witness or self._known_map or self.is_confirming
        contradicts = is_witness and self._contradicts(evidence)
        self.contradictions = self.contradictions + 1 if contradicts else 0
        if not is_witness:
            self.smoothed_share = 1.0
        elif self._is_meaningful(evidence):
            self.smoothed_share += (1.0 - MEMORY) * (self.share_of(evidence) - self.smoothed_share)
        if self._is_meaningful(evidence):
            self.agreed = 0 if contradicts else self.agreed + 1
            self.is_bridging &= self.agreed < BRIDGED_AFTER
        self._decide(evidence)
        return not contradicts and not self.is_lost

    def doubt(self, reason: str) -> None:
        """Begin anew at a pose that was given or found: uncertain until `confirm` is called."""
        self.contradictions, self.agreed, self.smoothed_share = 0, 0, 1.0
        self.is_confirming = True
        self.self_check = self.self_check.begun_anew()
        self._enter(UNCERTAIN, reason)

    def bridge(self, reason: str) -> None:
        """Go on by odometry alone where scans lack: uncertain until scans agree. What is new is mapped."""
        was_bridging = self.is_bridging and self.state == UNCERTAIN
        self.is_bridging, self.agreed = True, 0
        if self.is_on_the_map or was_bridging:
            self._enter(UNCERTAIN, reason)

    def confirm(self) -> None:
        """Note that the pose is right."""
        self.is_confirming = False
        if self.is_apart:
            self._enter(UNCERTAIN, APART)
        else:
            self._enter_on_the_map("the pose on the map is confirmed")

    @property
    def _unseen_weight(self) -> float:
        """Until the pose on a map is confirmed, and for ever on a known map, unseen space counts, too."""
        return UNSEEN_WEIGHT if self._known_map or self.is_confirming else 0.0

    def share_of(self, evidence: Evidence) -> float:
        """Return the share of a scan's beams that agree."""
        return evidence.agreement.share(self._unseen_weight)

    def _is_meaningful(self, evidence: Evidence) -> bool:
        return evidence.agreement.is_meaningful(self._unseen_weight)

    def begin_apart(self, reason: str) -> None:
        """Go on with a new map, apart from the one on which the vehicle was not found: uncertain."""
        self.contradictions, self.agreed, self.smoothed_share = 0, 0, 1.0
        self.is_confirming, self.is_apart = False, True
        self._enter(UNCERTAIN, reason)

    def join(self) -> None:
        """Note that a place of the earlier map was recognised."""
        self.is_apart = False
        if not self.is_lost:
            self._enter_on_the_map("a place of the earlier map was recognised")

    def check(self, checked: SelfCheck) -> None:
        """Take over what closures and odometry say of the pose now."""
        before, self.self_check = self.self_check, checked
        is_its_doubt = self.state == UNCERTAIN and before.is_doubted and self.reason == before.reason
        if checked.is_doubted and (self.is_on_the_map or is_its_doubt):
            self._enter(UNCERTAIN, checked.reason)
        elif is_its_doubt or (self.is_on_the_map and checked.is_drifting != (self.state == DRIFTING)):
            self._enter_on_the_map("a place was recognised, and the pose is right there")

    def lose(self, reason: str) -> None:
        """Judge that the vehicle is lost, by something else than the share of beams."""
        self.is_confirming = False
        self._enter(LOST, reason)

    def _contradicts(self, evidence: Evidence) -> bool:
        limit = AGREEING_SHARE if self.contradictions else CONTRADICTING_SHARE
        if self.is_confirming:
            limit = CONFIRMING_SHARE
        if not self._can_refuse(evidence):
            return False
        return self._is_meaningful(evidence) and self.share_of(evidence) < limit

    def _can_refuse(self, evidence: Evidence) -> bool:
        return self._known_map or self.is_confirming or evidence.blur_m < BRIDGED_BLUR_M

    def _decide(self, evidence: Evidence) -> None:
        share = f"{100.0 * self.share_of(evidence):.0f} % of the beams agree with the map"
        was_tracking = self.is_on_the_map
        spread_limit = SPREAD_UNCERTAIN if was_tracking else SPREAD_TRACKING
        if self.contradictions >= LOST_AFTER:
            self.lose(f"{self.contradictions} scans in a row contradict the map: {share}")
        elif self.smoothed_share < LOST_BELOW and self._can_refuse(evidence):
            self.lose(f"few beams agree with the map: {100.0 * self.smoothed_share:.0f} %")
        elif self.contradictions:
            self._enter(UNCERTAIN, f"a scan contradicts the map: {share}")
        elif self.is_confirming:
            self._enter(UNCERTAIN, self.reason)
        elif self.is_apart:
            self._enter(UNCERTAIN, APART)
        elif self.is_bridging:
            self._enter(UNCERTAIN, BRIDGING)
        elif self.smoothed_share < (UNCERTAIN_BELOW if was_tracking else TRACKING_FROM):
            self._enter(UNCERTAIN, f"few beams agree with the map: {100.0 * self.smoothed_share:.0f} %")
        elif evidence.spread_m > spread_limit * evidence.typical_range_m > 0.0:
            self._enter(UNCERTAIN, f"the particles are spread over {evidence.spread_m:.2f} m")
        elif self.self_check.is_doubted:
            self._enter(UNCERTAIN, self.self_check.reason)
        else:
            self._enter_on_the_map(share)

    def _enter_on_the_map(self, reason: str) -> None:
        is_drifting = self.self_check.is_drifting
        self._enter(
            DRIFTING if is_drifting else TRACKING, self.self_check.reason_of_drift if is_drifting else reason
        )

    def _enter(self, state: str, reason: str) -> None:
        self.state, self.reason = state, reason
        if self.is_on_the_map:
            self.scans_since_tracking, self.travelled_since_tracking_m = 0, 0.0

    # Saved states

    def state_to_save(self) -> MonitorState:
        """Return all that was judged, without the newest evidence."""
        return MonitorState(*(getattr(self, field.name) for field in fields(MonitorState)))

    def restore(self, saved: MonitorState) -> None:
        """Go on from a state."""
        for field in fields(MonitorState):
            setattr(self, field.name, getattr(saved, field.name))
