"""The judges' clock: time is what they report, and never decides what is made."""

from __future__ import annotations

import time


def spent() -> float:
    """Seconds of processor time that this process has used, all threads together.

    Of a method with one thread that is what a clock on the wall shows on an idle machine; on a busy one it is the same,
    and the clock on the wall is not.
    """
    return time.process_time()
