"""The default warning policy: time to collision, required deceleration, and headway, with hysteresis."""

from collections.abc import Callable
from dataclasses import dataclass

from fcw.tracking.lead import is_oncoming
from fcw.tracking.types import Track
from fcw.units import distance_text, speed_text
from fcw.warning.driver import EXPECTED_DRIVER, SLOWEST_DRIVER, STANDARD_GRAVITY_MPS2, Driver
from fcw.warning.types import WarningLevel, WarningState

MPS_PER_KMH = 1 / 3.6

RULE_TTC = "ttc"
RULE_REQUIRED_DECELERATION = "required_deceleration"
RULE_HEADWAY = "headway"


@dataclass(frozen=True, slots=True, kw_only=True)
class TtcPolicySettings:
    """When each level is raised and how long it is held.

    Attributes:
        warning_driver: `warning` when this driver must brake now: 1.2 s and 0.4 g, the Euro NCAP driver
            model of the MathWorks forward-collision example; 0.4 g lies well inside the 0.68 g to which
            ISO 15623 limits the required deceleration at the warning.
        warning_ttc_s: `warning` below this time to collision: NHTSA's crash-avoidance tests ask for 2.4 s
            with a braking lead (2.1 s with a standing, 2.0 s with a slow one); 0.3 s more for the lag of
            the closing speed.
        caution_driver: `caution` when the slowest and gentlest driver of ISO 15623 must brake now: 2 s
            and 3.6 m/s^2.
        caution_ttc_s: `caution` below this: the 3.0 s within which Mobileye's aftermarket unit warns.
        minimum_closing_mps: the two TTC rules need this closing speed, the smallest relative speed
            ISO 15623 asks for; a slow approach has a short TTC for seconds without any danger, and the
            driver rules cover it.
        latest_ttc_s: nothing above this: ISO 15623 needs no warning there.
        minimum_age_s: a younger track raises neither `caution` nor `warning`: a closing speed from its
            first few boxes is mostly their noise, and every new track is a chance of a false alarm.
        closing_sigmas: a closing speed below so many of its sigmas raises neither: it may be noise.
        confidence_sigmas: `warning` is raised on the closing speed less so many sigmas. Far out, a pixel of
            noise in the width is metres per second of closing speed: the level that makes a driver brake
            must wait until the danger is likely; `caution` may go by the mean. A quarter, as more costs
            time that a driver lacks (with a half, 0.2 s and more) and less is no margin.
        headway_s: `advisory` when following closer than this: Mobileye's default 0.6 s.
        headway_on_mps: own speed from which `advisory` is raised: Mobileye, 40 km/h.
        headway_off_mps: own speed below which it ends: Mobileye, 30 km/h.
        release_factor: a raised level is held while its rule holds with thresholds wider by this.
        minimum_duration_s: and at least so long: shorter than a driver's expected reaction (0.75 s, Green
            2000) it could be gone before it is understood.
    """

    warning_driver: Driver = EXPECTED_DRIVER
    warning_ttc_s: float = 2.7
    caution_driver: Driver = SLOWEST_DRIVER
    caution_ttc_s: float = 3.0
    minimum_closing_mps: float = 4.2
    latest_ttc_s: float = 4.0
    minimum_age_s: float = 0.75
    closing_sigmas: float = 1.5
    confidence_sigmas: float = 0.25
    headway_s: float = 0.6
    headway_on_mps: float = 40 * MPS_PER_KMH
    headway_off_mps: float = 30 * MPS_PER_KMH
    release_factor: float = 1.25
    minimum_duration_s: float = 1.0


