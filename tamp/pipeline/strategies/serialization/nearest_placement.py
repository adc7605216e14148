"""Placements nearest to a goal that cannot be reached, and the feasible grasps that reach them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import compress, islice
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp import clock
from tamp.pipeline.situation import raised
from tamp.pipeline.strategies.serialization.candidate_placements import on_table, settled, straight_ahead, substitutes
from tamp.pipeline.strategies.serialization.feasibility import turned_over
from tamp.pipeline.strategies.subproblems.goal_graph import (
    asking_to,
    away,
    farthest_first,
    nearly_there,
)
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker, Effort, while_others_stay
from tamp.planning import Context
from tamp.streams.affordances.falls import drops
from tamp.streams.affordances.slide_path import slidable
from tamp.streams.affordances.stable_poses import amid
from tamp.streams.affordances.stack_balance import tips_with
from tamp.streams.affordances.tilts import layable
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.collisions import overlap
from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.clearance import clear_of_falling, hand_hits, opening_for
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.streams.pushing.push_motion import push_hits
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

LOOKED_AT = 60  # grasps of an object
KEPT = 24  # of those, that can take it
SERVING = 2  # grasps after which a place needs no more
PUT, DROP = "inverse-kinematics", "plan-laying"  # streams that know ways to a place
PUSHING = "plan-sliding-to"  # the one that knows pushes there
EXPOSING = ("plan-sliding", "plan-detour", "plan-toppling")  # those of pushes to where a hand can take an object
REACHED = 4  # grasps for which the arm is asked about a place
DROPPED = 1  # of those, for which it is asked about a drop, which takes some falls in physics


class Grips:
    """The grasps that can take one object as things stand, by the run's own samplers.

    Args:
        workspace: what stands where; the object may be moved, all others stay.
        name: the object.
        samplers: one function for each stream.
        seed: decides every random choice.
        deadline: on the clock of tamp.clock.now() [s].
    """

    def __init__(
        self, workspace: Workspace, name: str, samplers: Mapping[str, Callable[..., Any]], seed: int, deadline: float
    ) -> None:
        goals = {other: place for other, place in workspace.goals.items() if other != name}
        self._workspace, self._name = replace(workspace, goals=goals), name
        self._samplers, self._seed, self._deadline = samplers, seed, deadline
        self._others = {other: place for other, place in workspace.start.items() if other != name}
        self._scene = Scene(poses={other: place.pose.matrix for other, place in self._others.items()})
        if any(name in place.on for place in self._others.values()):
            self.grasps: tuple[Grasp, ...] = ()
        else:
            offered = islice(samplers["sample-grasp"](self._context("sample-grasp", ()), name), LOOKED_AT)
            taking = (grasp for grasp in filter(None, offered) if self._reaches(PUT, grasp, workspace.start[name]))
            self.grasps = tuple(islice(taking, KEPT))

    def fits(self, R: NDArray[np.float64]) -> bool:
        """Whether there is a grasp whose hand is clear of the table on which the object stands, turned by R (3, 3)."""
        pose = raised(amid(self._workspace, self._name, R)).pose
        return any(self._is_clear(grasp, pose, Scene()) for grasp in self.grasps)

    def roomy(self, place: Placement) -> Iterator[Grasp]:
        """Yield the grasps for whose hand, open and without an arm, there is room at a place, then to drop it there."""
        put = [self._is_clear(grasp, place.pose, self._scene) for grasp in self.grasps]
        yield from compress(self.grasps, put)
        loose = clear_of_falling(self._workspace, self._name, _pinches(self.grasps), place.pose)
        falling = [
            grasp for grasp, is_put, falls_out in zip(self.grasps, put, loose, strict=True) if falls_out > is_put
        ]
        above = [fall[0] for fall in drops(self._workspace, self._name, place)] if falling else []
        for grasp in falling:
            if any(self._is_clear(grasp, pose, self._scene) for pose in above):
                yield grasp

    def serving(self, place: Placement) -> tuple[Grasp, ...]:
        """A few of the grasps, best first, that can also bring the object to a place; none where there are none."""
        grasps = tuple(islice(self.roomy(place), REACHED))
        putting = tuple(islice((grasp for grasp in grasps if self._reaches(PUT, grasp, place)), SERVING))
        if putting or not drops(self._workspace, self._name, place):
            return putting
        return tuple(grasp for grasp in grasps[:DROPPED] if self._reaches(DROP, grasp, place))

    def _is_clear(self, grasp: Grasp, pose: Pose, scene: Scene) -> bool:
        opening = opening_for(self._workspace.world.robot.spec.gripper, grasp)
        return not hand_hits(self._workspace, pose.matrix @ grasp.T_object_tool.matrix, opening, scene)

    def _reaches(self, stream: str, grasp: Grasp, place: Placement) -> bool:
        """Whether the first way to a place that a stream knows meets nothing; once time is up no more are asked for."""
        if clock.now() >= self._deadline:
            return False
        found = self._samplers[stream](self._context(stream, (place, grasp)), self._name, place, grasp)
        first = next(found, None)
        return first is not None and not handling_hits(self._workspace, first[-1], self._others)

    def _context(self, stream: str, inputs: tuple[Any, ...]) -> Context:
        return _context(self._workspace, stream, (self._name, *inputs), self._seed, self._deadline)


def _context(workspace: Workspace, stream: str, inputs: tuple[Any, ...], seed: int, deadline: float) -> Context:
    """One for a stream that is called for an object, the first of its inputs, while all others stay."""
    return while_others_stay(workspace, inputs[0], stream, tuple(map(repr, inputs)), seed, deadline)


def _pinches(grasps: Sequence[Grasp]) -> Pinches:
    T = np.array([grasp.T_object_tool.matrix for grasp in grasps]).reshape(-1, 4, 4)
    widths = np.array([grasp.width for grasp in grasps])
    clearances = np.array([grasp.clearance for grasp in grasps])
    return Pinches(T, widths, np.zeros(len(grasps)), np.zeros(len(grasps)), clearances)


SHARE = 0.5  # of the time goes to one object at most; what the last one leaves serves goals and deviations
LEAST = 4.0  # less than this would be of no use to it: to grasp, to settle and to plan take most of it [s]
CAREFUL = 0.6  # of its time goes to the nearest of all places, the rest to those that are plainly free on the table
PLACES = 1000  # looked at for an object
LOOKS = 40  # of those with room for the hand, for which the arm is asked
TRIES = 6  # of those it reaches, for which the planner is asked
UNSEEN = 1  # and of those where it might be laid down or dropped by another grasp, once no other has come of it
VAIN = 2  # places on one face to which the arm brings it by none of the grasps, after which no more are looked at
BESIDE = 0.04  # places on the table that are nearer than this to one to which the arm brings it not are not tried [m]
ALIKE = 0.985  # cosine of the angle between two faces that count as one
WHEREVER = 2  # places tried for what is slid or turned over before it is put there: by which grasp nobody knows before
ITERATIONS, SLIDING = 4, 8  # of the stream planner for one place, and for one that begins with a slide


def bring_near(asker: Asker, names: Collection[str], kept: Collection[str], free: Collection[str] = ()) -> bool:
    """Put each of some objects to the best second-best place that it reaches; whether any was brought nearer.

    Those that are farthest from their goals have most to gain and come first: time may run out. Each gets a share, so
    that one that nothing comes of leaves some to the others, but no less than it takes.

    Args:
        asker: the plan so far, which grows.
        names: objects whose goals are poses.
        kept: objects that must stay at their goals.
        free: objects whose goal poses are to stay free.
    """
    waiting, nearer = farthest_first(asker.workspace, names), False
    while waiting and not asker.late:
        with asker.within(SHARE, LEAST):
            nearer |= _bring_near(asker, waiting.pop(0), kept, free)
    return nearer


def _bring_near(asker: Asker, name: str, kept: Collection[str], free: Collection[str]) -> bool:
    workspace, samplers = asker.workspace, asker.progress.now.samplers
    grips = Grips(workspace, name, samplers, asker.drawn_seed(name), asker.deadline)
    if not grips.grasps:
        if not to_be_pushed(workspace, name, workspace.start[name]):
            return False
        with asker.within(CAREFUL):
            if _exposed(asker, name) and _put_wherever(asker, name, kept, free, SLIDING):
                return True
        return _push_near(asker, name, kept, free)
    with asker.within(CAREFUL):
        if _turn_over(asker, name, kept, free):
            return True
        if _put_near(asker, name, grips, kept, free):
            return True
        cut_short = asker.late
    return cut_short and _put_on_table(asker, name, grips, kept, free)


def _turn_over(asker: Asker, name: str, kept: Collection[str], free: Collection[str]) -> bool:
    """Put an object that has to be turned over to one of the nearest places, by two grasps; whether it was.

    From about where it lies that is tried once: which grasps follow each other depends on little else.
    """
    if not turned_over(asker.workspace, name) or asker.stays_unturned(name):
        return False
    before = len(asker.reports)
    if _put_wherever(asker, name, kept, free, ITERATIONS, {name}):
        return True
    if any(report.status == "failed" for report in asker.reports[before:]):
        asker.unturned[name] = asker.workspace.start[name]
    return False


def _exposed(asker: Asker, name: str) -> bool:
    """Whether any push brings an object to where a hand can take it, wherever it shall go from there."""
    workspace = asker.workspace
    anywhere = replace(workspace, goals={other: goal for other, goal in workspace.goals.items() if other != name})
    return any(next(_pushed(asker, anywhere, stream, name), None) is not None for stream in EXPOSING)


def _push_near(asker: Asker, name: str, kept: Collection[str], free: Collection[str]) -> bool:
    """Push an object straight to the nearest place that the arm brings it to; whether it was."""
    workspace, tries = asker.workspace, TRIES
    others = {other: place for other, place in workspace.start.items() if other != name}
    for place in straight_ahead(workspace, name) if slidable(workspace, name, workspace.start[name]) else ():
        if asker.late or not tries:
            break
        if _covers(workspace, name, place, free):
            continue
        found = next(_pushed(asker, workspace, PUSHING, name, place), None)
        if found is not None and push_hits(workspace, found[-1], others) is None:
            tries -= 1
            if _put(asker, name, place, kept, ()):
                return True
    return False


def _pushed(asker: Asker, workspace: Workspace, stream: str, name: str, *to: Placement) -> Iterator[Any]:
    """What a stream of the run's own knows of pushes of an object from where it stands."""
    inputs = (name, workspace.start[name], *to)
    context = _context(workspace, stream, inputs, asker.drawn_seed(name), asker.deadline)
    sampler = asker.progress.now.samplers.get(stream)
    return filter(None, sampler(context, *inputs)) if sampler is not None else iter(())


