import contextlib
import json
import os
import socket

import numpy as np
import pytest
from fake_solver import Fails, simulate

from billow.base.errors import InputError
from billow.study import execute


@pytest.mark.filterwarnings("error:Port")
def test_studies_run_side_by_side(study):
    with socket.socket() as taken:
        with contextlib.suppress(OSError):  # another study on this machine has it already
            taken.bind(("127.0.0.1", 8787))
            taken.listen()
        with execute.dask_client(1, None, threads=3) as client:
            assert client.submit(sum, [1, 2]).result() == 3
            limits = [client.submit(os.environ.get, f"{name}_NUM_THREADS").result() for name in ("NUMBA", "OPENBLAS")]
            assert limits == ["3", "1"]


def test_worker_processes_make_the_runs_and_a_run_that_kills_them_is_given_up(study):
    events = []
    before = os.environ.get("NUMBA_NUM_THREADS")
    summary = study.run(workers=2, progress=events.append, runner=Fails(study.runs["0001"][0], "die"))
    assert summary.completed == ("0000", "0002", "0003", "0004", "0005")
    assert [event.status for event in events if event.run == "0001"] == ["repeated", "repeated", "failed"]
    assert [event.run for event in events if event.status == "failed"] == ["0001"]
    record = json.loads((study.folder / "failed/0001.json").read_text())
    assert (record["code"], record["attempts"]) == ("E-STU-019", execute.MAX_ATTEMPTS)

    assert os.environ.get("NUMBA_NUM_THREADS") == before, "numba in this process would refuse to go on"

    # Any cluster will do; this one is not ours, and is there afterwards.
    with execute.dask_client(1, None) as client:
        address = client.scheduler_info()["address"]
        assert client.run(lambda: os.environ["NUMBA_NUM_THREADS"]).popitem()[1] == "1"
        summary = study.run(scheduler=address, retry_failed=True, runner=simulate)
        assert client.submit(sum, [1, 2]).result() == 3
    assert summary.completed == tuple(study.runs)
    dataset = study.dataset()
    rise = dataset.snapshots("displacement", dataset.test)[:, -1, 0, 2]
    np.testing.assert_allclose(rise, 0.02 * dataset.design(dataset.test)[:, 0], rtol=1e-6)


def test_a_scheduler_that_is_not_there(study, monkeypatch):
    monkeypatch.setattr(execute, "ANSWER_SECONDS", 0.3)
    for address in ("tcp://127.0.0.1:9", "nonsense://x", "tls://127.0.0.1:9", "inproc://x", ""):
        with pytest.raises(InputError, match="E-STU-015"):
            study.run(scheduler=address, runner=simulate)
