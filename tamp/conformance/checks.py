"""Checks one after the other, each told in one sentence, and the asking of what may raise, hang or print."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout
from typing import Literal, TypeVar

from tamp import clock
from tamp.conformance.findings import Finding, PartJudgement
from tamp.errors import TampError, told

PATIENCE_S = 20.0
"""What goes on for so long past its own limit is broken off [s]."""

Said = tuple[Literal["ok", "note"], str]
Check = tuple[str, Callable[[], Said]]
Answer = TypeVar("Answer")


class Fault(Exception):  # noqa: N818  control flow of the kits: what is wrong, as a sentence
    """Ends a check."""


def judged(kind: str, name: str, checks: Iterable[Check]) -> PartJudgement:
    """What checks say, up to the first that finds a fault."""
    findings: list[Finding] = []
    for check, function in checks:
        findings.append(_finding(check, function))
        if findings[-1].outcome == "wrong":
            break
    return PartJudgement(kind, name, tuple(findings))


def _finding(check: str, function: Callable[[], Said]) -> Finding:
    try:
        return Finding(check, *function())
    except Fault as fault:
        return Finding(check, "wrong", str(fault))


def asked(what: str, ask: Callable[[], Answer], limit: float = 0.0) -> Answer:
    """The answer to a question.

    Args:
        what: it is, to begin a sentence with; may be empty.
        ask: asks it.
        limit: the time that it was given [s].

    Raises:
        Fault: where it raises, does not come back, or prints.
    """
    printed, patience, begin = io.StringIO(), limit + PATIENCE_S, f"{what}: " if what else ""
    try:
        with clock.ended_at(clock.now() + patience), redirect_stdout(printed):
            answer = ask()
    except clock.TimeUp:
        late = f", its limit being {limit:g} s" if limit else ""
        raise Fault(f"{begin}it had not come back after {patience:g} s{late}") from None
    except Fault:
        raise
    except TampError as error:
        raise Fault(f"{begin}{error}") from error
    except (Exception, SystemExit) as error:
        raise Fault(f"{begin}it raised {told(error)}") from error
    if printed.getvalue():
        raise Fault(f"{begin}it printed {printed.getvalue()[:60]!r}; standard output belongs to whoever asks")
    return answer
