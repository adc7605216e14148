"""Why a solution has no plan, in words."""

from __future__ import annotations

from tamp.planning import Solution


def reason(solution: Solution) -> str:
    """Where the skeleton that was tried most broke; without one, the commonest failure of any stream; in words."""
    broken = [skeleton for skeleton in solution.report.skeletons if skeleton.reason]
    if broken:
        most = max(broken, key=lambda skeleton: skeleton.attempts)
        return f"{solution.status}; {most.broke_at}: {most.reason}"
    streams = [s for s in solution.report.streams if s.failures]
    if not streams:
        return solution.status
    worst = max(streams, key=lambda s: s.failures[0][1])
    return f"{solution.status}; {worst.name}: {worst.failures[0][0]}"
