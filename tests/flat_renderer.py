"""A renderer without Blender: every marking flat in its colour, with exact coverage.

Run as a script it is what render.py is, for tests of whole jobs:  python flat_renderer.py [--worker | render …]
"""

import errno
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from pavemark import cli
from pavemark.colour import to_linear
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.job.worker import serve
from pavemark.layers import Layers


class FlatRenderer:
    version = "flat 1"

    def render(self, scene, plate, plan):
        frame = scene.plate.frame
        decals = np.zeros((frame.height, frame.width, 4), np.float32)
        for marking in scene.markings:
            alpha = (coverage(outline(marking, scene.curvature), frame) * marking.paint.opacity)[..., None]
            if plan.colour == "ratio":
                colour = np.array(marking.paint.ratio)
            else:
                colour = to_linear(np.rint(marking.paint.rgb).astype(np.uint8))
            decals = decals * (1 - alpha) + np.concatenate([alpha * colour, alpha], -1)
        return Layers(decals.astype(np.float32))


class Misbehaving(FlatRenderer):
    """Does what FLAT_RENDERER says, such as "die@5;hang@7 once FILE": always, or until the file is there."""

    def render(self, scene, plate, plan):
        print("Saved: noise on stdout")
        os.write(1, b"noise without a line's end")
        for trouble in filter(None, os.environ.get("FLAT_RENDERER", "").split(";")):
            what, _, where = trouble.partition("@")
            index, _, once = where.partition(" once ")
            if scene.index == int(index) and not (once and Path(once).exists()):
                if once:
                    Path(once).touch()
                {"die": _die, "hang": _hang, "fail": _fail, "full": _full}[what]()
        return super().render(scene, plate, plan)


def _die():
    os.kill(os.getpid(), signal.SIGKILL)


def _hang():
    time.sleep(3600)


def _full():
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    os.fsync = full


def _fail():
    raise ArithmeticError("a fault\nof two lines")


if __name__ == "__main__":
    if sys.argv[1:] == ["--worker"]:
        serve(Misbehaving)
    else:
        cli.main(sys.argv[1:], [sys.executable, __file__, "--worker"])
