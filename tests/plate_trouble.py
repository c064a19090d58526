"""A worker of plates that dies on images whose name says so, or while their files are written."""

import os
import signal

from pavemark import files
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


def write(path, data):
    if path.parts[-2:] == ("plates", "halfway.png"):
        os.kill(os.getpid(), signal.SIGKILL)
    whole(path, data)
    if path.parts[-2:] == ("plates", "untold.png"):
        os.kill(os.getpid(), signal.SIGKILL)


whole, files.write = files.write, write

if __name__ == "__main__":
    attend(Misbehaving)