def rest_from_goal(asker: Asker, name: str) -> Workspace | None:
    """The scene with an object where it comes to rest from its goal; None where that would push others.

    What leans on others at its goal does not stay there before they come.
    """
    workspace, goal = asker.workspace, asker.workspace.goals[name]
    place = settled(workspace, name, goal, asker.progress.now.setup.settings.settling)
    return None if place is None else replace(workspace, start={**workspace.start, name: place})


def bring_to_rest(
    asker: Asker, name: str, there: Workspace, kept: Collection[str], regrasped: Collection[str], effort: Effort
) -> bool:
    """Put an object to where it comes to rest from its goal, if that is another place nearby; whether it was.

    Not if the checker would not have it stay there, nor if that is where another shall be, which may hold it at its
    goal: it waits for that until the greatest effort. Where that is to be carried by it, it does not wait while others
    are moved: what it carries comes after it, merely near its own goal then.

    Args:
        asker: the plan so far, which grows.
        name: an object with a goal pose, on supports that are at theirs.
        there: the scene with the object at rest; see `rest_from_goal`.
        kept: objects that must stay at their goals.
        regrasped: the object, where it reaches its goal only by way of another placement and grasp.
        effort: how hard it is tried.
    """
    if away(there, name) <= RELEASE_HEIGHT or not nearly_there(there, name):
        return False
    place, coming = there.start[name], {other for other, goal in there.goals.items() if goal != there.start[other]}
    after = {other for other in coming if effort.others_move and name in there.goals[other].on}
    waits = effort in EFFORTS[:-1] and _covers(there, name, place, coming - after - {name})
    if waits or tips_with(there, name, place) or not asker.progress.now.stays(name, place):
        return False
    movable = None if effort.others_move else ()
    return _put(asker, name, place, kept, (), effort.iterations, regrasped, movable)


