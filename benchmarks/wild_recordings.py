"""Twelve recordings in the forms that other people's robots leave: are `identify` and `diagnose` at home in them?

    python benchmarks/wild_recordings.py [--diagnose] [--only NAME]

Each is a simulated drive of a known robot, written as its owner would have it (`tests/wild_forms.py`), and given to the
commands with one option at most. Printed: what was told of the robot, how many standard deviations from the truth, and
with `--diagnose` the verdict (a match is right: the robots are the base robot). About 3 minutes, with `--diagnose` 10.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

from typer.testing import CliRunner

from fsm_calib.cli import app

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from wild_forms import Form, all_forms

ALLOWED = 3.0  # standard deviations


def told(form: Form, command: str, out: Path) -> dict | None:
    """Return the JSON of a command on a form; None and a sentence where it failed."""
    ran = CliRunner().invoke(app, [command, *map(str, form.arguments), "--json", str(out)])
    if ran.exit_code:
        print(f"{form.name}: {command} ended with {ran.exit_code}: {ran.stderr.strip().splitlines()[-1:]}")
        return None
    return dict(json.loads(out.read_text()))


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--diagnose", action="store_true", help="also diagnose each")
    parser.add_argument("--only", default="", help="forms whose name holds this")
    options = parser.parse_args()
    good = numbers = within = 0
    with tempfile.TemporaryDirectory() as folder:
        forms = [form for form in all_forms(Path(folder) / "wild") if options.only in form.name]
        for form in forms:
            plain = told(form, "identify", Path(folder) / "result.json")
            off = []
            for name, true in form.truth.items():
                value = None if plain is None else plain[name]["value"]
                far = None if plain is None or value is None else abs(value - true) / plain[name]["sd"]
                off.append(
                    f"{name} {'-' if value is None else f'{value:.4g}'} ({'-' if far is None else f'{far:.1f}'})"
                )
                numbers, within = numbers + 1, within + (far is not None and far <= ALLOWED)
            verdict = None
            if options.diagnose:
                answer = told(form, "diagnose", Path(folder) / "result.json")
                verdict = None if answer is None else answer["verdict"]
            good += plain is not None and (verdict is not None or not options.diagnose)
            print(f"{form.name}: {', '.join(off)}{f'; {verdict}' if verdict else ''}", flush=True)
    print(f"{good} of {len(forms)} forms were read; {within} of {numbers} numbers within {ALLOWED:g} sd")


if __name__ == "__main__":
    main()
