"""One worker a core; files with slow tests run first, so that none is left alone with one at the end."""

import pytest

from fsm_calib.workers import usable_cores

MOST_WORKERS = 8  # the longest file takes an eighth of the whole


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return how many workers `-n auto` starts: one a core that this process may use, two at least.

    Some tests wait for a served robot or a program of ROS, so that two have something to do on one core.
    """
    return min(max(usable_cores(), 2), MOST_WORKERS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Move files that have a test marked `slow` to the front; their order stays otherwise."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)
