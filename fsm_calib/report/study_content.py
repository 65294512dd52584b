"""Puts a study's summary into words, tables and plots."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from fsm_calib.report import study_figures as figures
from fsm_calib.report.study_blocks import Block, Content, Paragraph, Part, Plot, Table
from fsm_calib.report.study_figures import LABELS
from fsm_calib.study.fleet import CommandCost
from fsm_calib.study.statistics import Estimate
from fsm_calib.study.summary import DeviationFigures, Summary, VariantFigures, conclusion

HOURS_OF = 10_000
"""How many robots the cost is told for [1]."""
VARIANT_COLUMNS = (
    "median of size [cm]",
    "added [cm]",
    "largest [cm]",
    "within 10 cm",
    "finished",
    "drives",
    "time [s]",
)
"""Columns of a table of variants after the variant's name."""


def content_of(summary: Summary, costs: Sequence[CommandCost] = ()) -> Content:
    """Return the report of a study; `costs` are those of the commands that ran it."""
    study = summary.study
    parts = [
        Part("Camera", list(_camera(summary))),
        Part("Wheels", list(_wheels(summary))),
        Part("Camera and wheels", list(_relations(summary))),
        Part("What each correction is worth", list(_corrections(summary))),
        Part("Sensitivity", list(_sweeps(summary))),
        Part("Failures", list(_failures(summary))),
        Part("Cost", list(_cost(summary, costs))),
    ]
    robots = "one robot, again and again" if study.same_robot else "robots drawn from the fleet"
    lead = f"{summary.robots} calibrations, {robots}; seed {study.seed}; parts: {', '.join(study.parts)}."
    return Content(study.title or study.name, lead, [part for part in parts if part.blocks])


def interval(estimate: Estimate, scale: float = 1.0, digits: int = 2, sign: str = "") -> str:
    """Return a figure and its interval as text: ``value [low, high]``."""
    form = f"{sign}.{digits}f"
    if not math.isfinite(estimate.value):
        return "-"
    value = format(scale * estimate.value, form)
    if not math.isfinite(estimate.low):
        return value
    return f"{value} [{format(scale * estimate.low, form)}, {format(scale * estimate.high, form)}]"


def per_cent(estimate: Estimate) -> str:
    """Return a share with its interval in per cent."""
    return f"{interval(estimate, 100.0, 1)} %" if estimate.count else "-"


def largest(item: DeviationFigures) -> str:
    """Return the largest deviation [cm], or a dash where no robot has a result."""
    return f"{100.0 * item.largest:.1f}" if item.passing.count else "-"


def _camera(summary: Summary) -> Iterable[Block]:
    if not summary.cameras:
        return
    header = ("camera", "paper's error [px]", "rms [px]", "true error [px]", "largest [px]")
    rows = [
        (
            LABELS[way],
            interval(item.paper_px, digits=4),
            interval(item.rms_px, digits=3),
            interval(item.true_px),
            f"{item.largest_true_px:.2f}",
        )
        for way, item in summary.cameras.items()
    ]
    yield Paragraph(
        "Medians with 95 % intervals. The true error is over the whole image, against the true lens."
    )
    yield Table(header, rows)
    for way, gain in summary.camera_gain.items():
        verdict = _verdict(gain)
        said = f"True error, automatic minus {LABELS[way]}, robot by robot: {interval(gain, sign='+')} px: {verdict}."
        yield Paragraph(said)
    draw = partial(figures.camera_figure, summary)
    caption = "Figure 4a: reprojection error, as the paper computes it."
    yield Plot("figure_4a", caption, partial(draw, "paper_px", "reprojection error [px]"))
    yield Plot("camera_true", "Error against the true lens.", partial(draw, "true_px", "true error [px]"))


def _verdict(gain: Estimate) -> str:
    if not gain.excludes_zero:
        return "no difference that these robots could tell"
    return "the automatic calibration is ahead" if gain.high < 0.0 else "the person is ahead"


def _wheels(summary: Summary) -> Iterable[Block]:
    if not summary.deviations:
        return
    header = (
        "wheels",
        "mean [cm]",
        "median of size [cm]",
        "largest [cm]",
        "within 10 cm",
        "rounded to cm",
        "finished",
    )
    rows = [(LABELS[way], *deviation_cells(item)) for way, item in summary.deviations.items()]
    yield Paragraph("Deviation after 2 m, right positive; shares with 95 % intervals.")
    yield Table(header, rows)
    for way, gain in summary.deviation_gain.items():
        text = interval(gain, 100.0, sign="+")
        yield Paragraph(
            f"Size of the deviation, {LABELS[way]} minus by hand, robot by robot: {text} cm: {_verdict(gain)}."
        )
    for way, letter in (("test_1", "b"), ("test_2", "c")):
        if way in summary.deviations:
            caption = (
                f"Figure 4{letter}: {way.replace('_', ' ')}; dots exact, bars as read to the centimetre."
            )
            yield Plot(f"figure_4{letter}", caption, partial(figures.deviation_figure, summary, way))


