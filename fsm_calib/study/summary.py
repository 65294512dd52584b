"""What a study says: figures with intervals, comparisons robot by robot, relations, variants, cost.

Everything here follows from the rows and the study's seed, so that the same rows give the same summary.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from fsm_calib.study.columns import CAMERA, DEVIATION, Row, Rows, rounded, rows_of
from fsm_calib.study.models import Study
from fsm_calib.study.statistics import Estimate, estimate, mean_of, median_of, rank_correlation, share
from fsm_calib.study.variants import BASE, Variant, variants_of
from fsm_calib.types import FloatArray
from fsm_calib.world2d.deviation import TEST_DISTANCE

PASS_DEVIATION = 0.10
"""The manual's criterion for wheels: so much after 2 m at most [m]."""
_STREAM = 201
CAMERA_FIGURES = ("paper_px", "rms_px", "true_px")


@dataclass(frozen=True, slots=True)
class CameraFigures:
    """One way of calibrating the camera: medians with intervals and the largest value [px]."""

    paper_px: Estimate
    rms_px: Estimate
    true_px: Estimate
    largest_true_px: float


@dataclass(frozen=True, slots=True)
class DeviationFigures:
    """One way of calibrating the wheels: deviation after 2 m [m], and shares [1].

    mean, median_size : of the signed deviation and of its absolute value; largest : absolute; passing : share
    of those measured that deviate by at most 0.10 m, exact and rounded to the centimetre; finished : share of
    all robots that have a result.
    """

    mean: Estimate
    median_size: Estimate
    largest: float
    passing: Estimate
    passing_rounded: Estimate
    finished: Estimate


@dataclass(frozen=True, slots=True)
class Relation:
    """How a figure of the camera goes with the size of the deviation: Spearman's rank correlation."""

    name: str
    correlation: Estimate


@dataclass(frozen=True, slots=True)
class VariantFigures:
    """One variant beside the base on the same robots: deviations, what is added to their size [m], cost, failures."""

    variant: Variant
    deviation: DeviationFigures
    added: Estimate
    iterations: Estimate
    simulated: Estimate
    base_deviation: DeviationFigures
    failures: Mapping[str, int]


@dataclass(frozen=True, eq=False)
class Summary:
    """All a study says.

    cameras, deviations : by way; camera_gain, deviation_gain : automatic minus by hand, robot by robot, of
    the true camera error [px] and of the size of the deviation [m], by way; test_gap : size of the deviation
    in test 2 minus test 1 [m]; seconds : simulated or counted [s] and processor [s], by part.
    """

    study: Study
    rows: Rows
    robots: int
    failures: Mapping[str, int]
    cameras: Mapping[str, CameraFigures]
    deviations: Mapping[str, DeviationFigures]
    camera_gain: Mapping[str, Estimate]
    deviation_gain: Mapping[str, Estimate]
    test_gap: Estimate
    relations: tuple[Relation, ...]
    variants: tuple[VariantFigures, ...]
    seconds: Mapping[str, Estimate]
    processor: Mapping[str, Estimate]


def summarise(study: Study, rows: Iterable[Row]) -> Summary:
    """Return what the rows of a study say."""
    everything = list(rows)
    base = rows_of(everything)
    rng = np.random.default_rng([study.seed, _STREAM])
    driven = [
        way for way in DEVIATION if base.has(way) and (way == "by_hand" or "wheels" in study.scenario.plan)
    ]
    deviations = {way: deviation_figures(base.deviation(way), rng) for way in driven}
    seen = [way for way in CAMERA if np.isfinite(base.camera(way, "true_px")).any()]
    cameras = {way: camera_figures(base, way, rng) for way in seen}
    return Summary(
        study=study,
        rows=base,
        robots=len(base.rows),
        failures=failures(base),
        cameras=cameras,
        deviations=deviations,
        camera_gain=_camera_gain(base, cameras, rng),
        deviation_gain=_deviation_gain(base, deviations, rng),
        test_gap=_median_difference(_size(base, "test_2"), _size(base, "test_1"), rng),
        relations=relations(base, rng),
        variants=tuple(_variants(study, everything, rng)),
        seconds=_seconds(base, rng),
        processor=_processor(base, rng),
    )


def camera_figures(rows: Rows, way: str, rng: np.random.Generator) -> CameraFigures:
    """Return the figures of one way of calibrating the camera."""
    values = {figure: rows.camera(way, figure) for figure in CAMERA_FIGURES}
    medians = {figure: estimate(column, median_of, rng) for figure, column in values.items()}
    known = values["true_px"][np.isfinite(values["true_px"])]
    return CameraFigures(**medians, largest_true_px=float(known.max(initial=0.0)))


def deviation_figures(deviation: FloatArray, rng: np.random.Generator) -> DeviationFigures:
    """Return the figures of deviations [m], shape (n,), nan for robots without a result."""
    known = deviation[np.isfinite(deviation)]
    passing = int(np.sum(np.abs(known) <= PASS_DEVIATION))
    near = int(np.sum(np.abs(rounded(known)) <= PASS_DEVIATION + 1e-9))
    return DeviationFigures(
        mean=estimate(known, mean_of, rng),
        median_size=estimate(np.abs(known), median_of, rng),
        largest=float(np.abs(known).max(initial=0.0)),
        passing=share(passing, known.size),
        passing_rounded=share(near, known.size),
        finished=share(known.size, deviation.size),
    )


