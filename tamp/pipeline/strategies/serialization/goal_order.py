"""A search for the order of goals: which is asked for next, and how hard it is tried."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Container, Mapping, Sequence
from dataclasses import replace

from tamp import clock
from tamp.pipeline.strategies.known import NOTHING, Known
from tamp.pipeline.strategies.serialization.clear_space import make_room, stuck
from tamp.pipeline.strategies.serialization.feasibility import Prospects, barred, clearest_first
from tamp.pipeline.strategies.serialization.goal_stability import GoalStability
from tamp.pipeline.strategies.serialization.goal_status import BroughtNear, GoalStatus
from tamp.pipeline.strategies.serialization.nearest_placement import bring_near
from tamp.pipeline.strategies.serialization.turning_over import turn_over
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.goal_graph import (
    Placements,
    asking_for,
    goal_supports,
    supports_first,
    surroundings,
    takes_room,
    under_goal,
)
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, LAST, Asker, Effort, reason
from tamp.planning import Report, Solution, combined
from tamp.streams.affordances.stack_balance import tips_with
from tamp.streams.values import Placement

UNLIMITED = 1_000_000
REST = 0.3  # of what a try for all goals gets goes to one for those that single tries have left: it succeeds soon
ALONE = 0.5  # of what a goal gets for which others may move goes to it while they do not


class Ordering:
    """A search for the order of goals.

    Args:
        attempt: the state it starts from.
        seed: decides every random choice.
        deadline: on the clock of tamp.clock.now() [s].
        algorithm: of the stream planner.
        known: of single objects.
    """

    def __init__(
        self,
        attempt: Attempt,
        seed: int,
        deadline: float,
        algorithm: str,
        known: Known = NOTHING,
    ) -> None:
        self._midst = (clock.now() + deadline) / 2
        start = attempt.workspace.start
        unturned = {name: start[name] for name in known.unturned}
        progress = Progress(attempt, unsteady=known.unsteady)
        self._asker = Asker(progress, seed, deadline, algorithm, unturned=unturned)
        self._prospects = Prospects(self._asker, {name: (start[name], why) for name, why in known.hopeless.items()})
        self._goal_status = GoalStatus(self._asker, known.unsteady)
        self._stability = GoalStability(self._asker, self._goal_status.reached)
        self._brought_near = BroughtNear(self._prospects)
        self._together: list[Report] = []
        self._vain: dict[str, Placements] = {}
        self._upsetting: dict[str, Placements] = {}
        self._tries = Counter[str]()
        self._turned = set[str]()
        self._begin = attempt
        self._first: list[str] = []
        self._former: list[tuple[Progress, dict[str, str], set[str]]] = []

    @property
    def left(self) -> dict[str, str]:
        """Objects whose goals it does not reach, and symbolic goals that it does not -> why."""
        return {**self._goal_status.left, **self._goal_status.facts}

    @property
    def _left(self) -> dict[str, str]:
        return self._goal_status.left

    @property
    def report(self) -> Report:
        """Of all that was asked, in sum; its status is that of the longest search for all goals that were left."""
        if not self._asker.reports:
            return Report(self._asker.algorithm, "solved", 0.0, 0.0, {}, (), (), message="All is where it shall be.")
        longest = max(self._together, key=lambda report: report.total_s, default=None)
        unasked = "timeout" if self.cut_short else "failed"
        ended = unasked if longest is None else longest.status
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
    def unturned(self) -> Mapping[str, Placement]:
        """Objects that two grasps do not turn over -> from where."""
        return self._asker.unturned

    @property
    def progress(self) -> Progress:
        """The plan so far."""
        return self._asker.progress

    def run(self, *, persistent: bool = False) -> None:
        """Reach as many goals as the time allows.

        Args:
            persistent: whether all goals at once are sought until time is up where some are left.
        """
        self._reach_objects(persistent)
        if self._goal_status.facts and not self._asker.late:
            self._reach_facts()

    def _reach_facts(self) -> None:
        """Reach the symbolic goals in one question, what objects have reached included."""
        wanted = self._goal_status.reached | self._goal_status.facts.keys()
        solution = self._asker.ask(asking_for(self._asker.workspace, wanted), UNLIMITED, None)
        refused = reason(solution) if solution.plan is None else self._asker.refused(solution.plan)
        self._goal_status.facts = {} if refused is None else dict.fromkeys(self._goal_status.facts, refused)

    def _reach_objects(self, persistent: bool) -> None:
        begin, task = self.progress.now, self.progress.now.setup.task
        if task.goal or any(takes_room(begin.workspace, obj.goal) for obj in task.objects):
            with self._asker.within(self._asker.tuning.together_share):
                if self._all_together(self._asker.tuning.together_iterations):
                    return
        self._goal_status.reach_troublesome()
        with self._asker.within(1.0 if persistent else self._asker.tuning.goals_share):
            while self._try_each(EFFORTS[0], stuck(self._asker.workspace, self._left)):
                pass
        impossible = any(map(self._prospects.impossible, self._left))
        if not self._left or (impossible and persistent):
            return
        with self._asker.within(REST * self._asker.tuning.together_share):
            # What is at its goal stays there if it can: plans that take it away again are long, and much may go wrong.
            staying = set() if persistent else self._goal_status.reached
            iterations = 1 if stuck(begin.workspace, self._left) else self._asker.tuning.together_iterations
            hopeless = impossible or any(map(self._stability.never_stays, self._left))
            reached = not hopeless and self._all_together(iterations, staying)
        if not reached and not persistent:
            self._reach_or_bring_near()
        if reached or not persistent:
            return
        self._reach_with_restarts((*EFFORTS, *LAST))
        if self._left and not any(map(self._stability.never_stays, self._left)):
            self._asker.progress = replace(self.progress, now=begin, actions=[], before=[], pieces=[])
            while not self._asker.late and not (self._together and self._together[-1].status == "infeasible"):
                if self._all_together(UNLIMITED) or self._together[-1].status == "failed":
                    break

    def _reach_or_bring_near(self) -> None:
        """Reach goals, bring what is left near its own, which may clear the way to others; cut what gains nothing.

        In the first half of the time nothing is brought merely near before all efforts for goals were made.
        """
        asker, self._brought_near.since = self._asker, self._midst
        for efforts in (EFFORTS, LAST):
            nearer = True
            while self._left and nearer and not asker.late:
                with asker.within(asker.tuning.goals_share):
                    self._reach_with_restarts(efforts)
                if efforts is EFFORTS and clock.now() < self._midst:
                    break  # there is time for greater ones first
                nearer = bring_near(asker, self._left.keys() & asker.workspace.goals.keys(), self._goal_status.reached)
        self.progress.cut_back()
        self._keep_the_best()

    def _reach_with_restarts(self, efforts: Sequence[Effort]) -> None:
        """Reach one goal after the other; while that leaves any, begin again with one that it has left.

        The greatest effort comes once that has been tried: to take away again what bars a goal takes longer.
        """
        for some in (efforts[:-1], efforts):
            self._reach_in_turn(some)
            while self._left and self._start_over():
                self._reach_in_turn(some)

    def _start_over(self) -> bool:
        """Reach a goal that is left from where all began, before any other; whether that was done.

        What has come to its own goal first may bar it. What has failed comes first when the plan is made again: squeaky
        wheel optimization (Joslin and Clements, Journal of Artificial Intelligence Research 10, 1999).
        """
        asker = self._asker
        for name in supports_first(asker.workspace, list(self._left)) if self.progress.actions else ():
            if asker.late:
                break
            if name in self._first or self._missing(name) or self._prospects.known_against(name):
                continue
            if self._stability.falls(name) or self._stability.never_stays(name):
                continue
            self._first.append(name)
            former = self.progress, dict(self._left), set(self._goal_status.reached)
            asker.progress = replace(self.progress, now=self._begin, actions=[], before=[], pieces=[])
            if self._reach_first(name):
                self._former.append(former)
                self._goal_status.restart()
                return True
            asker.progress = former[0]
        return False

    def _reach_first(self, name: str) -> bool:
        """Reach the goals of all that comes first by now, this one the latest, and of what they rest on."""
        asker, prospects = self._asker, self._prospects
        wanted = {other for first in self._first for other in (first, *under_goal(asker.workspace, first))}
        with asker.within(asker.tuning.one_goal_share, asker.tuning.one_goal_least_s):
            goal = asker.workspace.goals.get(name)
            if goal is not None and not self.progress.now.stays(name, goal, wanted):
                return False
            asked, known = asking_for(asker.workspace, wanted), prospects.plans.get(name)
            iterations, regrasped = EFFORTS[-1].iterations, prospects.regrasped & wanted
            solution = asker.ask(asked, iterations, None, regrasped=regrasped, about=name, known=known)
            return solution.plan is not None and asker.refused(solution.plan, name) is None

    def _keep_the_best(self) -> None:
        """Of all plans that were made, from the same beginning, let that be the plan which leaves the table best."""
        for progress, left, reached in self._former:
            if progress.shortfall < self.progress.shortfall:
                self._asker.progress = progress
                self._goal_status.resume(left, reached)

    def _reach_in_turn(self, efforts: Sequence[Effort]) -> None:
        """Reach one goal after the other, with growing effort, but with little for what is nearly there."""
        level = 0
        while self._left and level < len(efforts) and not self._asker.late:
            level = 0 if self._reach_or_make_room(efforts[level]) else level + 1
        self._goal_status.reach_near(list(self._left))

    def _reach_or_make_room(self, effort: Effort) -> bool:
        """Reach goals, or count as reached what is near, or make room where hands lack it; whether anything came of it.

        Crowded objects come last. That they look stuck is a guess: to try each takes less time than to seek a nudge.
        """
        crowded = set() if effort.others_move else stuck(self._asker.workspace, self._left)
        if self._try_each(effort, crowded) or (crowded and self._try_each(effort, self._left.keys() - crowded)):
            return True
        near = self._goal_status.reach_near(list(self._left))
        return near or (bool(crowded) and make_room(self._asker, crowded, self._goal_status.reached))

    def _all_together(self, iterations: int, staying: Collection[str] = ()) -> bool:
        """Plan for all goals together, while some objects stay where they are; whether that succeeded."""
        workspace = self._asker.workspace
        movable = workspace.start.keys() - {*staying} if staying else None
        solution = self._asker.ask(workspace, iterations, movable, regrasped=self._prospects.regrasped)
        proven = not staying or solution.status != "infeasible"
        self._together.append(solution.report if proven else replace(solution.report, status="failed"))
        if solution.plan is None or self._asker.refused(solution.plan) is not None:
            return False
        self._goal_status.clear()
        return True

    def _try_each(self, effort: Effort, spared: Container[str] = ()) -> bool:
        """Try every goal that is left once; whether any was reached. The dearer ones end with the first that is.

        Those come first that were tried least: one that fails again and again shall not take the time of all.
        While no other object moves, what failed is not tried again before something is moved near it or its goal.
        """
        asker, progress = self._asker, False
        workspace, samplers = asker.workspace, self.progress.now.samplers
        names = supports_first(workspace, [name for name in self._left if name not in spared])
        if effort.others_move:
            names = clearest_first(workspace, names, samplers, asker.drawn_seed, asker.deadline)
            names.sort(key=self._tries.__getitem__)
        share = self._share(names, effort)
        for name in names:
            if asker.late:
                break
            if not effort.others_move and self._vain.get(name) == surroundings(workspace, name):
                continue
            with asker.within(share, asker.tuning.one_goal_least_s):
                progress |= self._try(name, effort)
            if progress and effort.others_move:
                break
        return progress

    def _try(self, name: str, effort: Effort) -> bool:
        """Plan for one more goal; whether it was reached."""
        workspace = self._asker.workspace
        start, goals = workspace.start, workspace.goals
        if missing := self._missing(name):
            self._left[name] = f"its goal rests on {missing[0]}, which is not at its own"
            return effort.others_move and self._brought_near.bring(name, self._left, self._goal_status.reached)
        if name in goals and start[name] == goals[name]:
            self._goal_status.reach(name)
            return True
        bar = self._barred(name)
        if bar is not None and not effort.others_move:
            self._left[name] = bar
            return False
        prospects = self._prospects
        # The questions for what is hopeless too are about one grasp, which turns nothing over.
        hopeless_too = effort.hopeless_too and not prospects.impossible(name)
        if not hopeless_too or (self._asker.stays_unturned(name) and prospects.turned(name)):
            against = prospects.against(name) if effort.others_move else prospects.known_against(name)
            if against is not None:
                self._left[name] = against
                brought = effort.others_move and self._brought_near.bring(name, self._left, self._goal_status.reached)
                return self._goal_status.reach_near([name]) or brought
        if bar is None and name not in self._turned and prospects.turned(name):
            self._turned.add(name)
            if self._turn_over(name, effort):
                return True
        asked = asking_for(self._asker.workspace, self._goal_status.reached | {name})
        turned = {name} if self._prospects.turned(name) and not self._asker.stays_unturned(name) else set[str]()
        always_tips = self._stability.always_tips(name)
        unsure = bar is None and (always_tips or self._stability.uncertain(name))
        if unsure and self._stability.brought_to_rest(name, turned, effort):
            return self._goal_status.reach_near([name])
        leaves = always_tips or not self._stability.stays(name, others_move=effort.others_move)
        if leaves or (unsure and self._stability.falls(name)):
            until = " before others come" if self._stability.awaited(name) else ""
            self._left[name] = f"it does not stay there{until}"
            return False
        if bar is None and self._upsetting.get(name) == surroundings(self._asker.workspace, name):
            return False
        movable, regrasped = (None, self._prospects.regrasped) if effort.others_move else ({name}, turned)
        self._tries[name] += effort.others_move
        known = self._prospects.plans.get(name) if effort.guided else None
        solution = self._asker.ask(asked, effort.iterations, movable, regrasped=regrasped, about=name, known=known)
        return self._take(name, effort, solution, turned)

    def _turn_over(self, name: str, effort: Effort) -> bool:
        """Turn an object over by one grasp on the way to its goal, or else on the table; whether either was done.

        Two grasps that do so on the way are sought last: hands must have room for both, there and at the start.
        """
        asked = asking_for(self._asker.workspace, self._goal_status.reached | {name})
        if not self._stability.uncertain(name):
            solution = self._asker.ask(asked, EFFORTS[0].iterations, {name}, about=name)
            if solution.plan is not None and self._take(name, effort, solution, ()):
                return True
        if not turn_over(self._asker, name, self._goal_status.reached):
            return False
        self._prospects.forget(name)
        return True

    def _take(self, name: str, effort: Effort, solution: Solution, turned: Collection[str]) -> bool:
        """Add the plan for a goal, or else one to where it comes to rest from there; whether it was reached.

        Or whether a part of it was added, since then something stands elsewhere than the rest was planned from.
        """
        rejected, pieces = len(self.progress.rejections), len(self.progress.pieces)
        refused = reason(solution) if solution.plan is None else self._asker.refused(solution.plan, name)
        if refused is None:
            self._goal_status.reach(name)
            return True
        self._left[name] = refused
        if len(self.progress.pieces) > pieces:
            return True
        workspace, sent_back = self._asker.workspace, len(self.progress.rejections) > rejected
        if sent_back:
            self._prospects.mislead(name)
        tips = name in workspace.goals and tips_with(workspace, name, workspace.goals[name])
        if (sent_back or tips) and self._stability.brought_to_rest(name, turned, effort):
            return self._goal_status.reach_near([name])
        if tips:
            self._upsetting[name] = surroundings(self._asker.workspace, name)
        if solution.plan is None:
            if not effort.others_move:
                self._vain[name] = surroundings(self._asker.workspace, name)
            elif solution.status == "failed":  # all samples were of no use: with others it may be a matter of a moment
                self._asker.refusals[name] += 1
            return False
        if effort.others_move:  # what is refused is tried by way of another grasp
            self._prospects.regrasped.add(name)
        return False

    def _share(self, names: Sequence[str], effort: Effort) -> float:
        """Of the time that is left, what goes to one of the goals at most: the more, the fewer wait for theirs.

        Those whose goals rest on others that are not there yet take no time; what is hopeless shall not take all.
        """
        able = sum(not self._missing(name) for name in names)
        fair = 0.0 if effort.hopeless_too else 1 / max(able, 1)
        return max(self._asker.tuning.one_goal_share * (1.0 if effort.others_move else ALONE), fair)

    def _missing(self, name: str) -> list[str]:
        """Objects that an object's goal rests on and that are not at their own."""
        workspace = self._asker.workspace
        supports = goal_supports(workspace, name)
        return [lower for lower in supports if workspace.start[lower] != workspace.goals[lower]]

    def _barred(self, name: str) -> str | None:
        """Why an object need not be tried while no other moves: that would only be found out more slowly."""
        asker = self._asker
        return barred(asker.workspace, name, self.progress.now.samplers, asker.drawn_seed(name), asker.deadline)
