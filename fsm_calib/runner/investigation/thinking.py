"""What an investigation thinks: design the next drive, diagnose all of them, judge the answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fsm_calib.actions.investigating import Field, InvestigationBench
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief, beside_the_leader, without_unlikely_more
from fsm_calib.diagnosis.design.belief_of import belief_of, prior_belief
from fsm_calib.diagnosis.design.designer import NoDrive, Wishes, design, foretold
from fsm_calib.diagnosis.design.plan import Plan
from fsm_calib.diagnosis.diagnose import Diagnosis, diagnose
from fsm_calib.diagnosis.replay.prepared import is_usable
from fsm_calib.diagnosis.replay.settings import Settings
from fsm_calib.errors import DataError
from fsm_calib.outcome import Outcome
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.runner.investigation.own_camera import camera_found, corrected, not_of_a_camera
from fsm_calib.types import Pose2
from fsm_calib.workers import usable_cores
from fsm_calib.world2d.scene import SceneSpec

DESIGN_STREAM = 13
"""Which random stream of the seed the designer draws from."""
CONFIRMATIONS = 2  # sure judgements of the same names, none of others between: one drive may be unlucky
SURE_NAME = 0.9  # confidence that the verdict itself must have in every name
SMALL_SHARE = 0.05  # of the evidence: what only mends inexact equations has less
NOTHING_BESIDE = 0.75  # probability that a sure answer is all there is: three to one
LEAST_SHARE = 0.02  # of the doubt: a drive that removes less is not worth driving
SHORTEST_TIME = 8.0  # s of budget: with less no drive is begun

Designer = Callable[[Belief, Area, Pose2, np.random.Generator, Wishes], Plan | NoDrive]


@dataclass(eq=False)
class Mind:
    """What an investigation believes between two drives; all of it follows from the recordings, so that a run that is
    taken up again thinks the same.

    given : recordings that were there before. designer : who plans drives. scene : the drawing, where poses come from
    its floor markers. linked : whether its frames come over a network.
    """

    area: Area
    facts: RobotFacts
    seed: int
    given: tuple[Recording, ...] = ()
    designer: Designer = design
    scene: SceneSpec | None = None
    linked: bool = False
    diagnosis: Diagnosis | None = None
    belief: Belief | None = None
    plans: list[Plan] = field(default_factory=list)
    _known: int = -1

    def design_drive(self, bench: InvestigationBench) -> Outcome:
        """Find the drive of most information per second from where the robot is."""
        asked, findings = bench.asked, bench.findings
        believed = self._believed(bench) or self._prior(1.0 / asked.look_every)
        sure = self._is_sure(believed, asked.sure)
        rng = np.random.default_rng([self.seed, DESIGN_STREAM, findings.designs])
        findings.designs += 1
        longest = min(asked.longest, max(asked.budget - findings.spent, SHORTEST_TIME))
        wishes = Wishes(longest=longest, limit=asked.command, least=LEAST_SHARE * believed.doubt)
        belief = without_unlikely_more(believed, asked.sure)
        start = Pose2(*(findings.pose or (0.0, 0.0, 0.0)))
        plan = self.designer(belief, self.area, start, rng, wishes)
        if plan is NoDrive.NOTHING_TOLD and (rest := beside_the_leader(believed)) is not None:
            # the doubt about it is small beside that of a set which no drive tells apart
            plan = self.designer(rest, self.area, start, rng, replace(wishes, least=LEAST_SHARE * rest.doubt))
            plan = plan if isinstance(plan, NoDrive) else foretold(plan, believed, rng, wishes)
        if plan is NoDrive.NO_ROOM:
            return Outcome("no_room", {}, "No drive fits into the area from here.")
        if isinstance(plan, NoDrive):
            evidence = {"sure": sure, "cramped": plan is NoDrive.CRAMPED}
            return Outcome("nothing_to_learn", evidence, "No drive in reach would make the answer surer.")
        findings.holds, findings.plan = list(plan.holds), plan.as_json()
        self.plans.append(plan)
        told: dict[str, object] = {
            "seconds": plan.seconds,
            "expected": plan.forecast.sureness,
            "why": plan.why,
        }
        return Outcome("drive_designed", told, f"A drive of {plan.seconds:.0f} s {plan.why}.")

    def diagnose_drives(self, bench: InvestigationBench) -> Outcome:
        """Compare all drives so far with the simulation."""
        try:
            belief = self._believed(bench)
            if self._learn_camera(bench):
                belief = self._believed(bench)
        except DataError as error:
            return Outcome("drives_refused", {}, error.problem, error.cure)
        if belief is None or self.diagnosis is None:
            return Outcome("drives_refused", {}, "There is no drive to diagnose.", "Drive first.")
        drive = bench.findings.drives[-1]
        drive.reached = belief.sureness
        drive.beliefs = [
            (h.label, float(p)) for h, p in zip(belief.hypotheses[:6], belief.probabilities, strict=False)
        ]
        said = self.diagnosis.verdict.verdict
        evidence = {"verdict": said, "leader": belief.leader.label, "sureness": belief.sureness}
        return Outcome("diagnosed", evidence, f"{said}: {belief.leader.label}, {belief.sureness:.0%} sure.")

    def recall(self, bench: InvestigationBench) -> None:
        """Think again what was thought of the drives before a run that had ended was taken up, to write it down."""
        drives = bench.findings.drives
        if self.diagnosis is None and drives and drives[-1].reached is not None:
            self._believed(bench)

    def judge_answer(self, bench: InvestigationBench) -> Outcome:
        """Compare sureness and what was spent with what was asked for."""
        asked, findings, belief = bench.asked, bench.findings, self._believed(bench)
        sure = belief is not None and self._is_sure(belief, asked.sure)
        names = [] if belief is None else self._told(belief)
        findings.streak = int(sure) + (findings.streak if names == findings.names else 0)
        findings.names = names
        time_left = asked.budget - findings.spent >= SHORTEST_TIME and findings.distance < asked.distance
        evidence = {
            "sure": sure and findings.streak >= CONFIRMATIONS,
            "time_left": time_left,
            "names": names,
            "sureness": 0.0 if belief is None else belief.sureness,
            "spent": round(findings.spent, 3),
            "distance": findings.distance,
        }
        return Outcome("answer_judged", evidence, _judged(names, evidence))

    def _learn_camera(self, bench: InvestigationBench) -> bool:
        """Take where a camera is found to sit, and how late it is, as known from now on; return whether anything was.

        These are numbers of the calibration and of the link, whose errors a drive over markers sees, and no physics.
        """
        if self.scene is None or self.diagnosis is None:
            return False
        found = camera_found(self.diagnosis.decision, self.linked)
        if not any(found):
            return False
        x, y, yaw, late = bench.findings.camera
        bench.findings.camera = (x + found[0], y + found[1], yaw + found[2], late + found[3])
        self._known = -1
        return True

    def _told(self, belief: Belief) -> list[str]:
        """Return the names of the verdict; where it has none, those of the likeliest explanation."""
        said = () if self.diagnosis is None else self.diagnosis.verdict.effects
        return sorted([e.name for e in said] or belief.leader.names)

    def _is_sure(self, belief: Belief, wanted: float) -> bool:
        """Return whether the belief and every name of the verdict are as sure as wanted, and no more is to be named.

        Whatever the likeliest explanation has beside the names may only mend what is inexact in them, if it is small;
        what may hide beside them must be found or ruled out first; and no further drive tells more of what happened
        once.
        """
        if self.diagnosis is None or belief.sureness < wanted or belief.completeness < NOTHING_BESIDE:
            return False
        verdict, model = self.diagnosis.verdict, self.diagnosis.decision.model
        named, leading = {e.name for e in verdict.effects}, set(belief.leader.names)
        shares = {s.name: s.share for s in model.supports}
        unsaid = max((shares.get(name, 1.0) for name in belief.leader.lasting - named), default=0.0)
        if verdict.verdict == "unexplained" or not named <= leading or bool(named) != bool(leading):
            return False
        return (
            unsaid <= SMALL_SHARE
            and not verdict.ambiguous
            and all(e.confidence >= SURE_NAME for e in verdict.effects)
        )

    def _believed(self, bench: InvestigationBench) -> Belief | None:
        """Return the belief after all drives, computed once for each number of them; what was cut off at once tells
        nothing.
        """
        drives = bench.findings.drives
        if self._known != len(drives):
            self._diagnose(self.recordings(bench)[len(self.given) :])
            self._known = len(drives)
        return self.belief

    def _diagnose(self, driven: Sequence[Recording]) -> None:
        """Ask all that was driven, from where the answer before had found what it said.

        An investigation that is resumed goes through its drives one by one again, so that it ends with an equal answer.
        """
        recordings = [*self.given, *filter(is_usable, driven)]
        last = len(recordings)
        first = max(len(self.given) if self.diagnosis is None else last, 1)
        for number in range(first, last + 1):
            self.diagnosis = diagnose(
                recordings[:number],
                without=self._not_asked,
                settings=Settings(own_map=self._maps, processes=usable_cores()),
                seed=self.seed,
                earlier=self.diagnosis,
            )
        if self.diagnosis is not None:
            self.belief = belief_of(self.diagnosis.decision)

    def _prior(self, frame_rate: float) -> Belief:
        """Return what is believed before anything was driven."""
        return prior_belief(robot=self.facts, frame_rate=frame_rate, without=self._not_asked)

    @property
    def _not_asked(self) -> frozenset[str]:
        """What need not be asked of a robot of which nothing is known but what its own camera tells."""
        return not_of_a_camera(self.linked) if self._maps else frozenset()

    @property
    def _maps(self) -> bool:
        """Whether all poses come from a map that the robot's own frames told."""
        return self.scene is not None and not self.given

    def recordings(self, bench: InvestigationBench) -> tuple[Recording, ...]:
        """Return the recordings that were given and those of the drives."""
        drives = bench.findings.drives
        if drives and self.scene is not None:
            rows = corrected(drives, self.scene, bench.notebook.mount, bench.findings.camera)
            drives = [replace(drive, poses=poses) for drive, poses in zip(drives, rows, strict=True)]
        return (*self.given, *(recording_of(d, self.facts, n) for n, d in enumerate(drives, start=1)))


def recording_of(drive: Field, facts: RobotFacts, number: int) -> Recording:
    """Return a drive as a recording whose clock begins with it; of several commands at one time the last acted."""
    begin = drive.commands[0][0]
    held = {round(time - begin, 6): (left, right) for time, left, right in drive.commands}
    commands = np.array([(time, *pair) for time, pair in held.items()])
    poses = np.array(drive.poses)
    return Recording(
        robot=facts,
        command=CommandTrack(commands[:, 0], commands[:, 1], commands[:, 2]),
        pose=PoseTrack(poses[:, 0] - begin, poses[:, 1], poses[:, 2], poses[:, 3]),
        source=f"drive {number}",
    )


def with_facts(facts: RobotFacts, recordings: Sequence[Recording]) -> RobotFacts:
    """Return the facts of recordings that were given, where there are some; else `facts`."""
    return replace(recordings[0].robot) if recordings else facts


def _judged(names: Sequence[str], evidence: dict[str, object]) -> str:
    what = " and ".join(names) or "nothing is missing"
    if evidence["sure"]:
        return f"Settled: {what}."
    sureness = float(str(evidence["sureness"]))
    return f"Not settled yet: {what}, {math.floor(100 * sureness)} % sure."
