"""The investigation: drive, diagnose, and design the next drive, until it is settled what the simulation is missing.

One turn: where is the robot (`localising`), back where there is room if need be (`returning`), the drive that would
settle most (`designing`), the drive itself (`driving`), all drives so far against the simulation (`diagnosing`), and
whether that is sure enough (`judging`). It ends when it is, when no drive in reach would make it surer, or when a
budget is spent.
"""

from __future__ import annotations

from fsm_calib.machines.investigate_books import ACTIONS, GUARDS, InvestigateBooks, InvestigateLimits
from fsm_calib.statechart.activity import Activity, Returned, contract_of
from fsm_calib.statechart.machinery import Machinery, Small
from fsm_calib.statechart.spec import Chart, State, always, choose, otherwise, when

SURE = "sure: bool, the answer is as sure as was asked for, and was so after the drive before"
TIME_LEFT = "time_left: bool, the robot may still drive: time and distance are not spent"
CRAMPED = "cramped: bool, drives were refused because they leave the area from here"
POSE_MISSING = Returned("pose_missing", "Nothing tells where the robot is.")

GIVEN_UP = (
    State("budget_spent", "Time, distance or drives are spent.",
          reason="The budget was spent after {drives} drives, and the answer is not sure.",
          cure="Go on with --from and these recordings, or give more time (--budget)."),
    State("nothing_to_learn", "No drive in reach would make the answer surer.",
          reason="After {drives} drives no drive on this floor would make the answer surer.",
          cure="Encoders, another floor, a load on the robot or a larger area would."),
    State("no_room", "No drive fits into the area, from wherever the robot began.",
          reason="No drive fits into the area, from {places} places or headings.",
          cure="Give a larger area, clear it, or a smaller command limit."),
)  # fmt: skip
FAILURES = (
    State("out_of_sight", "Nothing tells where the robot is.",
          reason="Nothing told where the robot is, {misses} times in a row.",
          cure="Put the robot where the tracker sees it, or among the floor markers if its own camera looks for them."),
    State("not_returning", "The robot does not come back to where there is room.",
          reason="The robot was not back where there is room after {returns} moves.",
          cure="Put the robot in the middle of the area; look for what holds it."),
    State("unreadable", "The drives cannot be diagnosed.",
          reason="The drives cannot be diagnosed.",
          cure="Check the tracker's rate and the robot's wheels."),
)  # fmt: skip

INVESTIGATION = Chart(
    name="investigate",
    about="Drive, diagnose and design the next drive until it is settled what the simulation is missing.",
    states=(
        State("localising", "Stand still and take poses, of the tracker or by floor markers.", do="localise"),
        State("searching", "Turn on the spot to see floor markers; wait, under a tracker.", do="look_around"),
        State("returning", "One move back towards the middle of the area.", do="return_step"),
        State("designing", "Find the drive that would settle most per second.", do="design_drive"),
        State("driving", "Drive it, and stop early where the area ends.", do="drive_plan"),
        State("diagnosing", "Compare all drives so far with the simulation.", do="diagnose_drives"),
        State("judging", "Is the answer sure, and is there anything left to spend?", do="judge_answer"),
        State("done", "The answer is sure."),
        State("aborted", "The operator stopped the run."),
        State("given_up", "The answer stays open, with the reason.", children=GIVEN_UP),
        State("failed", "The run ended with a reason and a cure.", children=FAILURES),
    ),
    transitions=(
        *choose("localised", "localising",
                when("is_roomy", "designing", "see_robot"),
                when("has_returns_left", "returning", "count_return"),
                otherwise("failed/not_returning")),
        *choose("pose_missing", "localising",
                when("has_misses_left", "searching", "count_miss"),
                otherwise("failed/out_of_sight", "count_miss")),
        *always("moved", "searching", "localising"),
        *always("moved", "returning", "localising"),
        *choose("drive_designed", "designing",
                when("has_drives_left", "driving", "count_drive"),
                otherwise("given_up/budget_spent")),
        *choose("nothing_to_learn", "designing",
                when("is_sure", "done"),
                when("may_look_elsewhere", "returning", "count_place"),
                otherwise("given_up/nothing_to_learn")),
        *choose("no_room", "designing",
                when("has_places_left", "returning", "count_place"),
                otherwise("given_up/no_room", "count_place")),
        *always("drive_finished", "driving", "diagnosing"),
        *always("drive_cut", "driving", "diagnosing"),
        *always("pose_missing", "driving", "localising", "count_miss"),
        *always("diagnosed", "diagnosing", "judging"),
        *choose("drives_refused", "diagnosing",
                when("has_drives_left", "localising"),
                otherwise("failed/unreadable")),
        *choose("answer_judged", "judging",
                when("is_sure", "done"),
                when("may_go_on", "localising"),
                otherwise("given_up/budget_spent")),
        *always("abort",
                ("localising", "searching", "returning", "designing", "driving", "diagnosing", "judging"), "aborted"),
    ),
)  # fmt: skip

CONTRACT = contract_of(
    Activity("localise", "Stand still and take the median of some poses.",
             (Returned("localised", "The robot's pose is known.",
                       ("roomy: bool, there is room for a drive around it",)), POSE_MISSING)),
    Activity("look_around", "Turn on the spot by a part of a turn; wait, where a tracker looks.",
             (Returned("moved", "The camera looks elsewhere."),)),
    Activity("return_step", "Turn towards the middle of the area and drive, at most so far.",
             (Returned("moved", "The move was made; where it led is seen next."),)),
    Activity("design_drive", "Find the drive of most information per second within the bounds.",
             (Returned("drive_designed", "The next drive is known."),
              Returned("nothing_to_learn", "No drive in reach tells anything.", (SURE, CRAMPED)),
              Returned("no_room", "No drive fits into the area from here."))),
    Activity("drive_plan", "Drive the plan and keep commands and poses; stop where the area ends.",
             (Returned("drive_finished", "The drive was made to its end."),
              Returned("drive_cut", "The drive was stopped at the area's edge; its part so far counts."),
              POSE_MISSING)),
    Activity("diagnose_drives", "Compare all drives with the simulation.",
             (Returned("diagnosed", "There is a verdict, and how sure it is."),
              Returned("drives_refused", "The drives hold too little to be diagnosed."))),
    Activity("judge_answer", "Compare sureness and what was spent with what was asked for.",
             (Returned("answer_judged", "It is known whether to go on.", (SURE, TIME_LEFT)),)),
)  # fmt: skip

INVESTIGATE = Machinery(
    root=INVESTIGATION,
    guards=GUARDS,
    actions=ACTIONS,
    contract=CONTRACT,
    books=InvestigateBooks,
    limits=InvestigateLimits,
    small=(Small(InvestigateLimits(drives=2, returns=2, misses=2, places=2)),),
    home="fsm_calib/machines/investigate.py",
    limits_home="fsm_calib/machines/investigate_books.py",
)
"""The investigation with all that it names."""
