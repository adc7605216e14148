"""Bringing objects near goals that they cannot reach."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import islice

from tamp.pipeline.asking import Asker
from tamp.pipeline.goals import asking_for, farthest_first
from tamp.pipeline.gripping import Grips
from tamp.pipeline.substitutes import substitutes
from tamp.planning import Context
from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.tilting import layable
from tamp.streams.topples import to_be_pushed
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace

SHARE = 0.5  # of the time goes to one object at most; what the last one leaves serves goals and deviations
LEAST = 5.0  # less than this would be of no use to it: to grasp, to settle and to plan take most of it [s]
PLACES = 1000  # looked at for an object
LOOKS = 40  # of those with room for the hand, for which the arm is asked
TRIES = 6  # of those it reaches, for which the planner is asked
UNSEEN = 1  # and of those where it might be laid down or dropped by another grasp, once no other has come of it
VAIN = 2  # places on one face to which the arm brings it by none of the grasps, after which no more are looked at
ALIKE = 0.985  # cosine of the angle between two faces that count as one
SLID = 2  # places tried for what can only be gripped once it was slid: by which grasp nobody knows before
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
    grips = Grips(workspace, name, samplers, asker.drawn_seed, asker.deadline)
    if not grips.grasps:
        return to_be_pushed(workspace, name, workspace.start[name]) and _slide_near(asker, name, kept, free)
    looks, tries, vain, unseen = LOOKS, TRIES, list[Placement](), list[Placement]()

    def hopeful(place: Placement) -> bool:
        fresh = sum(_alike(place, other) for other in vain) < VAIN
        return fresh and bool(grips.roomy(place)) and not _covers(workspace, name, place, free)

    for place in islice(substitutes(workspace, name, hopeful, grips.fits, asker.deadline), PLACES):
        if asker.late or not (looks and tries):
            break
        if _covers(workspace, name, place, free):
            continue
        if hopeful(place):
            looks -= 1
            serving = grips.serving(place)
            if serving:
                tries -= 1
                if _put(asker, name, place, kept, serving):
                    return True
                continue
            vain.append(place)
        if len(unseen) < UNSEEN and (place.on != (TABLE,) or layable(workspace, name, place)):
            unseen.append(place)
    return any(not asker.late and _put(asker, name, place, kept, ()) for place in unseen)


def _covers(workspace: Workspace, name: str, place: Placement, goals: Collection[str]) -> bool:
    """Whether an object at a place would be where some others shall be."""
    T, wanted = place.pose.matrix, [(other, workspace.goals[other].pose.matrix) for other in sorted(goals)]
    return any(workspace.world.overlap(name, T, other, T_goal, tolerance=CONTACT_DEPTH) for other, T_goal in wanted)


def _alike(place: Placement, other: Placement) -> bool:
    """Whether an object rests on the same face at both, and on the table at both or neither."""
    up, other_up = place.pose.matrix[2, :3], other.pose.matrix[2, :3]
    return (place.on == (TABLE,)) == (other.on == (TABLE,)) and float(up @ other_up) > ALIKE


def _slide_near(asker: Asker, name: str, kept: Collection[str], free: Collection[str]) -> bool:
    """The same for an object that can only be gripped where it was slid to."""
    workspace = asker.workspace

    def uncovered(place: Placement) -> bool:
        return not _covers(workspace, name, place, free)

    places = filter(uncovered, substitutes(workspace, name, uncovered, lambda R: True, asker.deadline))
    return any(not asker.late and _put(asker, name, place, kept, (), SLIDING) for place in islice(places, SLID))


def _put(
    asker: Asker,
    name: str,
    place: Placement,
    kept: Collection[str],
    serving: Sequence[Grasp],
    iterations: int = ITERATIONS,
) -> bool:
    """Plan to put an object to a place while all others stay; with the grasps that serve there, or else with any."""
    workspace = asker.workspace
    stay = {other: workspace.start[other] for other in workspace.goals}
    near = replace(workspace, goals={**stay, name: place})

    def grasps(context: Context, obj: str) -> Iterator[Grasp]:
        yield from serving

    samplers = {"sample-grasp": grasps} if serving else {}
    solution = asker.ask(asking_for(near, {*kept, name}), iterations, {name}, samplers)
    return solution.plan is not None and asker.refused(solution.plan) is None
