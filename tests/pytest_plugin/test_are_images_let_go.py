from __future__ import annotations

import pytest

COUNT = """
import gc
from simtip.pytest_plugin.pair import Pair

def pytest_sessionfinish():
    gc.collect()
    print("\\npairs alive:", sum(isinstance(one, Pair) for one in gc.get_objects()))
"""


@pytest.mark.parametrize("end", ["", "    assert False"])
def test_at_its_end_a_test_lets_go_of_its_images(mine, end):
    """pytest keeps its tests to the end of the run: images of all would fill the memory."""
    mine.write("conftest.py", COUNT)
    mine.test(
        "@pytest.mark.parametrize('k', range(4))\n"
        "def test(simtip_pair, k):\n"
        "    for seed in range(3):\n"
        f"        simtip_pair('tiny.yaml', seed).measure(lowest_dark)\n{end}"
    )
    done = mine.run("-s")
    done.assert_outcomes(**{"failed" if end else "passed": 4})
    assert "pairs alive: 0\n" in done.stdout.str()
