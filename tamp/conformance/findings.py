"""What the kit has found, as data and in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal


@dataclass(frozen=True, slots=True)
class Finding:
    """One check and its outcome: "ok", "note" (worth knowing, not wrong) or "wrong"."""

    check: str
    outcome: Literal["ok", "note", "wrong"]
    text: str


@dataclass(frozen=True)
class Judgement:
    """All findings on one sampler.

    Attributes:
        sampler: its address or name.
        stream: the stream it was held against.
        findings: in the order of the checks.
        numbers: what was measured: calls, outputs, milliseconds an output, shares that pass downstream.
        details: what came of each call, line by line, and tracebacks.
    """

    sampler: str
    stream: str
    findings: tuple[Finding, ...]
    numbers: Mapping[str, Any] = field(default_factory=dict)
    details: tuple[str, ...] = ()

    @property
    def fits(self) -> bool:
        """Whether nothing is wrong."""
        return all(finding.outcome != "wrong" for finding in self.findings)

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values."""
        findings = [{"check": f.check, "outcome": f.outcome, "text": f.text} for f in self.findings]
        return {
            "sampler": self.sampler, "stream": self.stream, "fits": self.fits, "findings": findings,
            "numbers": dict(self.numbers), "details": list(self.details),
        }  # fmt: skip

    def __str__(self) -> str:
        lines = [f"{self.sampler} as {self.stream}"]
        lines += [f"  {f.outcome:5s}  {f.check:12s}  {f.text}" for f in self.findings]
        wrong = sum(f.outcome == "wrong" for f in self.findings)
        return "\n".join([*lines, "it fits" if self.fits else f"{wrong} thing{'s' * (wrong > 1)} wrong"])


@dataclass(frozen=True)
class PartJudgement:
    """All findings on a search, a strategy, a simulator or a skill.

    Attributes:
        kind: "search", "strategy", "simulator" or "skill".
        name: its address or name.
        findings: in the order of the checks; what is wrong ends them, since later ones would mean nothing.
    """

    kind: str
    name: str
    findings: tuple[Finding, ...]

    @property
    def fits(self) -> bool:
        """Whether nothing is wrong."""
        return all(finding.outcome != "wrong" for finding in self.findings)

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values."""
        findings = [{"check": f.check, "outcome": f.outcome, "text": f.text} for f in self.findings]
        return {self.kind: self.name, "fits": self.fits, "findings": findings}

    def __str__(self) -> str:
        lines = [f"  {f.outcome:5s}  {f.check:12s}  {f.text}" for f in self.findings]
        return "\n".join([f"{self.kind} {self.name}", *lines, "it fits" if self.fits else "1 thing wrong"])
