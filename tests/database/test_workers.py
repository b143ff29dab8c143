"""Processes that compute a database end when the one that asked them is killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("joblib", reason="joblib is not installed (pip install .[bem])")

pytestmark = pytest.mark.bem

SCRIPT = """\
import os, sys, time
from pathlib import Path
import joblib
from hydrosim.database.build.bem import compute_all

def wait(folder):
    Path(folder, str(os.getpid())).touch()
    time.sleep(300.0)

list(compute_all((joblib.delayed(wait)(sys.argv[1]) for _ in range(2)), 2))
"""
LONGEST = 60.0  # s that is waited for, on a busy machine


def is_there(pid: int) -> bool:
    """Whether a process runs."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no /proc")
def test_workers_end_with_a_process_that_is_killed(tmp_path: Path) -> None:
    process = subprocess.Popen([sys.executable, "-c", SCRIPT, str(tmp_path)])
    end = time.monotonic() + LONGEST
    while len(found := [int(path.name) for path in tmp_path.iterdir()]) < 2:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    try:
        while any(map(is_there, found)):
            assert time.monotonic() < end, "workers go on"
            time.sleep(0.05)
    finally:
        for pid in filter(is_there, found):
            os.kill(pid, signal.SIGKILL)


def test_results_come_in_their_order() -> None:
    import joblib

    from hydrosim.database.build.bem import compute_all

    for jobs in (1, 2):
        calls = (joblib.delayed(divmod)(k, 3) for k in range(7))
        assert list(compute_all(calls, jobs)) == [divmod(k, 3) for k in range(7)]
