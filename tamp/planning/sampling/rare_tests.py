"""Tests that mostly say no are asked at once, where assuming them would crowd the search."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from tamp.planning.model.stream_instances import Instance

CROWD = 200
"""How many instances of one test may be assumed, all of real inputs, before some of them are asked."""

SAMPLE = 20
"""How many of them, spread evenly."""

RARE = 0.25
"""Where fewer than this share hold, a plan that rests on a few of them hardly ever is one."""


@dataclass
class _Answers:
    """What is assumed of one test and what it said; the next sample is drawn at `sample_at` instances."""

    assumed: list[Instance] = field(default_factory=list)
    sample_at: int = CROWD
    asked: int = 0
    held: int = 0


class RareTests:
    """Decides which tests are asked as soon as they can be, though no plan may ever rest on them.

    An optimistic fact is as much work to ground as a call, and brings operators besides, and plans that fail.
    So where a test mostly says no, to ask it of all is no more work than to assume it. Whether it does is told by a
    sample, drawn once there are many instances of it, and again each time that there are twice as many.
    """

    def __init__(self, ask: Callable[[Instance], bool]) -> None:
        """`ask`: asks a test, lets the search know, and returns whether it holds."""
        self._ask = ask
        self._answers: dict[str, _Answers] = {}

    def take(self, test: Instance) -> bool:
        """Ask a test of real inputs where it mostly says no; whether it was asked. Otherwise it may be assumed."""
        answers = self._answers.setdefault(test.external.name, _Answers())
        if answers.held >= RARE * answers.asked:
            answers.assumed.append(test)
            if len(answers.assumed) < answers.sample_at:
                return False
            answers.sample_at = 2 * len(answers.assumed)
            self._put(answers, answers.assumed[:: len(answers.assumed) // SAMPLE])
            if answers.held >= RARE * answers.asked:
                return False
            self._put(answers, answers.assumed)
            return True
        self._put(answers, [test])
        return True

    def _put(self, answers: _Answers, tests: Iterable[Instance]) -> None:
        for test in tests:
            if not test.exhausted and not test.results:  # a plan may have rested on it meanwhile
                answers.asked += 1
                answers.held += self._ask(test)
