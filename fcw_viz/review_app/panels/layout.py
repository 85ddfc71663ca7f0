"""The panel at the right of a tab, and the list of drives over the rest."""

from html import escape
from pathlib import Path

from fcw.charts.svg import css_color
from fcw.logs.overlay import LEVEL_COLORS
from fcw_viz.page.channel import enters, keeps_scroll, says, says_size
from fcw_viz.page.keys import help_table
from fcw_viz.page.panel import add_page_panel
from fcw_viz.page.style import STYLE, set_html, sheet_style, text_block
from fcw_viz.page.tab import PageTab
from fcw_viz.review_app.desk import NOTE_ID, Desk
from fcw_viz.review_app.drive import duration_text, utc_text
from fcw_viz.review_app.keys import HELP_ROWS, LIST_ROWS
from fcw_viz.review_app.panels.boxes import BOXES, BoxesPanel
from fcw_viz.review_app.panels.event import EventPanel
from fcw_viz.review_app.panels.folder_list import MORE_LISTED, MOST_LISTED, folder_html, legend_html
from fcw_viz.review_app.panels.map import map_html
from fcw_viz.review_app.panels.remarks import RemarksPanel
from fcw_viz.review_app.panels.take import TakePanel
from fcw_viz.review_app.panels.troubles import troubles_html
from fcw_viz.review_app.runs.panel import runs_html
from fcw_viz.review_app.session import ReviewSession
from fcw_viz.review_app.triage.drive_filter import DriveFilter, Listed
from fcw_viz.review_app.triage.filter_bar import Choices, filter_html, goes_on_html
from fcw_viz.review_app.words import moment_words

PANEL_WIDTH_PX = 350
FIRST_FOLDER_PX = 1040.0
NOTE_FIELD = (
    f'<input type="text" {enters(NOTE_ID, "note", key="t")} '
    'placeholder="Note on this moment (T); Enter saves it" autocomplete="off">'
)
SHEET_WIDEST_PX = 699
"""A window that is higher than wide has the panel below the strip, up to this width; a wider one, as
review_page.css has it, beside the strip."""
PAGE_STYLE = (
    f"{STYLE}{sheet_style(SHEET_WIDEST_PX)}"
    f"<style>{Path(__file__).with_name('review_page.css').read_text(encoding='utf-8')}</style>"
)


def first_list(session: ReviewSession, title: str, asked: DriveFilter) -> str:
    """The list of the drives as a tab has it at first, with all its styles."""
    cards, unfinished = session.cards, session.folder.unfinished
    listed = folder_html(title, cards, session.unread, FIRST_FOLDER_PX, asked, unfinished=unfinished)
    return (
        f"{PAGE_STYLE}{filter_html(asked, Choices.of(cards, unfinished), False)}"
        f'<div class="fcw-folder">{listed}</div>'
    )


