"""The supervisor: the phases of the plan in the paper's order, one way to fail, one way to stop.

Between two phases the wheels are put to zero. The plan may hold any of the phases. Every failure of a phase
leads to its named end under `failed`; `abort` leads to `aborted` from everywhere.
"""

from __future__ import annotations

from fsm_calib.machines.exit import EXIT
from fsm_calib.machines.failures import FAILURES
from fsm_calib.machines.focus import FOCUS
from fsm_calib.machines.lane import LANE
from fsm_calib.machines.orientation import ORIENTATION
from fsm_calib.machines.scan import SCAN
from fsm_calib.machines.wheels import WHEELS
from fsm_calib.statechart.spec import Chart, State, Transition, always

MACHINES = (FOCUS, SCAN, ORIENTATION, WHEELS, EXIT, LANE)
PHASES = tuple(machine.name for machine in MACHINES)

SUPERVISOR = Chart(
    name="supervisor",
    about="Runs the phases of the plan in the paper's order; every failure has a name, every run an end.",
    states=(
        State("between", "Wheels at zero; choose the next phase of the plan.", do="stop_wheels"),
        *(State(machine.name, machine.about, chart=machine) for machine in MACHINES),
        State("done", "Every phase of the plan is done."),
        State("aborted", "The operator stopped the run."),
        State("failed", "The run ended with a reason and a cure.", children=FAILURES),
    ),
    transitions=(
        *(Transition("wheels_stopped", "between", phase, (f"is_next_{phase}",), actions=("begin_phase",))
          for phase in PHASES),
        Transition("wheels_stopped", "between", "done", ("is_plan_done",), actions=("end_plan",)),
        *always("abort", ("between", *PHASES), "aborted"),
    ),
)  # fmt: skip