def _put_near(asker: Asker, name: str, grips: Grips, kept: Collection[str], free: Collection[str]) -> bool:
    """Put an object to the nearest place that it reaches, wherever it comes to rest there."""
    workspace, rejections = asker.workspace, asker.progress.rejections
    looks, tries, vain, unseen, stays = LOOKS, TRIES, list[Placement](), list[Placement](), asker.progress.now.stays
    refused = set[tuple[str, ...]]()  # what the checker has not let it be put on: it would not there beside either

    def hopeful(place: Placement) -> bool:
        fresh = sum(_alike(place, other) for other in vain) < VAIN
        return fresh and any(True for _ in grips.roomy(place)) and not _covers(workspace, name, place, free)

    simulator = asker.progress.now.setup.settings.settling
    for place in islice(substitutes(workspace, name, hopeful, grips.fits, asker.deadline, simulator), PLACES):
        if asker.late or not (looks and tries):
            break
        if place.on in refused or _covers(workspace, name, place, free):
            continue
        if hopeful(place):
            looks -= 1
            if not stays(name, place):
                continue
            serving = grips.serving(place)
            if serving:
                tries, before = tries - 1, len(rejections)
                if _put(asker, name, place, kept, serving):
                    return True
                if len(rejections) > before and place.on != (TABLE,):
                    refused.add(place.on)
                continue
            vain.append(place)
        if len(unseen) < UNSEEN and (place.on != (TABLE,) or layable(workspace, name, place)) and stays(name, place):
            unseen.append(place)
    return any(not asker.late and _put(asker, name, place, kept, ()) for place in unseen)


