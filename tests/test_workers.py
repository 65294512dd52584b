"""Work side by side: the results of one process, whatever happens to the others."""

import os
import select
import signal
import threading
from functools import partial

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.replay.settings import Settings
from fsm_calib.errors import InputError
from fsm_calib.workers import each
from fsm_calib.world2d.effects import registry

ASKED = {
    "motor_deadband",
    "sensor_offset",
    "tyre_scrub",
    "external_push",
    "low_friction_patch",
    "caster_drag",
}
HERE = os.getpid()
LONGEST = 20.0  # s that a process may take to see that its parent is gone


def elsewhere(thing):
    """Return the thing, its double, and whether another process worked on it."""
    return thing, 2 * thing, os.getpid() != HERE


def _large_result(parent, tells_end, thing):
    """Tell of the first thing, have the parent killed, and return more than a pipe holds."""
    os.write(tells_end, b"1")
    os.kill(parent, signal.SIGKILL)
    return np.zeros(10**6)


@pytest.fixture
def two_effects():
    """Two drives of a robot with a dead zone whose pose sensor lies off its middle."""
    changes = {"motor_deadband.offset": 0.08, "sensor_offset.x": 0.03}
    return [recording(seed, 40.0, **changes) for seed in (1, 2)]


def test_results_stand_in_the_order_of_their_things_and_come_from_other_processes():
    assert each(elsewhere, range(9), 3) == [(i, 2 * i, True) for i in range(9)]


def test_one_process_works_here():
    assert each(elsewhere, range(3), 1) == [(i, 2 * i, False) for i in range(3)]


def test_what_is_shared_does_not_travel():
    large, other = np.arange(3), np.arange(3)
    (kept, copied), _ = each(lambda _: (large, other), range(2), 2, [large])
    assert kept is large
    assert copied is not other
    assert np.array_equal(copied, other)


def test_an_error_is_raised_as_if_there_were_no_processes():
    def refuse(thing):
        if thing == 2:
            raise InputError("the third is wrong", cure="Take it out.")
        return thing

    with pytest.raises(InputError, match="the third is wrong") as raised:
        each(refuse, range(4), 2)
    assert raised.value.cure == "Take it out."


def test_what_a_process_that_was_killed_left_undone_is_done_here():
    def die(thing):
        if os.getpid() != HERE and thing == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        return thing

    assert each(die, range(6), 2) == list(range(6))


def test_where_no_process_may_be_begun_all_is_done_here(monkeypatch):
    def refused(process):
        raise BlockingIOError("Resource temporarily unavailable")

    monkeypatch.setattr("multiprocessing.process.BaseProcess.start", refused)
    assert each(elsewhere, range(3), 2) == [(i, 2 * i, False) for i in range(3)]


def test_no_pipe_is_left_open():
    before = len(os.listdir("/proc/self/fd"))
    each(elsewhere, range(5), 3)
    assert len(os.listdir("/proc/self/fd")) == before


def test_processes_whose_parent_was_killed_end_by_themselves():
    """A result larger than a pipe holds is never read: whoever writes it must be told so."""
    begun_here, tells_end = os.pipe()
    parent = os.fork()
    if not parent:
        os.close(begun_here)
        work = partial(_large_result, os.getpid(), tells_end)
        each(work, range(4), 2)
        os._exit(0)
    os.close(tells_end)
    os.waitpid(parent, 0)
    is_told = True
    while is_told and select.select([begun_here], [], [], LONGEST)[0]:
        is_told = bool(os.read(begun_here, 100))  # nothing: nobody holds the other end any more
    os.close(begun_here)
    assert not is_told


def test_a_result_that_cannot_travel_is_worked_out_here():
    (make,) = {f(1) for f in each(lambda thing: lambda x: x + thing, [3, 3], 2)}
    assert make == 4


def test_nothing_is_forked_from_another_thread():
    found = []
    thread = threading.Thread(target=lambda: found.extend(each(elsewhere, range(2), 2)))
    thread.start()
    thread.join()
    assert found == [(0, 0, False), (1, 2, False)]


def test_a_process_of_several_works_alone():
    inner = each(lambda thing: (os.getpid(), each(lambda _: os.getpid(), range(2), 2)), range(2), 2)
    assert all(pid != HERE and by == [pid, pid] for pid, by in inner)


def test_a_diagnosis_by_three_processes_is_that_of_one_to_the_last_digit(two_effects):
    without = set(registry()) - ASKED
    one, three = (
        diagnose(two_effects, without=without, settings=Settings(processes=n)).verdict.as_json()
        for n in (1, 3)
    )
    del one["seconds_by_part"], three["seconds_by_part"], one["seconds"], three["seconds"]
    assert [effect["name"] for effect in one["effects"]] == ["motor_deadband", "sensor_offset"]
    assert one == three
