"""Python without what Windows lacks: to a process that finds this on its path, and to all that it starts.

Only for Pavemark's own code: the interpreter and the libraries do on Linux as they do.
"""

import functools
import os
import signal
import subprocess
import sys
import warnings

from pavemark import system

OURS = ("pavemark", "blender_addon")
LACKING = {
    os: ("kill", "killpg", "pread", "pwrite", "posix_fallocate", "sched_getaffinity", "getloadavg", "fork"),
    signal: ("pthread_kill", "pthread_sigmask", "alarm", "setitimer"),
}


def lacking(name, function):
    """The function to all others, and none to us."""

    @functools.wraps(function)
    def asked(*arguments, **named):
        caller = sys._getframe(1).f_globals.get("__name__", "")
        if caller.split(".")[0] in OURS:
            raise AttributeError(f"{caller} calls {name}, which Windows does not have")
        return function(*arguments, **named)

    return asked


for module, names in LACKING.items():
    for name in names:
        setattr(module, name, lacking(f"{module.__name__}.{name}", getattr(module, name)))
for name in ("fcntl", "resource", "pwd", "grp", "termios"):
    sys.modules[name] = None
# filelock then locks by a file's being there, as it does where a disk knows no locks, and says so.
warnings.filterwarnings("ignore", "only soft file lock is available")


class Popen(subprocess.Popen):
    """Takes what Windows takes."""

    def __init__(self, *arguments, creationflags=0, **named):
        assert not {"process_group", "start_new_session", "preexec_fn", "pass_fds"} & named.keys()
        # The nearest thing that Linux has to what the flags ask for.
        super().__init__(*arguments, **named, process_group=0 if creationflags & 0x200 else None)


subprocess.Popen = Popen
subprocess.CREATE_NEW_PROCESS_GROUP, subprocess.CREATE_NO_WINDOW = 0x200, 0x8000000
system.WINDOWS = True
