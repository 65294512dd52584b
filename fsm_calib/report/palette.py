"""Colours that the figures of all reports share."""

from __future__ import annotations

PHASE_COLOURS = {
    "focus": "#8c6bb1",
    "scan": "#2b7bba",
    "orientation": "#e08214",
    "wheels": "#2a9d5c",
    "exit": "#c2428a",
    "lane": "#b8860b",
    "between": "#9aa0a6",
    "failed": "#d73027",
    "aborted": "#d73027",
    "done": "#555555",
}
"""One colour for each phase, the same in every figure, told apart also without seeing red and green."""

BOARD_COLOURS = ("#2b7bba", "#e08214", "#2a9d5c", "#c2428a", "#8c6bb1", "#b8860b")
"""One colour for each board, in turn."""

BOARD_INKS = ("#226a9f", "#a35a06", "#1b7a43", "#b03a7c", "#75549c", "#80600a")
"""The same for words, dark enough to be read on a figure (4.5 : 1 and more on its light grey)."""

TEXT = "#555555"
"""Colour of the axes' labels."""

INK = "#333333"
"""Colour of titles, and of lines that belong to no phase."""

ALLOWED = "#2a9d5c"
"""Colour of what is true or within a limit."""

HEAT = (
    "#440154",
    "#482878",
    "#3e4a89",
    "#31688e",
    "#26828e",
    "#1f9e89",
    "#35b779",
    "#6dcd59",
    "#b4de2c",
    "#fde725",
)
"""Evenly spaced stops of the colour map viridis, low to high (S. van der Walt, N. Smith, 2015, CC0)."""

BEFORE, AFTER, MEASURED, FLOOR = "#d95f0e", "#2b7bba", "#222222", "#9aa0a6"
"""Colours of the base robot alone, of the robot with the effects, of what was measured, and of the noise floor."""