class Panels:
    """All panels of a tab."""

    def __init__(self, tab: PageTab, desk: Desk, title: str, dark: bool) -> None:
        """Stand beside a desk.

        Args:
            tab: whose panels they are.
            desk: what they show and work on.
            title: of all drives together.
            dark: colours at the beginning.
        """
        gui, place = tab.client.gui, desk.place
        self._place, self._title, self._desk = place, title, desk
        self._folder_px = FIRST_FOLDER_PX
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_WIDTH_PX)
        gui.add_html(PAGE_STYLE)
        self._sizes = gui.add_html("")
        self._filter, self._folder = gui.add_html(""), gui.add_html("")
        self._choices: Choices | None = None
        self._shown_list: Listed | None = None
        self._most = MOST_LISTED
        self._moment = gui.add_html("")
        self._head = gui.add_html("")
        self._troubles = gui.add_html("")
        self._note = gui.add_html(text_block(NOTE_FIELD), visible=False)
        self._map = gui.add_html("")
        self._tabs = gui.add_tab_group(visible=False)
        with self._tabs.add_tab("Events"):
            self._events = EventPanel(gui, place, desk.annotating)
        with self._tabs.add_tab("Notes"):
            self._remarks = RemarksPanel(gui, place)
        with self._tabs.add_tab(BOXES):
            self._boxes = BoxesPanel(gui, tab.run, desk.boxes, desk.screen.switch_boxes)
        with self._tabs.add_tab("Plots"):
            self._plots = gui.add_html("")
        with self._tabs.add_tab("Runs"):
            self._runs = gui.add_html("")
        with self._tabs.add_tab("Export"):
            self._take = TakePanel(tab, place)
        with self._tabs.add_tab("Keys"):
            add_page_panel(gui, tab.run, HELP_ROWS, dark)

    def show(self) -> None:
        """Bring all of them to the place's drive, moment and reviews."""
        drive = self._place.drive
        aspect = 0.5625 if drive is None else drive.header.image_size.height / drive.header.image_size.width
        set_html(
            self._sizes,
            f"<style>:root {{ --fcw-docked: {PANEL_WIDTH_PX}px; --fcw-aspect: {aspect:.5f}; }}</style>",
        )
        self._tabs.visible = self._note.visible = drive is not None
        set_html(self._moment, self._moment_html())
        set_html(self._head, text_block(self._head_html()))
        troubles = () if drive is None else self._place.review.troubles
        set_html(self._troubles, text_block(troubles_html(troubles)) if troubles else "")
        set_html(self._map, "" if drive is None else map_html(drive, self._place.time_s))
        self._show_folder()
        if drive is not None:
            self._events.show()
            self._remarks.show()
            self._boxes.show()
            self._take.show()
            set_html(self._plots, text_block(self._place.plots.html()))
            runs = self._desk.runs
            listed = runs_html(
                runs, drive.name, runs.candidates(self._place.session.cards), drive.header.imperial
            )
            set_html(self._runs, text_block(listed))

    def show_more(self) -> None:
        """List more rows."""
        self._most += MORE_LISTED
        self._show_folder()

    def show_filter(self) -> None:
        """Draw the line over the list anew, as something else than typing has changed it."""
        self._choices = None
        self._show_folder()

    def resized(self, about: str) -> None:
        """The browser has told an element's size."""
        name, _, size = about.partition(" ")
        width = size.partition("x")[0]
        if name == "folder" and width.isdigit() and float(width) != self._folder_px:
            self._folder_px = float(width)
            self._show_folder()

    def _show_folder(self) -> None:
        if self._place.drive is not None:
            set_html(self._folder, "")
            set_html(self._filter, "")
            self._choices = None
            return
        session, asked = self._place.session, self._place.asked
        cards, unfinished = session.cards, session.folder.unfinished
        choices = Choices.of(cards, unfinished)
        if choices != self._choices or asked.listed is not self._shown_list:
            # Drawn anew only then: somebody may be typing in it.
            self._choices, self._shown_list = choices, asked.listed
            set_html(self._filter, filter_html(asked, choices, self._place.goes_on))
        html = folder_html(self._title, cards, session.unread, self._folder_px, asked, self._most, unfinished)
        set_html(
            self._folder,
            f'<div class="fcw-folder" {says_size("folder")} {keeps_scroll("folder")}>{html}</div>',
        )

    def _moment_html(self) -> str:
        """The warning of the moment, for windows in which nobody can read it on the picture."""
        result = self._desk.screen.result
        if self._place.drive is None or result is None:
            return ""
        words = moment_words(result.told_warning, self._place.drive.header.imperial)
        color = css_color(LEVEL_COLORS[result.warning.level])
        return text_block(f'<p class="fcw-moment" style="--level: {color}">{escape(words)}</p>')

    def _head_html(self) -> str:
        drive, session = self._place.drive, self._place.session
        who = f'<p class="dim">You review as <b>{escape(session.reviewer)}</b>.</p>'
        if drive is None:
            keys = f'<div class="fcw-legend">{help_table(LIST_ROWS)}</div>'
            return f'<div class="fcw-drive"><b>{escape(self._title)}</b></div>{who}{legend_html()}{keys}'
        header = drive.header
        back = (
            f'<button {says("list:")} title="All drives (L)">‹ All drives</button>'
            if session.folder.several
            else ""
        )
        off = "" if self._desk.annotating.last_drive else " disabled"
        torn = "" if drive.complete else " · not finished"
        date = "" if drive.zero_utc_ns is None else f"{utc_text(drive.zero_utc_ns, True)} · "
        return (
            f'<div class="fcw-drive"><b title="{escape(str(drive.log.path))}">'
            f"{escape(drive.name)}</b>"
            f"<span>{back}</span></div>"
            f'<div class="fcw-triage"><button {says("unjudged:")} title="Next unjudged event (U)">'
            f"Next unjudged</button>{goes_on_html(self._place.goes_on)}"
            f'<button {says("undo:")} title="Undo (Ctrl Z)"{off}>Undo</button></div>'
            f'<p class="dim">{date}{duration_text(drive.duration_s)} · {header.image_size} · '
            f"{escape(header.detector)}{torn} · reviewed as {escape(session.reviewer)}</p>"
        )