def relations(rows: Rows, rng: np.random.Generator) -> tuple[Relation, ...]:
    """Return how the camera's figures go with the deviation of test 2, and of test 1 as a control.

    In test 1 the wheels are calibrated with another camera than the one that the figure is of; a relation
    there would be one between robots, not between calibrations.
    """
    found = []
    for name, figure in (("reprojection error", "paper_px"), ("predicted camera error", "predicted_px")):
        for way in ("test_2", "test_1"):
            if rows.has(way) and rows.has("test_2"):
                pair = rows.camera("automatic", figure), _size(rows, way)
                found.append(Relation(f"{name}, {way.replace('_', ' ')}", rank_correlation(*pair, rng)))
    return tuple(found)


def failures(rows: Rows) -> dict[str, int]:
    """Return how often each failure ended a part of a robot: name to number."""
    names = [row["error"]["name"] for row in rows.rows if "error" in row]
    for part in ("test_1", "test_2"):
        names += [f"{part.replace('_', ' ')}: {name}" for name in rows.text(part, "failure", "name") if name]
    return dict(Counter(names).most_common())


def _size(rows: Rows, way: str) -> FloatArray:
    return np.abs(rows.deviation(way))


def _median_difference(first: FloatArray, second: FloatArray, rng: np.random.Generator) -> Estimate:
    """Return the median of first minus second, robot by robot."""
    return estimate(first - second, median_of, rng)


def _camera_gain(
    rows: Rows, cameras: Mapping[str, CameraFigures], rng: np.random.Generator
) -> dict[str, Estimate]:
    if "automatic" not in cameras:
        return {}
    own = rows.camera("automatic", "true_px")
    ways = [way for way in cameras if way != "automatic"]
    return {way: _median_difference(own, rows.camera(way, "true_px"), rng) for way in ways}


def _deviation_gain(
    rows: Rows, deviations: Mapping[str, DeviationFigures], rng: np.random.Generator
) -> dict[str, Estimate]:
    if "by_hand" not in deviations:
        return {}
    ways = [way for way in deviations if way != "by_hand"]
    return {way: _median_difference(_size(rows, way), _size(rows, "by_hand"), rng) for way in ways}


def _variants(study: Study, rows: list[Row], rng: np.random.Generator) -> Iterable[VariantFigures]:
    """Yield each variant's figures beside those of the same robots in the base."""
    base = {row["robot"]: row for row in rows if row["variant"] == BASE}
    for variant in variants_of(study):
        found = rows_of(rows, variant.name)
        if variant.name == BASE or not found.rows:
            continue
        same = Rows(tuple(base.get(robot, {"robot": robot}) for robot in found.robots()))
        deviation, before = found.deviation("test_2"), same.deviation("test_2")
        yield VariantFigures(
            variant,
            deviation_figures(deviation, rng),
            _median_difference(np.abs(deviation), np.abs(before), rng),
            estimate(found.value("test_2", "wheels", "iterations"), median_of, rng),
            estimate(found.value("test_2", "seconds", "simulated"), median_of, rng),
            deviation_figures(before, rng),
            failures(found),
        )


def _seconds(rows: Rows, rng: np.random.Generator) -> dict[str, Estimate]:
    """Return what each part takes on the robot's or the person's clock: medians [s]."""
    paths = {
        "camera by hand": ("by_hand", "seconds", "camera"),
        "wheels by hand": ("by_hand", "seconds", "wheels"),
        "test 1": ("test_1", "seconds", "simulated"),
        "test 2": ("test_2", "seconds", "simulated"),
    }
    return {
        name: estimate(rows.value(*path), median_of, rng) for name, path in paths.items() if rows.has(path[0])
    }


def _processor(rows: Rows, rng: np.random.Generator) -> dict[str, Estimate]:
    """Return what each part costs the machine: means [s] of processor time."""
    return {
        part: estimate(rows.value("cost", part, "cpu"), mean_of, rng)
        for part in ("by_hand", "test_1", "test_2")
        if rows.has(part)
    }


def conclusion(summary: Summary) -> list[str]:
    """Return sentences that say whether the paper's conclusions hold here (section 4.3)."""
    said = []
    for relation in summary.relations:
        if relation.name == "reprojection error, test 2" and np.isfinite(relation.correlation.low):
            said.append(_relation_sentence(relation.correlation))
    gap = summary.test_gap
    if np.isfinite(gap.low):
        said.append(_gap_sentence(gap))
    return said


def _relation_sentence(rho: Estimate) -> str:
    figures = f"Spearman's rho = {rho.value:+.2f} [{rho.low:+.2f}, {rho.high:+.2f}] over {rho.count} robots"
    if rho.low > 0.0:
        verdict = "holds here"
    elif rho.high < 0.0:
        verdict = "does not hold here: the relation goes the other way"
    else:
        verdict = "is not confirmed here: the interval contains zero"
    return f"The paper's conclusion of a clear relation between reprojection error and deviation {verdict} ({figures})."


def _gap_sentence(gap: Estimate) -> str:
    figures = (
        f"{100 * gap.value:+.2f} [{100 * gap.low:+.2f}, {100 * gap.high:+.2f}] cm after {TEST_DISTANCE:g} m"
    )
    if gap.low > 0.0:
        verdict = "does cost the wheels accuracy, as the paper says"
    elif gap.high < 0.0:
        verdict = "does not cost the wheels accuracy: with it they are calibrated better"
    else:
        verdict = "makes no difference to the wheels that these robots could tell"
    return f"A new automatic camera calibration in place of the best one by hand {verdict} ({figures})."
