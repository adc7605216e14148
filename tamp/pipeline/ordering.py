"""The order in which goals are reached, and who has to step aside for them.

Goals are committed one after the other: each is planned from the state that the plan so far leaves, with all goals
reached before. First only the object itself may move, which costs little and finds the order in which nobody has to
step aside; where nothing goes that way any more, all that is left is tried together for a short while, and then others
may be put aside too, with growing effort, and first where the fewest are in the way. Before that, what lies so close
together in a container that no hand has room is nudged. Whatever brings one goal further lets all others try cheaply
again. An object that cannot reach its goal even with all others out of the way is regrasped where that helps, and else
left for last, and if it is far from its goal brought near at once. What is left in the end, and what would have stood
on it, is at least brought near its goal. What puts more aside than it gains is not done.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from tamp.pipeline.asking import Asker
from tamp.pipeline.attempt import Attempt
from tamp.pipeline.early import Early
from tamp.pipeline.efforts import EFFORTS, LAST, Effort
from tamp.pipeline.goals import asking_for, goal_supports, supports_first
from tamp.pipeline.ledger import Ledger
from tamp.pipeline.nearness import bring_near
from tamp.pipeline.nudging import make_room, stuck
from tamp.pipeline.obstacles import barred, clearest_first
from tamp.pipeline.progress import Progress
from tamp.pipeline.prospects import Prospects
from tamp.pipeline.reasons import reason
from tamp.planning import Report, combined
from tamp.streams.values import Placement

TOGETHER_SHARE = 0.13  # of the time goes to the try for all goals that are left together at most
GOALS_SHARE = 0.7  # of the rest goes to goals, what remains to what is left
ONE_SHARE = 0.4  # of that goes to one of them at most, where others may be put aside for it: the next may need less
ONE_LEAST = 4.0  # less than this would be of no use for it [s]
UNLIMITED = 1_000_000
TOGETHER = 8  # iterations of that try; where goals can be planned together, the plan is short


class Ordering:
    """A search for the order of goals.

    Args:
        attempt: the state it starts from.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
        algorithm: of the stream planner.
        hopeless: objects that do not reach their goals even alone from where they stand, by earlier searches -> why.
    """

    def __init__(
        self,
        attempt: Attempt,
        seed: int,
        deadline: float,
        algorithm: str,
        hopeless: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._asker, start = Asker(Progress(attempt), seed, deadline, algorithm), attempt.workspace.start
        self._prospects = Prospects(self._asker, {name: (start[name], why) for name, why in hopeless.items()})
        self._ledger = Ledger(self._asker)
        self._early = Early(self._prospects)
        self._together: list[Report] = []

    @property
    def left(self) -> dict[str, str]:
        """Objects whose goals it does not reach -> why."""
        return self._ledger.left

    @property
    def report(self) -> Report:
        """Of all that was asked, in sum; its status is that of the longest search for all goals that were left."""
        if not self._asker.reports:
            return Report(self._asker.algorithm, "solved", 0.0, 0.0, {}, (), (), message="All is where it shall be.")
        longest = max(self._together, key=lambda report: report.total_s, default=None)
        ended = "timeout" if longest is None else longest.status
        return combined(self._asker.reports, ended if self.left else "solved")

    @property
    def cut_short(self) -> bool:
        """Whether time was up for the search or for one of its questions."""
        return self._asker.late or any(report.status == "timeout" for report in self._asker.reports)

    @property
    def hopeless(self) -> Mapping[str, tuple[Placement, str]]:
        """Objects known not to reach their goals even alone -> from where, and why."""
        return self._prospects.hopeless

    @property
    def progress(self) -> Progress:
        """The plan so far."""
        return self._asker.progress

    def run(self, *, persistent: bool = False) -> None:
        """Reach as many goals as the time allows.

        Args:
            persistent: whether all goals at once are sought until time is up where some are left.
        """
        begin = self.progress.now
        self._ledger.reach_hard_to_grasp()
        while self._sweep(EFFORTS[0], stuck(self._asker.workspace, self.left)):
            pass
        if not self.left:
            return
        with self._asker.within(TOGETHER_SHARE):
            # What is at its goal stays there if it can: plans that take it away again are long, and much may go wrong.
            staying = set() if persistent else self._ledger.reached
            reached = self._all_together(1 if stuck(begin.workspace, self.left) else TOGETHER, staying)
        if not reached and not persistent:
            self._come_near()
        if reached or not persistent:
            return
        self._climb((*EFFORTS, *LAST))
        if self.left:
            self._asker.progress = replace(self.progress, now=begin, actions=[], before=[], pieces=[])
            while not self._asker.late and self._together[-1].status != "infeasible":
                if self._all_together(UNLIMITED):
                    break

    def _come_near(self) -> None:
        """Reach goals, bring what is left near its own, which may clear the way to others; cut what gains nothing."""
        asker = self._asker
        self._early.allowed = True
        for efforts in (EFFORTS, LAST):
            nearer = True
            while self.left and nearer and not asker.late:
                with asker.within(GOALS_SHARE):
                    self._climb(efforts)
                nearer = bring_near(asker, self.left.keys() & asker.workspace.goals.keys(), self._ledger.reached)
        self.progress.cut_back()

    def _climb(self, efforts: Sequence[Effort]) -> None:
        """Reach one goal after the other, with growing effort, but with little for what is nearly there."""
        level = 0
        while self.left and level < len(efforts) and not self._asker.late:
            advanced = self._advance(efforts[level]) or self._ledger.reach_near(list(self.left))
            level = 0 if advanced else level + 1
        self._ledger.reach_near(list(self.left))

    def _advance(self, effort: Effort) -> bool:
        """Reach goals, or make room where hands lack it; whether anything came of it. Crowded objects come last."""
        crowded = set() if effort.others_move else stuck(self._asker.workspace, self.left)
        if self._sweep(effort, crowded):
            return True
        return bool(crowded) and (make_room(self._asker, crowded, self._ledger.reached) or self._sweep(effort))

    def _all_together(self, iterations: int, staying: Collection[str] = ()) -> bool:
        """Plan for all goals together, while some objects stay where they are; whether that succeeded."""
        workspace = self._asker.workspace
        movable = workspace.start.keys() - {*staying} if staying else None
        solution = self._asker.ask(workspace, iterations, movable, regrasped=self._prospects.regrasped)
        proven = not staying or solution.status != "infeasible"
        self._together.append(solution.report if proven else replace(solution.report, status="failed"))
        if solution.plan is None or self._asker.refused(solution.plan) is not None:
            return False
        self.left.clear()
        return True

    def _sweep(self, effort: Effort, spared: Container[str] = ()) -> bool:
        """Try every goal that is left once; whether any was reached. The dearer ones end with the first that is."""
        asker, progress = self._asker, False
        workspace, samplers = asker.workspace, self.progress.now.samplers
        names = supports_first(workspace, [name for name in self.left if name not in spared])
        if effort.others_move:
            names = clearest_first(workspace, names, samplers, asker.drawn_seed, asker.deadline)
        for name in names:
            if asker.late:
                break
            with asker.within(ONE_SHARE if effort.others_move else 1.0, ONE_LEAST):
                progress |= self._try(name, effort)
            if progress and effort.others_move:
                break
        return progress

    def _try(self, name: str, effort: Effort) -> bool:
        """Plan for one more goal; whether it was reached."""
        workspace = self._asker.workspace
        start, goals = workspace.start, workspace.goals
        missing = [lower for lower in goal_supports(workspace, name) if start[lower] != goals[lower]]
        if missing:
            self.left[name] = f"its goal rests on {missing[0]}, which is not at its own"
            return effort.others_move and self._early.bring(name, self.left, self._ledger.reached)
        if name in goals and start[name] == goals[name]:
            self._ledger.reach(name)
            return True
        if not effort.others_move and (against := self._barred(name)) is not None:
            self.left[name] = against
            return False
        if not effort.hopeless_too:
            prospects = self._prospects
            against = prospects.against(name) if effort.others_move else prospects.known_against(name)
            if against is not None:
                self.left[name] = against
                brought = effort.others_move and self._early.bring(name, self.left, self._ledger.reached)
                return self._ledger.reach_near([name]) or brought
        asked = asking_for(workspace, self._ledger.reached | {name})
        movable, regrasped = (None, self._prospects.regrasped) if effort.others_move else ({name}, set[str]())
        solution = self._asker.ask(asked, effort.iterations, movable, regrasped=regrasped)
        refused = reason(solution) if solution.plan is None else self._asker.refused(solution.plan)
        if refused is not None:
            self.left[name] = refused
            if solution.plan is not None and effort.others_move:  # what is refused is tried by way of another grasp
                self._prospects.regrasped.add(name)
            return False
        self._ledger.reach(name)
        return True

    def _barred(self, name: str) -> str | None:
        """Why an object need not be tried while no other moves: that would only be found out more slowly."""
        asker = self._asker
        return barred(asker.workspace, name, self.progress.now.samplers, asker.drawn_seed, asker.deadline)