def deviation_cells(item: DeviationFigures) -> tuple[str, ...]:
    """Return the cells of a row on deviations."""
    return (
        interval(item.mean, 100.0, sign="+"),
        interval(item.median_size, 100.0),
        largest(item),
        per_cent(item.passing),
        per_cent(item.passing_rounded),
        per_cent(item.finished),
    )


def _relations(summary: Summary) -> Iterable[Block]:
    if not any(math.isfinite(relation.correlation.value) for relation in summary.relations):
        return
    rows = [
        (relation.name, interval(relation.correlation, sign="+"), str(relation.correlation.count))
        for relation in summary.relations
    ]
    yield Table(("size of the deviation against", "Spearman's rho", "robots"), rows)
    yield from (Paragraph(sentence) for sentence in conclusion(summary))
    yield Plot(
        "relation",
        "Deviation against the camera's figures, test 2.",
        partial(figures.relation_figure, summary),
    )


def _corrections(summary: Summary) -> Iterable[Block]:
    items = [item for item in summary.variants if item.variant.sweep is None]
    if not items:
        return
    names = [item.variant.name.removeprefix("published:").replace("_", " ") for item in items]
    yield Paragraph("Test 2 with single corrections taken back, beside the same robots with all corrections.")
    yield _variant_table("taken back", names, items)
    yield Plot("corrections", "What each correction is worth.", partial(figures.corrections_figure, items))


def _sweeps(summary: Summary) -> Iterable[Block]:
    sweeps: dict[str, list[VariantFigures]] = {}
    for item in summary.variants:
        if item.variant.sweep is not None:
            sweeps.setdefault(item.variant.sweep, []).append(item)
    if not sweeps:
        return
    units = {sweep.name: sweep.unit for sweep in summary.study.sweeps}
    items = [item for group in sweeps.values() for item in group]
    names = [
        f"{item.variant.sweep} = {item.variant.value:g} {units[item.variant.sweep or '']}" for item in items
    ]
    yield Paragraph("Test 2 on the same robots with one setting changed.")
    yield _variant_table("setting", names, items)
    caption = "Median size of the deviation; dashed: nothing changed."
    yield Plot("sweeps", caption, partial(figures.sweep_figure, sweeps, units))


def _variant_table(title: str, names: Sequence[str], items: Sequence[VariantFigures]) -> Table:
    header = (title, *VARIANT_COLUMNS)
    rows = [
        (
            name,
            interval(item.deviation.median_size, 100.0),
            interval(item.added, 100.0, sign="+"),
            largest(item.deviation),
            per_cent(item.deviation.passing),
            _finished(item.deviation),
            interval(item.iterations, digits=0),
            interval(item.simulated, digits=0),
        )
        for name, item in zip(names, items, strict=True)
    ]
    before = items[0].base_deviation
    first = ("none", interval(before.median_size, 100.0), "-", largest(before))
    return Table(header, [(*first, per_cent(before.passing), _finished(before), "-", "-"), *rows])


def _finished(item: DeviationFigures) -> str:
    """Return how many robots of how many have a result."""
    return f"{round(item.finished.value * item.finished.count)} of {item.finished.count}"


def _failures(summary: Summary) -> Iterable[Block]:
    if summary.failures:
        yield Table(("failure", "robots"), _counted(summary.failures))
    else:
        yield Paragraph(f"None in {summary.robots} robots.")
    changed = [(item.variant.name, *row) for item in summary.variants for row in _counted(item.failures)]
    if changed:
        yield Table(("with a change", "failure", "robots"), changed)


def _counted(failures: Mapping[str, int]) -> list[tuple[str, str]]:
    return [(name.replace("_", " "), str(count)) for name, count in failures.items()]


def _cost(summary: Summary, costs: Sequence[CommandCost]) -> Iterable[Block]:
    clock = [(name, interval(item, digits=0)) for name, item in summary.seconds.items()]
    processor = [
        (name.replace("_", " "), interval(item, digits=1)) for name, item in summary.processor.items()
    ]
    yield Table(("part", "median time of the robot or the person [s]"), clock)
    yield Table(("part", "mean processor time [s]"), processor)
    if costs:
        yield _commands(costs)
        best = max(costs, key=lambda cost: cost.robots)
        hours = HOURS_OF / best.robots_per_hour
        workers = "1 worker" if best.workers == 1 else f"{best.workers} workers"
        yield Paragraph(f"At this pace {HOURS_OF} robots take {hours:.0f} h with {workers}.")


def _commands(costs: Sequence[CommandCost]) -> Table:
    """Return what each command did."""
    header = ("command", "robots", "workers", "wall [s]", "robots/h", "overhead")
    rows = [
        (
            str(number),
            str(cost.robots),
            str(cost.workers),
            f"{cost.wall:.0f}",
            f"{cost.robots_per_hour:.0f}",
            f"{100.0 * cost.overhead:.1f} %",
        )
        for number, cost in enumerate(costs, start=1)
    ]
    return Table(header, rows)


def settings_of(summary: Summary) -> Mapping[str, object]:
    """Return every setting of the study as plain values."""
    dumped: Mapping[str, object] = summary.study.model_dump(mode="json")
    return dumped
