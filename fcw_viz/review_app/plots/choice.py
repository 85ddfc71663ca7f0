"""Which curves somebody has chosen, and what they choose from."""

from collections.abc import Callable, Mapping
from html import escape

from fcw.errors import UserError
from fcw_viz.page.channel import chooses, is_place, says
from fcw_viz.review_app.plots.signals import (
    AHEAD,
    DEFAULT,
    MOST_PLOTS,
    OWN,
    Chosen,
    chosen_text,
    parse_chosen,
    signals_of,
)

PLACE = "plots"
"""Of the list, on the page."""
SUBJECT_NAMES = {AHEAD: "Vehicle ahead (the one warned of, or the lead)", OWN: "This drive"}


class PlotChoice:
    """The curves of one tab.

    Attributes:
        chosen: what is drawn, in the order in which it was chosen.
        subject: of which signals are listed.
        vehicles: numbers of the vehicles of the frame that is shown, the nearest first.
    """

    def __init__(self) -> None:
        self.chosen: tuple[Chosen, ...] = DEFAULT
        self.subject = AHEAD
        self.vehicles: tuple[int, ...] = ()

    def switch(self, text: str) -> None:
        """Draw a curve, or do not any more.

        Args:
            text: its name, see `parse_chosen`.

        Raises:
            UserError: there are as many plots as can be read.
        """
        for one in parse_chosen(text):
            if one in self.chosen:
                self.chosen = tuple(other for other in self.chosen if other != one)
                continue
            signals = {other.signal for other in self.chosen}
            if one.signal not in signals and len(signals) >= MOST_PLOTS:
                raise UserError(f"at most {MOST_PLOTS} plots fit: remove one first")
            self.chosen = (*self.chosen, one)

    def take_all(self, text: str) -> None:
        """Draw these curves, as they were chosen before."""
        self.chosen = parse_chosen(text)

    def kept_text(self) -> str:
        """What of it can be kept for other drives: vehicles have other numbers there."""
        return chosen_text([one for one in self.chosen if one.subject in (AHEAD, OWN)])

    def leave_drive(self) -> None:
        """Another drive has other vehicles."""
        self.chosen = tuple(one for one in self.chosen if one.subject in (AHEAD, OWN))
        self.subject = self.subject if self.subject == OWN else AHEAD
        self.vehicles = ()

    def choose_subject(self, subject: str) -> None:
        """List the signals of something else."""
        if subject in (AHEAD, OWN) or subject.isdigit():
            self.subject = subject

    def html(self) -> str:
        """The list: a click on a signal is `plot:<its name>`."""
        drawn = [int(one.subject) for one in self.chosen if one.subject.isdigit()]
        mine = [int(self.subject)] if self.subject.isdigit() else []
        numbers = dict.fromkeys([*self.vehicles, *mine, *sorted(drawn)])
        names = SUBJECT_NAMES | {str(number): f"Vehicle #{number}" for number in numbers}
        options = "".join(
            f'<option value="{subject}"{" selected" * (subject == self.subject)}>{escape(name)}</option>'
            for subject, name in names.items()
        )
        rows = []
        for signal in signals_of(self.subject):
            one = Chosen(signal.key, self.subject)
            unit = f" <small>{escape(signal.quantity.unit)}</small>" if signal.quantity.unit else ""
            on = one in self.chosen
            rows.append(
                f'<button class="{"on" if on else ""}" role="checkbox" aria-checked="{str(on).lower()}" '
                f"{says(f'plot:{chosen_text([one])}')}>{escape(signal.title)}{unit}</button>"
            )
        default = f"<button {says('plotsdefault:')}>Default plots</button>"
        return (
            f'<div {is_place(PLACE)}><select {chooses("subject")} title="Signals of">{options}</select></div>'
            f'<div class="fcw-signals">{"".join(rows)}</div><p>{default}</p>'
        )

    def messages(self, changed: Callable[[], object]) -> Mapping[str, Callable[[str], object]]:
        """What the page says of it, and what is done then.

        Args:
            changed: draws it.
        """

        def then(work: Callable[[str], object]) -> Callable[[str], object]:
            def do(about: str) -> None:
                work(about)
                changed()

            return do

        return {
            "plot": then(self.switch),
            "plots": then(self.take_all),
            "plotsdefault": then(lambda _: self.take_all(chosen_text(DEFAULT))),
            "subject": then(self.choose_subject),
        }
