"""What stands in for `pavemark.study.runs.train`, in processes of their own: without torch, and at once."""

import os
import signal
import time

from pavemark import files
from pavemark.errors import InputError


def model(run, folder):
    return folder / "models" / f"{run.steps}-{run.seed}.onnx"


def trained(run, folder, key):
    files.write(model(run, folder), str(run.seed))


def slow(run, folder, key):
    """All but those of one step begin a file, and take longer than anyone waits."""
    if run.steps == 1:
        # Not before another has begun.
        while not list((folder / "models").glob(".*.part")):
            time.sleep(0.01)
        trained(run, folder, key)
    else:
        path = files.aside(model(run, folder))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("half")
        time.sleep(600)


def refused(run, folder, key):
    raise InputError(folder, f"steps = {run.steps}: fewer are allowed")


def killed(run, folder, key):
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(600)
