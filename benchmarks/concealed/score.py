"""The table, the confusion matrix and every failure, from sealed verdicts and the opened key."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from statistics import median
from typing import Any

from concealed.truth import Compared, compared, distance, strength_error

LEVELS = ("plain", "masked", "faint", "below")
NEAR = 0.05  # m: bar of a place
SOON = 0.5  # s: bar of an onset

Pair = tuple[dict[str, Any], dict[str, Any]]
Row = tuple[str, str, str]


def first_names(verdict: dict) -> set[str]:
    """The name said first, or the set it cannot be told apart from."""
    if verdict["verdict"] != "explained" or not verdict["effects"]:
        return set()
    name = verdict["effects"][0]["name"]
    return {name}.union(*[set(group) for group in verdict.get("ambiguous", []) if name in group])


def is_right(label: str, verdict: dict, encoders: bool) -> bool:
    """True when the first name is the label; the two delays count as one set where nothing can tell them apart."""
    names = first_names(verdict)
    if label in ("command_delay", "observation_delay") and not encoders:
        return bool(names & {"command_delay", "observation_delay"})
    return label in names


def right(pair: Pair) -> bool:
    """True when a pair of key line and verdict has the right name first."""
    return is_right(pair[0]["label"], pair[1], pair[0]["encoders"])


def wrong(pair: Pair) -> bool:
    """True when a pair of key line and verdict has a name first that is not right."""
    return bool(first_names(pair[1])) and not right(pair)


def right_first(pair: Pair) -> bool:
    """True when the first name is one of those that the robot hides: each name of a pair counts."""
    return any(is_right(label, pair[1], pair[0]["encoders"]) for label in pair[0]["label"].split("+"))


def share(hits: int, total: int) -> str:
    """A share in percent with its counts."""
    return f"{100 * hits / total:.1f} % ({hits}/{total})" if total else "-"


def share_of(test: Callable[[Any], bool], items: Iterable[Any]) -> str:
    """The share of the items that pass a test."""
    passed = [bool(test(item)) for item in items]
    return share(sum(passed), len(passed))


def load(folder: Path, key: list[dict]) -> list[Pair]:
    """Pairs of key line and verdict, for those robots that have one."""
    return [(k, json.loads(p.read_text())) for k in key if (p := folder / f"{k['name']}.json").exists()]


def is_single(line: dict) -> bool:
    """True for a robot with one effect of the catalogue that was driven well enough to tell."""
    return line["label"] != "none" and not {"+", ":"} & set(line["label"]) and not line["poor"]


def is_left_out(pair: Pair) -> bool:
    """True for a run without the true effect of a robot that was driven well enough to tell."""
    line, verdict = pair
    return (
        is_single(line)
        and line["level"] != "faint"
        and line["label"] in verdict.get("without", [line["label"]])
    )


def name_rows(single: list[Pair]) -> Iterator[Row]:
    """Who was named right, wrong or not at all, by level."""
    larger = [pair for pair in single if pair[0]["level"] in ("plain", "masked")]
    yield "right name first, plain and masked", share_of(right, larger), ">= 97 %"
    for level in LEVELS:
        group = [pair for pair in single if pair[0]["level"] == level]
        if not group:
            continue
        said = Counter(v["verdict"] for _, v in group)
        bar = {"faint": ">= 80 %", "below": ""}.get(level, ">= 97 %")
        yield f"right name first, {level}", share_of(right, group), bar
        yield f"wrong name, {level}", share_of(wrong, group), ""
        yield f"unexplained / match, {level}", f"{said['unexplained']} / {said['match']}", ""


def control_rows(pairs: list[Pair], single: list[Pair]) -> Iterator[Row]:
    """Clean robots, physics outside the catalogue, two effects, poor drives."""
    clean = [v for k, v in pairs if k["label"] == "none"]
    outside = [v for k, v in pairs if k["label"].startswith("x:")]
    unexplained = lambda v: v["verdict"] == "unexplained"  # noqa: E731
    yield "false name on clean robots", share_of(first_names, clean), "<= 1 %"
    yield "clean robots called unexplained", share_of(unexplained, clean), ""
    yield "unexplained for outside physics", share_of(unexplained, outside), ">= 90 %"
    yield "a name for outside physics", share_of(first_names, outside), ""
    both = [(k, {e["name"] for e in v["effects"]} | first_names(v)) for k, v in pairs if "+" in k["label"]]
    held = share_of(lambda pair: set(pair[0]["label"].split("+")) <= pair[1], both)
    yield "both names of a pair", held, ">= 85 %"
    named = [v for k, v in single if right((k, v))]
    yield "spurious second name", share_of(lambda v: len(v["effects"]) > 1, named), "<= 3 %"
    poor = [(k, v) for k, v in pairs if k["poor"]]
    yield "poor excitation: one name", share_of(lambda pair: len(first_names(pair[1])) == 1, poor), ""
    yield "poor excitation: a wrong name", share_of(wrong, poor), "none"


def proof_rows(pairs: list[Pair]) -> Iterator[Row]:
    """Errors on the drive that was not fitted, over the floor, where the name is right."""
    named = [v for k, v in pairs if k["label"] != "none" and right((k, v))]
    for channel, bar in (("xy_m", "<= 1.03"), ("theta_rad", "<= 1.08")):
        errors = [_errors(verdict, channel) for verdict in named]
        ratios = [after / floor for after, floor in errors if after and floor]
        found = f"{median(ratios):.3f} (n {len(ratios)})" if ratios else "-"
        yield f"held-out after / floor, {channel}", found, bar


def _errors(verdict: dict, channel: str) -> tuple[float | None, float | None]:
    holdout = (verdict.get("fit") or {}).get("holdout") or {}
    after, floor = ((holdout.get(part) or {}).get(channel) for part in ("after", "floor"))
    return after, floor


def number_rows(single: list[Pair]) -> Iterator[Row]:
    """Strengths, intervals, places and moments where the name is right and the two laws have the number in common."""
    found = [(k["label"], numbers_of((k, v))) for k, v in single if right((k, v))]
    errors = [(label, error) for label, items in found if (error := strength_error(items)) is not None]
    if errors:
        middle = median(error for _, error in errors)
        yield "parameter error, median", f"{100 * middle:.1f} % (n {len(errors)})", "<= 8 %"
        by_effect = {name: [e for label, e in errors if label == name] for name, _ in errors}
        worst = max(by_effect, key=lambda name: median(by_effect[name]))
        text = f"{100 * median(by_effect[worst]):.1f} % ({worst}, n {len(by_effect[worst])})"
        yield "parameter error, worst effect's median", text, "<= 25 %"
        off = [name for name, values in by_effect.items() if median(values) > 0.25]
        yield "effects off by more than 25 % in the median", ", ".join(sorted(off)) or "none", "none"
    held = [item.held for _, items in found for item in items if item.held is not None]
    yield "90 % intervals that hold the truth", share(sum(held), len(held)), "85 to 95 %"
    yield _missed("place", [distance(items, "place") for _, items in found], NEAR, "m")
    yield _missed("onset", [distance(items, "time") for _, items in found], SOON, "s")


def numbers_of(pair: Pair) -> list[Compared]:
    """The numbers of the first effect that key and verdict have in common."""
    line, verdict = pair
    wanted = {line["label"], "command_delay", "observation_delay"}
    effect = next((e for e in verdict["effects"] if e["name"] in wanted), None)
    return [] if effect is None else compared(line, effect)


def _missed(what: str, misses: list[float | None], bar: float, unit: str) -> Row:
    known = [miss for miss in misses if miss is not None]
    text = f", median {median(known):.3f} {unit}" if known else ""
    within = share_of(lambda miss: miss <= bar, known) + text
    return f"{what} within {bar:g} {unit}", within, "all"


def confidence_rows(pairs: list[Pair]) -> Iterator[Row]:
    """Stated confidence of first names beside the share that is right."""
    named = [pair for pair in pairs if first_names(pair[1])]
    if named:
        stated = sum(v["effects"][0].get("confidence") or 0.0 for _, v in named) / len(named)
        held = sum(map(right_first, named)) / len(named)
        yield "stated confidence, mean / share right", f"{stated:.3f} / {held:.3f}", "within 0.05"


def time_rows(pairs: list[Pair]) -> Iterator[Row]:
    """Seconds a robot, by what was recorded."""
    for encoders, bar in ((False, "15"), (True, "30")):
        seconds = [v.get("seconds") or 0.0 for k, v in pairs if k["encoders"] is encoders]
        text = f"{median(seconds):.1f} / {max(seconds):.1f} (n {len(seconds)})" if seconds else "-"
        yield f"seconds {'with' if encoders else 'without'} encoders, median / max", text, bar


def effect_rows(single: list[Pair]) -> Iterator[str]:
    """One line an effect: how many, how many right, and how far its numbers are off in the median."""
    for label in sorted({k["label"] for k, _ in single}):
        group = [pair for pair in single if pair[0]["label"] == label]
        named = [numbers_of(pair) for pair in group if right(pair)]
        errors = [e for items in named if (e := strength_error(items)) is not None]
        held = [item.held for items in named for item in items if item.held is not None]
        error = f"{100 * median(errors):.0f} %" if errors else "-"
        yield f"| {label} | {share_of(right, group)} | {error} | {share(sum(held), len(held))} |"


def failures(pairs: list[Pair]) -> Iterator[str]:
    """Every robot that was called something else than it is."""
    for line, verdict in pairs:
        said = f"{verdict['verdict']} {[e['name'] for e in verdict['effects']]}"
        if is_single(line) and not right((line, verdict)):
            eyes = ", encoders" if line["encoders"] else ""
            rivals = [r["name"] for r in (verdict.get("rivals") or [])[:3]]
            size = f"{line['level']}, {line['ratio']:.2f} x floor{eyes}"
            yield f"- {line['name']}: {line['label']} ({size}): {said} rivals {rivals}"
    for line, verdict in pairs:
        if (line["label"] == "none" or ":" in line["label"]) and first_names(verdict):
            yield f"- {line['name']}: {line['label']}: {verdict['verdict']} {[e['name'] for e in verdict['effects']]}"


def report(out: Path, key: list[dict]) -> str:
    """Markdown: figures, effects, confusions, failures."""
    pairs = load(out / "verdicts", key)
    single = [(k, v) for k, v in pairs if is_single(k)]
    rows = [*name_rows(single), *control_rows(pairs, single), *proof_rows(pairs), *number_rows(single)]
    rows += [*confidence_rows(pairs)]
    if without := list(filter(is_left_out, load(out / "verdicts-without", key))):
        named = share_of(lambda pair: bool(first_names(pair[1])), without)
        rows.append(("leave-one-out: a confident wrong name", named, "<= 8 %"))
    rows += [*time_rows(pairs)]
    lines = ["| figure | measured | bar |", "|---|---|---|", *(f"| {a} | {b} | {c} |" for a, b, c in rows)]
    lines += ["", "## Effect by effect", "", "| effect | right name | error, median | intervals that hold |"]
    lines += ["|---|---|---|---|", *effect_rows(single), "", "## Who was called what", ""]
    said = lambda v: v["effects"][0]["name"] if first_names(v) else v["verdict"]  # noqa: E731
    confusion = Counter((k["label"], said(v)) for k, v in pairs)
    lines += ["| truth | said | robots |", "|---|---|---|"]
    lines += [f"| {a} | {b} | {n} |" for (a, b), n in sorted(confusion.items())]
    return "\n".join([*lines, "", "## Failures", "", *failures(pairs)]) + "\n"
