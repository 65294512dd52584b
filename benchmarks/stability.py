"""Do disjoint pairs of a robot's recordings get answers that agree? No label is needed.

    python3 benchmarks/stability.py [--folder duckiebot-watchtower] [--first 4]

Two answers contradict where one says with more than 0.8 a name, or that one of a set is right, of which the other has
none, alone or in a set, though it names something with more than 0.8, too. What each says first with more than 0.8 is
counted apart: a second effect may be too faint in the other's drives. The recordings are not part of this repository
(FSM_CALIB_SHARED, default ../shared).
"""

from __future__ import annotations

import argparse
import itertools
import os
from collections import defaultdict
from pathlib import Path

SHARED = Path(os.environ.get("FSM_CALIB_SHARED", Path(__file__).parents[2] / "shared"))
SURE = 0.8


def pairs_of(folder: str) -> list[tuple[Path, Path]]:
    """Return disjoint pairs of recordings, those of one robot (the name up to the dash) together, in order."""
    robots: dict[str, list[Path]] = defaultdict(list)
    for path in sorted((SHARED / "recordings" / folder).glob("*.recording.yaml")):
        robots[path.name.split("-")[0] if "-" in path.name else ""].append(path)
    found = []
    for paths in robots.values():
        found += [(a, b) for a, b in itertools.pairwise(paths)][::2]
    return found


def contradicts(one: dict, other: dict, first: bool = False) -> bool:
    """Return whether an answer says surely, or says first and surely, what another sure answer leaves out."""
    sure, others = [[names for names, p in a["said"].items() if p > SURE] for a in (one, other)]
    left_out = [not other["names"].intersection(names) for names in (sure[:1] if first else sure)]
    left_out += [not one["names"].intersection(names) for names in (others[:1] if first else others)]
    return bool(sure and others) and any(left_out)


def main() -> None:
    """Print the answer of each pair, and how many contradict each other."""
    from fsm_calib.diagnosis.diagnose import diagnose
    from fsm_calib.recording import read_recording

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", default="duckiebot-watchtower")
    parser.add_argument("--first", type=int, default=99, help="so many pairs")
    arguments = parser.parse_args()
    answers = []
    for pair in pairs_of(arguments.folder)[: arguments.first]:
        verdict = diagnose([read_recording(str(path)) for path in pair]).verdict
        sets = {group[0]: tuple(group) for group in verdict.ambiguous}
        said = {sets.get(e.name, (e.name,)): e.confidence for e in verdict.effects}
        names = {name for group in said for name in group}
        answers.append({"pair": [p.name.split(".")[0] for p in pair], "said": said, "names": names})
        shown = ", ".join(f"{' or '.join(names)} {p:.2f}" for names, p in said.items()) or "-"
        print(f"{' + '.join(answers[-1]['pair'])}: {verdict.verdict}: {shown}", flush=True)
    robots = [a["pair"][0].split("-")[0] for a in answers]
    compared = [
        (a, b) for (a, r), (b, q) in itertools.combinations(zip(answers, robots, strict=True), 2) if r == q
    ]
    against, first = (sum(contradicts(a, b, only) for a, b in compared) for only in (False, True))
    print(
        f"{against} of {len(compared)} pairs of answers contradict each other, {first} in what they say first"
    )


if __name__ == "__main__":
    main()