def _put_on_table(asker: Asker, name: str, grips: Grips, kept: Collection[str], free: Collection[str]) -> bool:
    """Put an object to the nearest place on the table with nothing over it: no physics has to tell how it rests there.

    Those on the table are looked at last by `_put_near`, if there is time, where the goal is in a container.
    """
    vain = list[Placement]()
    for place in on_table(asker.workspace, name, grips.fits):
        if asker.late:
            break
        beside = any(math.dist(place.pose.xyz, other.pose.xyz) < BESIDE and _alike(place, other) for other in vain)
        if beside or _covers(asker.workspace, name, place, free):
            continue
        if (serving := grips.serving(place)) and _put(asker, name, place, kept, serving):
            return True
        vain.append(place)
    return False


def _covers(workspace: Workspace, name: str, place: Placement, goals: Collection[str]) -> bool:
    """Whether an object at a place would be where some others shall be."""
    return any(overlap(workspace, name, place, other, workspace.goals[other]) for other in sorted(goals))


def _alike(place: Placement, other: Placement) -> bool:
    """Whether an object rests on the same face at both, and on the table at both or neither."""
    up, other_up = place.pose.matrix[2, :3], other.pose.matrix[2, :3]
    return (place.on == (TABLE,)) == (other.on == (TABLE,)) and float(up @ other_up) > ALIKE


def _put_wherever(
    asker: Asker,
    name: str,
    kept: Collection[str],
    free: Collection[str],
    iterations: int,
    regrasped: Collection[str] = (),
) -> bool:
    """Put an object to the nearest places, where only the planner can tell the grasp that serves there.

    That is so for what can only be gripped where it was slid to, and for what two grasps have to turn over.
    """
    workspace = asker.workspace

    def uncovered(place: Placement) -> bool:
        return not _covers(workspace, name, place, free)

    simulator = asker.progress.now.setup.settings.settling
    found = substitutes(workspace, name, uncovered, lambda R: True, asker.deadline, simulator)
    stays = asker.progress.now.stays
    places = islice((place for place in found if uncovered(place) and stays(name, place)), WHEREVER)
    return any(not asker.late and _put(asker, name, place, kept, (), iterations, regrasped) for place in places)


def _put(
    asker: Asker,
    name: str,
    place: Placement,
    kept: Collection[str],
    serving: Sequence[Grasp],
    iterations: int = ITERATIONS,
    regrasped: Collection[str] = (),
    movable: Collection[str] | None = frozenset(),
) -> bool:
    """Plan to put an object to a place; with the grasps that serve there, or else with any.

    `movable`: what may be moved besides; None for all others, which stay elsewhere then unless they are `kept`.
    """

    def grasps(context: Context, obj: str) -> Iterator[Grasp]:
        yield from serving

    samplers = {"sample-grasp": grasps} if serving else {}
    moved = None if movable is None else {name, *movable}
    asked = asking_to(asker.workspace, name, place, kept)
    solution = asker.ask(asked, iterations, moved, samplers, regrasped, about=name)
    return solution.plan is not None and asker.refused(solution.plan, name, near=True) is None
