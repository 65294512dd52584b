"""The time line: which state was active when, one row for each state, grouped by phase."""

from __future__ import annotations

from fsm_calib.report.run_record import RunRecord
from fsm_calib.report.run_style import PHASE_COLOURS, TEXT, Margins, figure, svg

ROW = 0.17
"""Height of a row [inch]."""
LETTER = 0.066
"""Width of a letter of a state's name [inch], with the blanks around its slashes."""


def time_line(record: RunRecord) -> str:
    """Return the time line of states as SVG; states in the order in which they were first entered."""
    rows = list(dict.fromkeys(path for path, _, _ in record.spans))
    margins = Margins(left=0.2 + LETTER * max(map(len, rows)))
    with figure(9.0, 0.8 + ROW * max(len(rows), 3), margins) as fig:
        axes = fig.add_subplot()
        # x in axes, y in rows: a text is drawn in a tenth of a tick's time
        beside = axes.get_yaxis_transform()
        for number, path in enumerate(rows):
            colour = PHASE_COLOURS.get(path.split("/")[0], "#555555")
            stays = [(begin, max(end - begin, 0.05)) for where, begin, end in record.spans if where == path]
            axes.broken_barh(stays, (number - 0.36, 0.72), color=colour, linewidth=0)
            name = path.replace("/", " / ")
            axes.text(
                -0.007, number, name, transform=beside, ha="right", va="center", fontsize=7.5, color=TEXT
            )
        axes.set_yticks([])
        axes.set(xlim=(0.0, None), ylim=(len(rows) - 0.4, -0.6))
        axes.set_xlabel("robot time [s]")
        axes.grid(axis="x", color="#e3e3e3", linewidth=0.6)
        axes.set_axisbelow(True)
        return svg(fig, "Time line of states")
