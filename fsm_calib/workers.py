"""The same work on many things, by several processes side by side, with the results that one alone would have.

The processes are forked from this one: each knows all that it knows, takes the next thing that nobody works on, and
only results travel back. Parts of a result that this process holds already need not travel: they are named as shared,
and stand in the result as what they are here. Where a process cannot be forked (no ``fork`` in this system, a thread
other than the main one, a process that another began), and whatever a process that died or failed left undone, is
worked out here: an error is raised as if there were no processes.
"""

from __future__ import annotations

import gc
import io
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkProcess
from typing import Any, TypeVar, cast

from fsm_calib.stops import STOP_SIGNALS

Thing = TypeVar("Thing")
Result = TypeVar("Result")

MOST = 16  # processes: beyond, one waits for the largest of the things
WIDTH, MOST_THINGS = 4, 10_000  # bytes of a place in a pipe, and places that one holds


def usable_cores() -> int:
    """Return how many processes this one may keep busy."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, MOST)


def each(
    work: Callable[[Thing], Result],
    things: Iterable[Thing],
    processes: int = 1,
    shared: Sequence[object] = (),
) -> list[Result]:
    """Return the result of every thing, in their order.

    Parameters
    ----------
    work : depends on nothing that it changes itself; what it changes is lost.
    things : what to work on.
    processes : at most so many side by side; one works here.
    shared : objects of this process that results may hold; the results hold these themselves, not copies.
    """
    things = list(things)
    count = min(processes, len(things))
    many = count > 1 and len(things) <= MOST_THINGS and _can_fork()
    found = _side_by_side(work, things, count, shared) if many else {}
    return [found[i] if i in found else work(thing) for i, thing in enumerate(things)]


def _can_fork() -> bool:
    """Return whether processes may be forked from here; on macOS the system's own libraries do not survive it."""
    is_first = (
        multiprocessing.parent_process() is None and multiprocessing.current_process().name == "MainProcess"
    )
    is_main_thread = threading.current_thread() is threading.main_thread()
    return sys.platform.startswith("linux") and is_first and is_main_thread


def _side_by_side(
    work: Callable[[Thing], Result], things: Sequence[Thing], count: int, shared: Sequence[object]
) -> dict[int, Result]:
    """Return the results that `count` processes have worked out, by the place of the thing."""
    places = _pipe_of_places(len(things))
    readers: list[Connection] = []
    processes: list[ForkProcess] = []
    found: dict[int, Result] = {}
    try:
        for _ in range(count):
            processes.append(_begun(partial(_work_through, work, things, places, shared), readers))
        _collect(readers, shared, found)
    except OSError:  # no more processes may be begun here
        pass
    finally:
        os.close(places)
        for process in processes:
            process.terminate()
            process.join()
        for reader in readers:
            reader.close()
    return found


def _pipe_of_places(count: int) -> int:
    """Return a pipe from which each read of `WIDTH` bytes takes one place that nobody else takes, until it is empty."""
    places, end = os.pipe()
    os.write(end, b"".join(place.to_bytes(WIDTH, "little") for place in range(count)))
    os.close(end)
    return places


def _begun(
    work_through: Callable[[Sequence[Connection], Connection], None], readers: list[Connection]
) -> ForkProcess:
    """Begin a process that writes to a pipe, whose other end is added to `readers`."""
    context = multiprocessing.get_context("fork")
    reader, writer = context.Pipe(duplex=False)
    readers.append(reader)
    process = context.Process(target=work_through, args=(readers, writer), daemon=True)
    try:
        process.start()
    finally:
        writer.close()
    return process


def _collect(readers: list[Connection], shared: Sequence[object], found: dict[int, Any]) -> None:
    """Read results until every process has closed its end, or has died."""
    while readers:
        for reader in wait(readers):
            one = cast(Connection, reader)
            try:
                place, result = _Reader(io.BytesIO(one.recv_bytes()), shared).load()
            except (EOFError, OSError):
                readers.remove(one)
                one.close()
            else:
                found[place] = result


def _work_through(
    work: Callable[[Thing], Result],
    things: Sequence[Thing],
    places: int,
    shared: Sequence[object],
    readers: Sequence[Connection],
    writer: Connection,
) -> None:
    """Work on the next thing until none is left; run in a process of its own."""
    for reader in readers:
        reader.close()  # who writes to a process that died is told so only where nobody else could read
    for number in STOP_SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)  # what stops the program ends these at once
    gc.freeze()  # what came with the fork stays shared: nobody looks through it for garbage
    while taken := os.read(places, WIDTH):
        place = int.from_bytes(taken, "little")
        try:
            text = _written((place, work(things[place])), shared)
        except Exception:  # raised again where the work is done once more
            continue
        try:
            writer.send_bytes(text)
        except BrokenPipeError:  # nobody waits for it any more
            return


def _written(result: object, shared: Sequence[object]) -> bytes:
    """Return a result as bytes, in which shared objects are numbers."""
    file = io.BytesIO()
    _Writer(file, shared).dump(result)
    return file.getvalue()


class _Writer(pickle.Pickler):
    """Writes shared objects as their numbers."""

    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._numbers = {id(thing): number for number, thing in enumerate(shared)}

    def persistent_id(self, thing: object) -> int | None:
        """Return the number of a shared object, None of any other."""
        return self._numbers.get(id(thing))


class _Reader(pickle.Unpickler):
    """Reads the numbers of shared objects as the objects."""

    def __init__(self, file: io.BytesIO, shared: Sequence[object]) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, number: int) -> object:
        """Return the shared object of a number."""
        return self._shared[number]
