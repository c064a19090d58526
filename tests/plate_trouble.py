"""A worker of plates that dies on images whose name says so."""

import os
import signal

from pavemark.job.plate_worker import Plates
from pavemark.job.worker import attend


class Misbehaving(Plates):
    def make(self, task):
        print("noise on stdout")
        if task["image"].endswith("deadly.png"):
            os.kill(os.getpid(), signal.SIGKILL)
        if task["image"].endswith("faulty.png"):
            raise ArithmeticError("a fault\nof two lines")
        return super().make(task)


if __name__ == "__main__":
    attend(Misbehaving)
