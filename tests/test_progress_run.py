"""The bar of a run says what it waits for before the first phase."""

import io

from rich.console import Console

from fsm_calib.progress.run import ProgressBar


def test_before_the_first_phase_compiling_is_named():
    seen = io.StringIO()
    with ProgressBar(["scan"], Console(file=seen, force_terminal=True, width=200)):
        pass
    assert "a first run compiles, too" in seen.getvalue()
