"""Ctrl-C at any moment while processes start: it is obeyed afterwards, and no process complains."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from peristalsis.running.processes import Processes

STARTS = """
import os, signal, sys, threading, time
from peristalsis.running.processes import Processes
signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background begin with it ignored
if sys.argv[1] == "thread":
    begin = threading.Thread.start
    def start(self):
        if "Executor" in type(self).__name__:
            os.killpg(0, signal.SIGINT)
        begin(self)
    threading.Thread.start = start
else:
    threading.Timer(float(sys.argv[1]), os.killpg, (0, signal.SIGINT)).start()
pool = Processes(1)
try:
    pool.submit(time.sleep, 30.0).result()
except KeyboardInterrupt:
    pool.shutdown(cancel_futures=True)
    print("interrupted")
"""


@pytest.mark.parametrize("when", ["thread", "0.3", "0.6"])
def test_ctrl_c_while_processes_start(when: str) -> None:
    """As a terminal sends it, to all at once: in the middle of a start, and while what was started imports."""
    done = subprocess.run(
        [sys.executable, "-c", STARTS, when], capture_output=True, text=True, timeout=60, process_group=0
    )
    assert (done.stdout, done.stderr) == ("interrupted\n", "")


HOLDS = """
import os, signal, sys, threading, time
from peristalsis.running.spawning import undisturbed
signal.signal(signal.SIGINT, signal.default_int_handler)
if sys.argv[1] == "threads":
    threading.Thread(target=time.sleep, args=(30.0,), daemon=True).start()
try:
    with undisturbed():
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.2)
        print("whole")
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.parametrize("others", ["alone", "threads"])
def test_what_is_held_back_is_obeyed_afterwards(others: str) -> None:
    """Also where another thread is given the signal: the mask is that of one thread only."""
    done = subprocess.run([sys.executable, "-c", HOLDS, others], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("whole\ninterrupted\n", "")


def test_a_process_obeys_sigterm_once_it_has_begun() -> None:
    pool = Processes(1)
    try:
        assert pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result(60.0) == set()
    finally:
        pool.shutdown()
