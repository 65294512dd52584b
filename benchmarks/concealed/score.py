"""The table, the confusion matrix and every failure, from sealed verdicts and the opened key."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from statistics import median

LEVELS = ("plain", "masked", "faint", "below")


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


def share(hits: int, total: int) -> str:
    """A share in percent with its counts."""
    return f"{100 * hits / total:.1f} % ({hits}/{total})" if total else "-"


def load(folder: Path, key: list[dict]) -> list[tuple[dict, dict]]:
    """Pairs of key line and verdict, for those robots that have one."""
    return [(k, json.loads(p.read_text())) for k in key if (p := folder / f"{k['name']}.json").exists()]


def _fit_ratios(pairs: list, channel: str) -> list[float]:
    out = []
    for k, v in pairs:
        holdout = (v.get("fit") or {}).get("holdout") or {}
        after, floor = holdout.get("after") or {}, holdout.get("floor") or {}
        if (
            k["label"] != "none"
            and after.get(channel)
            and floor.get(channel)
            and is_right(k["label"], v, k["encoders"])
        ):
            out.append(after[channel] / floor[channel])
    return out


def report(out: Path, key: list[dict]) -> str:
    """Markdown: figures, confusions, failures."""
    pairs = load(out / "verdicts", key)
    single = [
        (k, v)
        for k, v in pairs
        if k["label"] != "none" and "+" not in k["label"] and ":" not in k["label"] and not k["poor"]
    ]
    rows: list[tuple[str, str, str]] = []
    for level in LEVELS:
        group = [(k, v) for k, v in single if k["level"] == level]
        right = sum(is_right(k["label"], v, k["encoders"]) for k, v in group)
        wrong = sum(bool(first_names(v)) and not is_right(k["label"], v, k["encoders"]) for k, v in group)
        rows.append(
            (
                f"right name first, {level}",
                share(right, len(group)),
                {"faint": ">= 80 %", "below": ""}.get(level, ">= 97 %"),
            )
        )
        rows.append((f"wrong name, {level}", share(wrong, len(group)), ""))
        rows.append(
            (
                f"unexplained / match, {level}",
                f"{sum(v['verdict'] == 'unexplained' for _, v in group)} / {sum(v['verdict'] == 'match' for _, v in group)}",
                "",
            )
        )
    clean = [v for k, v in pairs if k["label"] == "none"]
    rows.append(
        ("false name on clean robots", share(sum(bool(first_names(v)) for v in clean), len(clean)), "<= 1 %")
    )
    rows.append(
        (
            "clean robots called unexplained",
            share(sum(v["verdict"] == "unexplained" for v in clean), len(clean)),
            "",
        )
    )
    outside = [v for k, v in pairs if k["label"].startswith("x:")]
    rows.append(
        (
            "unexplained for outside physics",
            share(sum(v["verdict"] == "unexplained" for v in outside), len(outside)),
            ">= 90 %",
        )
    )
    rows.append(
        ("a name for outside physics", share(sum(bool(first_names(v)) for v in outside), len(outside)), "")
    )
    both = [(k, {e["name"] for e in v["effects"]} | first_names(v)) for k, v in pairs if "+" in k["label"]]
    rows.append(
        (
            "both names of a pair",
            share(sum(set(k["label"].split("+")) <= names for k, names in both), len(both)),
            ">= 85 %",
        )
    )
    right = [(k, v) for k, v in single if is_right(k["label"], v, k["encoders"])]
    rows.append(
        ("spurious second name", share(sum(len(v["effects"]) > 1 for _, v in right), len(right)), "<= 3 %")
    )
    for channel, bar in (("xy_m", "<= 1.03"), ("theta_rad", "<= 1.08")):
        ratios = _fit_ratios(pairs, channel)
        rows.append(
            (
                f"held-out after / floor, {channel}",
                f"{median(ratios):.3f} (n {len(ratios)})" if ratios else "-",
                bar,
            )
        )
    poor = [v for k, v in pairs if k["poor"]]
    rows.append(
        (
            "poor excitation: one confident name",
            share(sum(len(first_names(v)) == 1 for v in poor), len(poor)),
            "none",
        )
    )
    named = [
        (max((e.get("confidence") or 0.0) for e in v["effects"][:1]), is_right(k["label"], v, k["encoders"]))
        for k, v in pairs
        if first_names(v)
    ]
    if named:
        rows.append(
            (
                "stated confidence, mean / share right",
                f"{sum(c for c, _ in named) / len(named):.3f} / {sum(r for _, r in named) / len(named):.3f}",
                "within 0.05",
            )
        )
    without = load(out / "verdicts-without", key)
    if without:
        rows.append(
            (
                "leave-one-out: a confident wrong name",
                share(sum(bool(first_names(v)) for _, v in without), len(without)),
                "<= 8 %",
            )
        )
    seconds = [v.get("seconds") or 0.0 for _, v in pairs]
    rows.append(
        (
            "seconds a robot, median / max",
            f"{median(seconds):.1f} / {max(seconds):.1f}" if seconds else "-",
            "15 / 30",
        )
    )
    lines = [
        "| figure | measured | bar |",
        "|---|---|---|",
        *(f"| {a} | {b} | {c} |" for a, b, c in rows),
        "",
    ]
    confusion = Counter(
        (k["label"], v["verdict"] if not first_names(v) else v["effects"][0]["name"]) for k, v in pairs
    )
    lines += [
        "## Who was called what",
        "",
        "| truth | said | robots |",
        "|---|---|---|",
        *(f"| {a} | {b} | {n} |" for (a, b), n in sorted(confusion.items())),
    ]
    lines += ["", "## Failures", ""]
    lines += [
        f"- {k['name']}: {k['label']} ({k['level']}, {k['ratio']:.2f} x floor{', encoders' if k['encoders'] else ''}): "
        f"{v['verdict']} {[e['name'] for e in v['effects']]} rivals {[r['name'] for r in (v.get('rivals') or [])[:3]]}"
        for k, v in single
        if not is_right(k["label"], v, k["encoders"])
    ]
    lines += [
        f"- {k['name']}: {k['label']}: {v['verdict']} {[e['name'] for e in v['effects']]}"
        for k, v in pairs
        if (k["label"] == "none" or ":" in k["label"]) and first_names(v)
    ]
    return "\n".join(lines) + "\n"
