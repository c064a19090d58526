"""Contenders that run in turn, round after round: what disturbs the machine disturbs all alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import attrs

from pavemark.accuracy.apart import Answer
from pavemark.accuracy.watcher import Watcher
from pavemark.errors import InputError


@attrs.frozen
class Contender:
    """One setting of one way to do a thing.

    Attributes
    ----------
    problem : str
        What is to be done; contenders of one problem are held against each other.
    family : str
        The way.
    setting : str
        What its knob is set to; "" where it has none.
    ships : bool
        Whether it is what Pavemark does unless told otherwise.
    """

    problem: str
    family: str
    setting: str = ""
    ships: bool = False

    def __str__(self) -> str:
        return f"{self.family} {self.setting}".rstrip()


@attrs.frozen(eq=False)
class Run:
    """What came of a contender.

    Attributes
    ----------
    contender : Contender
    value : Any
        What it made, the first time.
    seconds : tuple of float
        Processor time of each round; the first time, which loads and warms what it needs, is in none.
    """

    contender: Contender
    value: Any
    seconds: tuple[float, ...]


@attrs.frozen
class Failure:
    """A contender that does not run here, and why."""

    contender: Contender
    reason: str


def race(
    contenders: Sequence[Contender], ask: Callable[[Contender], Answer], rounds: int, watcher: Watcher
) -> tuple[list[Run], list[Failure]]:
    """Let all contenders run in turn, round after round.

    Parameters
    ----------
    contenders : sequence of Contender
    ask : callable
        Lets one run; raises `InputError` where it cannot.
    rounds : int
    watcher : Watcher

    Returns
    -------
    runs : list of Run
    failed : list of Failure
        What did not run the first time.

    Raises
    ------
    InputError
        When one fails that ran the first time.
    """
    values, failed = {}, []
    with watcher.of(len(contenders) * (rounds + 1)):
        for contender in contenders:
            try:
                values[contender] = ask(contender).value
            except InputError as error:
                failed.append(Failure(contender, " ".join(str(error).split())))
            watcher.step(False)
        seconds = {contender: [] for contender in values}
        for _ in range(rounds):
            for contender in contenders:
                if contender in values:
                    seconds[contender].append(ask(contender).seconds)
                watcher.step(False)
    return [Run(contender, value, tuple(seconds[contender])) for contender, value in values.items()], failed
