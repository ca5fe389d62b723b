"""Is handing out trials cheap, whatever their number? With a stage that does nothing."""

import time

import numpy as np
import pytest
import yaml
from small_sweeps import scene_file

from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool
from simtip.sweep.resuming import open_table
from simtip.sweep.running import run_sweep
from simtip.sweep.sweep_file import read_sweep
from simtip.sweep.work import Done, Setup


def nothing(job):
    """Give rows at once."""
    rows = [{"key": f"{number:032x}", "trial": number, "status": "ok"} for number in job.trials]
    return Done([] if job.only_light else rows, {}, 1e-6 * len(job.trials))


def plan_of(folder, repeats):
    scene_file(folder)
    file = folder / "sweep.yaml"
    factors = {"detect.threshold": {"from": 60, "to": 109, "count": 50}}
    said = {"scene": "scene.yaml", "factors": factors, "repeats": repeats}
    file.write_text(yaml.safe_dump(said))
    source = read_sweep(file)
    return Plan(source.spec, source.scene)


def seconds(folder, trials):
    folder.mkdir()
    plan = plan_of(folder, trials // 50)
    assert len(plan) == trials
    (folder / "out").mkdir()
    table, done = open_table(folder / "out", plan, {}, retry_failed=False)
    setup = Setup("", "", (), "llvm", None, 0, 100.0)
    start = time.perf_counter()
    tally = run_sweep(
        plan, table, setup, Pool(2), done=lambda number: bool(done[number]), work=nothing
    )
    took = time.perf_counter() - start
    assert tally.done == trials
    assert len(table.keys()) == trials
    return took


@pytest.mark.slow
def test_a_hundred_thousand_cost_no_more_each_than_ten_thousand(tmp_path):
    """Starting processes costs seconds whatever the number, so differences are compared."""
    few, some, many = (seconds(tmp_path / str(count), count) for count in (100, 20_000, 100_000))
    each_of_some = (some - few) / 19_900
    each_of_many = (many - some) / 80_000
    assert each_of_many < 3 * max(each_of_some, 20e-6)
    assert np.isfinite(each_of_many)
