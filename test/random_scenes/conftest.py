# SPDX-License-Identifier: BSD-3-Clause
"""Options of test_random_scenes.py."""


def pytest_addoption(parser):
    """Which decks."""
    group = parser.getgroup("random scenes")
    group.addoption("--seed", type=int, help="one deck, which is kept")
    group.addoption("--first", type=int, default=1, help="seed of the first deck")
    group.addoption("--count", type=int, help="how many decks; those of the tier if left out")
    group.addoption("--jobs", type=int, default=1, help="decks that are judged at the same time")


def pytest_collection_modifyitems(config, items):
    """One deck or many."""
    left = "test_random_scenes" if config.getoption("--seed") is not None else "test_one_scene"
    out = [item for item in items if item.name == left]
    items[:] = [item for item in items if item not in out]
    config.hook.pytest_deselected(items=out)
