import os
import threading

import cv2
import numpy as np
import pytest

from pavemark.accuracy.apart import Apart
from pavemark.errors import InputError


def job(what):
    """What the process is asked to do."""
    if what == "work":
        return sum(number * number for number in range(3_000_000))
    if what == "hold":
        return int(np.ones(50_000_000, np.uint8).sum())
    if what == "who":
        return os.getpid()
    if what == "threads":
        return os.environ["OPENBLAS_NUM_THREADS"], cv2.getNumThreads()
    if what == "wait":
        threading.Event().wait(60)
    if what == "refuse":
        raise InputError("the hole", "is empty")
    if what == "fault":
        raise ValueError("of the method's own")
    os._exit(3)


def test_time_and_memory_are_those_of_the_process():
    # What this process holds must not count: the other one begins anew.
    mine = np.ones(300_000_000, np.uint8)
    with Apart(job, "job") as apart:
        idle = apart("who")
        work = apart("work")
        hold = apart("hold")
    assert mine[-1] == 1
    assert idle.value != os.getpid()
    assert idle.seconds < 0.05 < work.seconds
    assert idle.peak_mb < 300
    assert hold.peak_mb - idle.peak_mb == pytest.approx(50, abs=15)


def test_faults_are_told_in_a_line_and_the_next_call_is_answered():
    with Apart(job, "lama") as apart:
        with pytest.raises(InputError, match="lama: the hole: is empty"):
            apart("refuse")
        first = apart("who").value
        with pytest.raises(InputError, match="lama: ValueError: of the method's own"):
            apart("fault")
        assert apart("who").value == first
        with pytest.raises(InputError, match="lama: its process died with code 3"):
            apart("die")
        assert apart("who").value != first


def test_short_calls_are_repeated_and_the_mean_is_told():
    with Apart(job, "job") as once, Apart(job, "job", least=0.05) as often:
        assert often("who").value != os.getpid()
        # To ask for a process's number takes no hundredth of the time that it is asked for it.
        assert 0 < often("who").seconds < 5e-4
        work = once("work").seconds
        assert often("work").seconds == pytest.approx(work, rel=0.5)


def test_patience_ends_and_the_next_call_has_a_process_of_its_own():
    with Apart(job, "render", patience=5.0) as apart:
        first = apart("who").value
        with pytest.raises(InputError, match="render: gave no answer within 5 s"):
            apart("wait")
        assert apart("who").value != first


def test_the_process_has_one_thread_and_this_one_keeps_its_environment():
    before = dict(os.environ)
    with Apart(job, "job") as apart:
        assert apart("threads").value == ("1", 1)
    assert dict(os.environ) == before
