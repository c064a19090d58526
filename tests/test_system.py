"""What differs by system stands in one module, and the others do without what Windows lacks."""

import ast
import errno
import json
import os
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from commandline import contents, gone, pavemark, start, wait_until, workers_of
from pavemark import files, system
from pavemark.errors import InputError
from pavemark.job.journal import Journal, Shard
from pavemark.job.preview import _mask

ROOT = Path(__file__).parents[1]
SYSTEM = ROOT / "pipeline" / "pavemark" / "system.py"
FILES = SYSTEM.with_name("files.py")
ALL = [
    path
    for folder in (SYSTEM.parent, ROOT / "blender_addon")
    for path in sorted(folder.rglob("*.py"))
    if path != SYSTEM
] + [ROOT / "render.py"]

MODULES = {
    *("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "posix", "readline", "curses"),
    *("msvcrt", "winreg", "winsound", "_winapi", "ctypes", "psutil"),
}
NAMES = {
    "os": {
        *(
            "pread",
            "preadv",
            "pwrite",
            "pwritev",
            "kill",
            "killpg",
            "fork",
            "forkpty",
            "posix_fallocate",
            "posix_fadvise",
        ),
        *("sched_getaffinity", "sched_setaffinity", "getloadavg", "getuid", "geteuid", "getgid", "getegid", "getpgid"),
        *("setsid", "setpgid", "setpgrp", "chown", "lchown", "fchown", "fchmod", "mkfifo", "mknod", "statvfs"),
        *("fstatvfs", "uname", "wait", "wait3", "wait4", "waitid", "nice", "sysconf", "confstr", "lockf", "sendfile"),
        *(
            "sync",
            "fdatasync",
            "symlink",
            "link",
            "set_blocking",
            "ftruncate",
            "O_DIRECTORY",
            "O_NOFOLLOW",
            "O_CLOEXEC",
        ),
        *("O_SYNC", "O_NONBLOCK", "WIFSIGNALED", "WTERMSIG", "name"),
    },
    "signal": {
        *("pthread_kill", "pthread_sigmask", "sigwait", "sigpending", "alarm", "setitimer", "pause", "siginterrupt"),
        *("SIGKILL", "SIGHUP", "SIGUSR1", "SIGUSR2", "SIGCHLD", "SIGPIPE", "SIGALRM", "CTRL_C_EVENT", "SIGBREAK"),
    },
    "sys": {"platform", "getwindowsversion"},
    "platform": {"system", "win32_ver", "mac_ver", "uname"},
    # By the local code page, on Windows.
    "cv2": {"imread", "imwrite"},
}
KEYWORDS = {"process_group", "start_new_session", "preexec_fn", "pass_fds", "creationflags", "startupinfo"}


def _name(path):
    return str(path.relative_to(ROOT))


def of_one_system(tree):
    """What in a file other systems do not have, or do otherwise: (line, what)."""
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 0)
        if isinstance(node, ast.Import):
            yield from ((line, alias.name) for alias in node.names if alias.name.split(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names = NAMES.get(node.module, set())
            yield from ((line, f"{node.module}.{alias.name}") for alias in node.names if alias.name in names)
            if node.module.split(".")[0] in MODULES:
                yield line, node.module
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.attr in NAMES.get(node.value.id, ()):
                yield line, ast.unparse(node)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if re.match(r"(/proc|/dev|/tmp|/sys)\b", node.value):
                yield line, node.value
        elif isinstance(node, ast.Call):
            yield from ((line, word.arg) for word in node.keywords if word.arg in KEYWORDS)
            yield from text(node)


def text(call):
    """What in a call depends on the local code page, line ends or drives: (line, what)."""
    called, told = ast.unparse(call.func), {word.arg for word in call.keywords}
    short = called.rpartition(".")[2]
    modes = [each.value for each in call.args if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    if short == "read_text" and "encoding" not in told:
        yield call.lineno, "read_text by the code page"
    if short == "write_text" and not {"encoding", "newline"} <= told:
        yield call.lineno, "write_text with the system's line ends"
    written = short in {"open", "fdopen"} and any(re.fullmatch(r"[wax]\+?t?", mode) for mode in modes)
    if written and not {"encoding", "newline"} <= told:
        yield call.lineno, "text with the system's line ends"
    # What os.open gives has the system's line ends on Windows.
    if called == "os.open" and ast.unparse(call.args[0]) != "os.devnull":
        yield call.lineno, called
    if short == "relpath":
        yield call.lineno, "no path leads to another drive"
    if short == "str" and any(isinstance(each, ast.Call) and "relative_to" in ast.unparse(each) for each in call.args):
        yield call.lineno, "a name with the system's separator"


@pytest.mark.parametrize("path", ALL, ids=_name)
def test_what_differs_by_system_stands_in_one_module(path):
    found = list(of_one_system(ast.parse(path.read_text(encoding="utf-8"))))
    if path == FILES:
        found = [what for what in found if what[1] != "no path leads to another drive"]
    assert found == []


@pytest.mark.parametrize(
    "line",
    [
        "import fcntl",
        "import resource",
        "from pwd import getpwuid",
        "import psutil",
        "os.pread(f, 1, 0)",
        "os.kill(pid, 0)",
        "from os import kill",
        "os.posix_fallocate(f, 0, 1)",
        "os.sched_getaffinity(0)",
        "os.name == 'nt'",
        "sys.platform",
        "signal.pthread_kill(i, 2)",
        "signal.SIGKILL",
        "Popen(command, process_group=0)",
        "Popen(command, start_new_session=True)",
        "Path('/proc/self/status')",
        "Path('/dev/shm')",
        "os.open(path, os.O_RDONLY)",
        "path.read_text()",
        "path.write_text(line, encoding='utf-8')",
        "path.open('w', encoding='utf-8')",
        "open(path, 'a')",
        "os.path.relpath(a, b)",
        "str(path.relative_to(out))",
        "cv2.imread(path)",
    ],
)
def test_the_rule_finds_what_it_forbids(line):
    assert list(of_one_system(ast.parse(line)))


@pytest.mark.parametrize(
    "line",
    [
        "signal.signal(signal.SIGINT, stop)",
        "path.open('rb')",
        "path.open('a', encoding='utf-8', newline='\\n')",
        "os.open(os.devnull, os.O_WRONLY)",
        "path.relative_to(out).as_posix()",
        "'a/proc'",
    ],
)
def test_the_rule_allows_what_all_systems_have(line):
    assert not list(of_one_system(ast.parse(line)))


# A whole job without it.


@pytest.fixture(scope="module")
def bare():
    """The environment of processes that lack what Windows lacks."""
    found = [ROOT / "tests" / "no_posix", ROOT / "pipeline", ROOT]
    return {"PYTHONPATH": os.pathsep.join(map(str, found))}


def test_the_stand_in_lacks_what_windows_lacks(bare):
    script = (
        "import os, sys; globals()['__name__'] = 'pavemark.job.journal'\n"
        "for call in (lambda: os.kill(os.getpid(), 0), lambda: os.pread(0, 1, 0), lambda: __import__('fcntl')):\n"
        "    try: call()\n"
        "    except (AttributeError, ImportError): continue\n"
        "    sys.exit('it is there')\n"
        "from pavemark import system; print(system.WINDOWS)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], env={**os.environ, **bare}, capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("True\n", "")


def test_a_job_is_the_same_without_it(arguments, bare, tmp_path):
    first = pavemark(*arguments, "--out", tmp_path / "a")
    second = pavemark(*arguments, "--out", tmp_path / "b", **bare)
    assert (first.returncode, second.returncode, second.stderr) == (0, 0, "")
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    journal = (tmp_path / "b" / "journal" / "0-of-1.jsonl").read_bytes()
    assert journal.count(b"\n") == 10 and b"\r" not in journal
    again = pavemark(*arguments, "--out", tmp_path / "b", **bare)
    assert again.returncode == 0 and "0 of them made now" in again.stdout


def test_without_it_one_run_writes_and_its_workers_end_with_it(arguments, bare, tmp_path):
    out = tmp_path / "out"
    run = start(*arguments, "--out", out, FLAT_RENDERER="hang@0", **bare)
    assert wait_until((out / "job.json").exists)
    second = pavemark(*arguments, "--out", out, **bare)
    assert (second.returncode, second.stderr) == (2, f"error: {out}: another run is writing to it\n")
    assert wait_until(lambda: workers_of(run.pid))
    crew = workers_of(run.pid)
    run.kill()
    run.communicate()
    assert wait_until(lambda: all(map(gone, crew))), "a stuck worker outlives its run"
    assert pavemark(*arguments, "--out", out, **bare).returncode == 0


def test_without_it_a_run_stops_by_ctrl_c_and_by_its_leash_and_goes_on(arguments, bare, tmp_path):
    out = tmp_path / "out"
    for made, leash in enumerate(([], ["--leash"]), 1):
        command = [sys.executable, str(ROOT / "tests" / "flat_renderer.py"), *map(str, arguments)]
        run = subprocess.Popen(
            [*command, "--count", "200", "--out", out, *leash],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **bare},
        )
        # The second run finds the first one's images before it has started anyone.
        assert wait_until(
            lambda made=made, run=run: len(list(out.glob("images/0*.png"))) > made and workers_of(run.pid)
        )
        crew = workers_of(run.pid)
        if leash:
            run.stdin.close()
        else:
            run.send_signal(signal.SIGINT)
        assert run.wait(60) == 130, run.stderr.read()
        assert crew and all(map(gone, crew))
        rows = (out / "manifest.jsonl").read_text().splitlines()
        assert made < len(rows) < 200 and "the same command goes on" in run.stdout.read()
        assert [json.loads(row)["index"] for row in rows] == list(range(len(rows)))


# Its parts.


@pytest.fixture
def windows(monkeypatch):
    monkeypatch.setattr(system, "WINDOWS", True)
    monkeypatch.setattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0x200, raising=False)
    monkeypatch.setattr(subprocess, "CREATE_NO_WINDOW", 0x8000000, raising=False)


def test_a_process_apart_is_told_by_flags_on_windows(windows):
    assert system.apart() == {"creationflags": 0x8000200}


def test_a_process_apart_has_a_group_of_its_own_elsewhere(monkeypatch):
    monkeypatch.setattr(system, "WINDOWS", False)
    assert system.apart() == {"process_group": 0}


def test_to_ask_for_a_process_does_not_end_it():
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    assert system.alive(process.pid)
    assert process.poll() is None
    process.communicate(b"\n")
    assert process.returncode == 0 and not system.alive(process.pid)


def test_a_file_that_someone_reads_is_replaced_once_he_is_done(windows, monkeypatch, tmp_path):
    (tmp_path / "job.json").write_text("old")
    refused, slept = [], []
    replaced = Path.replace

    def replace(source, target):
        if len(refused) < 3:
            refused.append(target)
            raise PermissionError(errno.EACCES, "The process cannot access the file")
        return replaced(source, target)

    monkeypatch.setattr(Path, "replace", replace)
    monkeypatch.setattr(system.time, "sleep", slept.append)
    files.write(tmp_path / "job.json", "new")
    assert (tmp_path / "job.json").read_text() == "new"
    assert len(refused) == len(slept) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["job.json"]


def test_a_file_that_is_never_let_go_is_told_after_some_patience(windows, monkeypatch, tmp_path):
    (tmp_path / "job.json").write_text("old")
    slept = []

    def replace(source, target):
        raise PermissionError(errno.EACCES, "The process cannot access the file")

    monkeypatch.setattr(Path, "replace", replace)
    monkeypatch.setattr(system.time, "sleep", slept.append)
    with pytest.raises(InputError, match=r"job\.json: cannot be written: The process cannot access"):
        files.write(tmp_path / "job.json", "new")
    assert sum(slept) == pytest.approx(system.PATIENCE)
    assert (tmp_path / "job.json").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["job.json"]


def test_elsewhere_nothing_is_waited_for(monkeypatch, tmp_path):
    monkeypatch.setattr(system, "WINDOWS", False)
    monkeypatch.setattr(system.time, "sleep", lambda _: pytest.fail("waited"))
    (tmp_path / "a").mkdir()
    (tmp_path / "b").touch()
    with pytest.raises(OSError):
        system.replace(tmp_path / "a", tmp_path / "b")


@pytest.mark.parametrize("size", [0, 1, system._PART, 2 * system._PART + 5])
def test_room_is_had_without_fallocate_and_what_is_there_stays(monkeypatch, tmp_path, size):
    monkeypatch.delattr(os, "posix_fallocate", raising=False)
    path = tmp_path / "pool"
    with path.open("w+b") as stream:
        stream.write(b"head"[:size])
        stream.truncate(size)
        system.reserve(stream)
    assert path.stat().st_size == size
    assert path.read_bytes() == b"head"[:size].ljust(size, b"\0")
    assert path.stat().st_blocks * 512 >= size


def test_no_room_is_an_error_without_fallocate(monkeypatch):
    monkeypatch.delattr(os, "posix_fallocate", raising=False)
    monkeypatch.setattr(os, "fstat", lambda _: SimpleNamespace(st_size=1))
    with Path("/dev/full").open("r+b", buffering=0) as full, pytest.raises(OSError, match="No space left"):
        system.reserve(full)


def test_cores_are_those_that_may_be_used(monkeypatch):
    first = sorted(os.sched_getaffinity(0))[:1]
    asked = subprocess.run(
        [sys.executable, "-c", f"import os; os.sched_setaffinity(0, {first}); from pavemark import system; "
         "print(system.cores())"],
        env={**os.environ, "PYTHONPATH": str(ROOT / "pipeline")}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert asked.stdout == "1\n"
    monkeypatch.setattr(psutil, "Process", SimpleNamespace)  # as on macOS
    assert system.cores() == os.cpu_count()


def test_most_memory_is_told(monkeypatch):
    before = system.peak()
    held = np.ones(round(before * 1e6), np.uint8)
    assert 1.1 * before < system.peak() <= 2.1 * before
    del held
    monkeypatch.setattr(psutil, "Process", lambda: SimpleNamespace(memory_info=lambda: SimpleNamespace(peak_wset=7e6)))
    assert system.peak() == 7.0  # as on Windows


def test_a_pipe_that_nobody_reads(monkeypatch):
    invalid = OSError(errno.EINVAL, "Invalid argument")
    assert system.reader_gone(BrokenPipeError(errno.EPIPE, "Broken pipe"))
    monkeypatch.setattr(system, "WINDOWS", False)
    assert not system.reader_gone(invalid)
    monkeypatch.setattr(system, "WINDOWS", True)
    assert system.reader_gone(invalid)
    assert not system.reader_gone(OSError(errno.ENOSPC, "No space left on device"))


# Paths.


def test_a_path_of_another_drive_is_absolute(monkeypatch, tmp_path):
    assert files.relative(tmp_path / "a" / "b", tmp_path / "c") == "../a/b"

    def relpath(path, start):
        raise ValueError("path is on mount 'D:', start on mount 'C:'")

    monkeypatch.setattr(os.path, "relpath", relpath)
    assert files.relative(tmp_path / "a", tmp_path / "c") == (tmp_path / "a").as_posix()


def test_a_drive_that_is_not_there_is_told(monkeypatch):
    monkeypatch.setattr(Path, "exists", lambda self: False)
    with pytest.raises(InputError, match=r"/out: cannot be written: there is no such drive"):
        files.writable(Path("/out"))


def test_a_mask_is_read_by_any_name(tmp_path):
    path = tmp_path / "停车位 ö.png"
    mask = np.zeros((8, 8), np.uint16)
    mask[2:5, 3] = 40_000
    path.write_bytes(files.png(mask))
    assert np.array_equal(_mask(path), mask)
    for data in (b"", b"no image"):
        path.write_bytes(data)
        with pytest.raises(InputError, match="is not an image"):
            _mask(path)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        _mask(tmp_path / "gone.png")


def test_the_journal_is_read_while_it_is_written(tmp_path):
    """On Windows what is locked cannot be read: the lock is on another file."""
    with Journal(tmp_path, Shard()) as kept:
        kept.append(0, {"index": 0}, None)
        names = {path.name for path in (tmp_path / "journal").iterdir()}
        assert names == {"0-of-1.jsonl", "0-of-1.lock"}
        assert (tmp_path / "journal/0-of-1.jsonl").read_bytes() == b'0\t{"index":0}\tnull\n'


def test_a_journal_of_another_thread_is_not_entered(tmp_path):
    told = []

    def write():
        try:
            Journal(tmp_path, Shard())
        except InputError as error:
            told.append(str(error))

    with Journal(tmp_path, Shard()):
        other = threading.Thread(target=write)
        other.start()
        other.join(10)
    assert told == [f"{tmp_path}: another run is writing to it"]