class TtcPolicy:
    """Raises a level at once when a rule of it holds, and lowers it late (see `TtcPolicySettings`).

    Oncoming vehicles and gaps that do not close never raise `caution` or `warning`.
    """

    name = "ttc"

    def __init__(self, settings: TtcPolicySettings | None = None) -> None:
        self._settings = settings or TtcPolicySettings()
        self._state = WarningState(WarningLevel.NONE)
        self._since_ns = 0
        self._time_ns: int | None = None

    def update(self, time_ns: int, lead: Track | None, ego_speed_mps: float | None) -> WarningState:
        """The state at `time_ns`.

        Args:
            time_ns: of the frame; must not decrease.
            lead: the lead vehicle, or None.
            ego_speed_mps: own speed; None when unknown, then there is no `advisory`.

        Raises:
            ValueError: `time_ns` is before the last one.
        """
        if self._time_ns is not None and time_ns < self._time_ns:
            raise ValueError(f"time went back from {self._time_ns} to {time_ns} ns")
        self._time_ns = time_ns
        if lead is not None and is_oncoming(lead, ego_speed_mps):
            lead = None
        shown = self._state.level
        level, rule = self._highest(lead, ego_speed_mps, shown)
        duration_s = (time_ns - self._since_ns) / 1e9
        if level < shown and duration_s < self._settings.minimum_duration_s:
            self._state = WarningState(shown, self._state.track_id, self._state.rule)
            if lead is not None and lead.track_id == self._state.track_id:
                self._state = _state(shown, self._state.rule, lead, ego_speed_mps)
            return self._state
        if level != shown:
            self._since_ns = time_ns
        self._state = (
            _state(level, rule, lead, ego_speed_mps)
            if lead is not None and level > WarningLevel.NONE
            else WarningState(WarningLevel.NONE)
        )
        return self._state

    def _highest(
        self, lead: Track | None, ego_speed_mps: float | None, shown: WarningLevel
    ) -> tuple[WarningLevel, str]:
        """The highest level a rule supports: levels up to the one shown with their wider thresholds."""
        rules: tuple[tuple[WarningLevel, Callable[[Track, float | None, bool], str]], ...] = (
            (WarningLevel.WARNING, self._warning_rule),
            (WarningLevel.CAUTION, self._caution_rule),
            (WarningLevel.ADVISORY, self._advisory_rule),
        )
        if lead is not None:
            for level, rule_of in rules:
                if rule := rule_of(lead, ego_speed_mps, level <= shown):
                    return level, rule
        return WarningLevel.NONE, ""

    def _warning_rule(self, lead: Track, _ego_speed_mps: float | None, holding: bool) -> str:
        settings = self._settings
        return self._closing_rule(
            lead, settings.warning_driver, settings.warning_ttc_s, settings.confidence_sigmas, holding
        )

    def _caution_rule(self, lead: Track, _ego_speed_mps: float | None, holding: bool) -> str:
        settings = self._settings
        return self._closing_rule(lead, settings.caution_driver, settings.caution_ttc_s, 0.0, holding)

    def _closing_rule(
        self, lead: Track, driver: Driver, ttc_limit_s: float, confidence_sigmas: float, holding: bool
    ) -> str:
        settings = self._settings
        distance_m, closing_mps, slack = lead.distance_m, lead.closing_speed_mps, settings.release_factor
        if not holding:
            slack = 1.0
            unsure = closing_mps < settings.closing_sigmas * lead.closing_speed_sigma_mps
            if unsure or lead.age_s < settings.minimum_age_s:
                return ""
            closing_mps -= confidence_sigmas * lead.closing_speed_sigma_mps
        if closing_mps <= 0 or distance_m > closing_mps * settings.latest_ttc_s * slack:
            return ""
        if distance_m <= driver.needed_distance_m(closing_mps) * slack:
            return RULE_REQUIRED_DECELERATION
        fast_enough = closing_mps * slack >= settings.minimum_closing_mps
        return RULE_TTC if fast_enough and distance_m <= closing_mps * ttc_limit_s * slack else ""

    def _advisory_rule(self, lead: Track, ego_speed_mps: float | None, holding: bool) -> str:
        settings = self._settings
        slack = settings.release_factor if holding else 1.0
        from_mps = settings.headway_off_mps if holding else settings.headway_on_mps
        if ego_speed_mps is None or ego_speed_mps < from_mps:
            return ""
        return RULE_HEADWAY if lead.distance_m <= ego_speed_mps * settings.headway_s * slack else ""


def required_deceleration_mps2(distance_m: float, closing_speed_mps: float) -> float | None:
    """Constant braking from now on that just avoids the collision: v^2 / (2 d); None when not closing.

    ISO 15623's required deceleration with a lead at constant speed and no system delay; inf at contact.
    """
    if closing_speed_mps <= 0:
        return None
    return closing_speed_mps**2 / (2 * distance_m) if distance_m > 0 else float("inf")


def describe(state: WarningState, track: Track | None, imperial: bool = False) -> str:
    """The warning and its reason in words, for logs and viewers.

    Args:
        state: the warning.
        track: the vehicle it is about, where it is still followed.
        imperial: feet and miles per hour.
    """
    if state.level == WarningLevel.NONE:
        return "no warning"
    words = {
        RULE_TTC: "short time to collision",
        RULE_REQUIRED_DECELERATION: "braking is due",
        RULE_HEADWAY: "following too closely",
    }
    text = f"{state.level.name.lower()}: {words.get(state.rule, state.rule)}"
    if track is None:
        return f"{text}; vehicle {state.track_id} is no longer seen"
    low, high = (distance_text(d, imperial) for d in (track.distance_low_m, track.distance_high_m))
    high = "unbounded" if high.startswith("inf") else high
    parts = [f"vehicle {track.track_id} at {distance_text(track.distance_m, imperial)} ({low} to {high})"]
    if state.ttc_s is not None:
        parts.append(f"closing at {speed_text(track.closing_speed_mps, imperial)}")
        parts.append(f"collision in {state.ttc_s:.1f} s")
    if state.required_deceleration_mps2 is not None:
        parts.append(f"needs {state.required_deceleration_mps2 / STANDARD_GRAVITY_MPS2:.2f} g")
    if state.headway_s is not None:
        parts.append(f"headway {state.headway_s:.1f} s")
    return f"{text}; {', '.join(parts)}"


def _state(level: WarningLevel, rule: str, lead: Track, ego_speed_mps: float | None) -> WarningState:
    return WarningState(
        level,
        lead.track_id,
        rule,
        lead.ttc_s,
        required_deceleration_mps2(lead.distance_m, lead.closing_speed_mps),
        lead.distance_m / ego_speed_mps if ego_speed_mps else None,
    )
