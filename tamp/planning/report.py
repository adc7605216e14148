"""What a run cost and tried: numbers for each stream and each skeleton, as a table and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

N = TypeVar("N", int, float)


@dataclass(frozen=True, slots=True)
class StreamReport:
    """How one stream did. `failures` are its samplers' reasons and how often each was given, most frequent first."""

    name: str
    calls: int
    successes: int
    seconds: float
    failures: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True)
class SkeletonReport:
    """One skeleton: its actions, how often it was tried, whether it was bound, and where and why it broke last."""

    actions: tuple[str, ...]
    attempts: int
    bound: bool
    broke_at: str = ""
    reason: str = ""


@dataclass(frozen=True)
class Report:
    """What a run of the planner did.

    Attributes:
        seconds: phase ("grounding", "search", "binding", "sampling") -> time [s]; sampling is no part of the others.
        streams: one for each stream of the problem, in the order of its file.
        skeletons: in the order in which they were first tried.
        counts: "iterations", "searches", "operators" (of the last search), "instances".
        message: one sentence on how it ended.
        strategy: which part of the problem was asked when, by name, with the options of the strategy.
    """

    algorithm: str
    status: str
    cost: float
    total_s: float
    seconds: Mapping[str, float]
    streams: tuple[StreamReport, ...]
    skeletons: tuple[SkeletonReport, ...]
    counts: Mapping[str, int] = field(default_factory=dict)
    message: str = ""
    strategy: Mapping[str, Any] = field(default_factory=lambda: {"name": "all-at-once"})

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON-like data; an infinite cost is None."""
        return {
            "algorithm": self.algorithm,
            "strategy": dict(self.strategy),
            "status": self.status,
            "cost": None if self.cost == float("inf") else self.cost,
            "total_s": self.total_s,
            "seconds": dict(self.seconds),
            "counts": dict(self.counts),
            "message": self.message,
            "streams": [
                {
                    "name": s.name,
                    "calls": s.calls,
                    "successes": s.successes,
                    "seconds": s.seconds,
                    "failures": [{"reason": reason, "count": count} for reason, count in s.failures],
                }
                for s in self.streams
            ],
            "skeletons": [
                {
                    "actions": list(k.actions),
                    "attempts": k.attempts,
                    "bound": k.bound,
                    "broke_at": k.broke_at,
                    "reason": k.reason,
                }
                for k in self.skeletons
            ],
        }

    def __str__(self) -> str:
        phases = ", ".join(f"{name} {seconds:.3f} s" for name, seconds in self.seconds.items())
        counts = ", ".join(f"{count} {name}" for name, count in self.counts.items())
        lines = [
            f"{self.algorithm}: {self.status} in {self.total_s:.3f} s, cost {self.cost:g}. {self.message}".rstrip()
        ]
        lines += [f"  {phases}", f"  {counts}", ""]
        lines.append(f"  {'stream':<26} {'calls':>7} {'found':>7} {'seconds':>9}  most frequent failure")
        for s in self.streams:
            failure = f"{s.failures[0][1]} x {s.failures[0][0]}" if s.failures else ""
            lines.append(f"  {s.name:<26} {s.calls:>7} {s.successes:>7} {s.seconds:>9.3f}  {failure}".rstrip())
        for i, k in enumerate(self.skeletons):
            end = "bound" if k.bound else f"broke at {k.broke_at}: {k.reason}"
            lines.append(f"  skeleton {i + 1}: {len(k.actions)} actions, {k.attempts} attempts, {end}")
        return "\n".join(lines)


def combined(reports: Sequence[Report], status: str) -> Report:
    """Several runs of the planner as one: what they cost in sum; skeletons and message are those of the longest."""
    longest = max(reports, key=lambda report: report.total_s)
    return replace(
        longest,
        status=status,
        total_s=sum(report.total_s for report in reports),
        seconds=_sum([report.seconds for report in reports]),
        streams=_streams([stream for report in reports for stream in report.streams]),
        counts={**_sum([report.counts for report in reports]), "operators": longest.counts.get("operators", 0)},
    )


def _streams(parts: Sequence[StreamReport]) -> tuple[StreamReport, ...]:
    """One for each name, in the order in which they first come."""
    by_name: dict[str, list[StreamReport]] = {}
    for part in parts:
        by_name.setdefault(part.name, []).append(part)
    found = []
    for name, runs in by_name.items():
        failures = _sum([dict(run.failures) for run in runs])
        ranked = tuple(sorted(failures.items(), key=lambda each: -each[1]))
        calls, successes = sum(run.calls for run in runs), sum(run.successes for run in runs)
        found.append(StreamReport(name, calls, successes, sum(run.seconds for run in runs), ranked))
    return tuple(found)


def _sum(parts: Sequence[Mapping[str, N]]) -> dict[str, N]:
    """Numbers added by their names, in the order in which they first come."""
    total: dict[str, N] = {}
    for part in parts:
        for name, value in part.items():
            total[name] = total.get(name, 0) + value
    return total
