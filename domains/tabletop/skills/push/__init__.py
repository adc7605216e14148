"""What slides, topples and nudges share: their steps, their effect, and how what was pushed is grasped."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import SAMPLED, SceneChange, Skill
from tamp.domains.timing import Timing
from tamp.planning import GroundAction
from tamp.streams.values import Slide
from tamp.task import Action, Attachment, Fall, Step

FOLDER = Path(__file__).parent


def steps(timing: Timing, action: GroundAction) -> Action:
    """The hand comes down behind the object, pushes it straight ahead or over its edge, and draws back."""
    slide: Slide = action.args[-1]
    return Action(action.name, (slide.object, *slide.end.on), tuple(_steps(timing, slide)))


def _steps(timing: Timing, slide: Slide) -> Iterator[Step]:
    pushed = Attachment(slide.object, slide.T_tool_object)
    yield timing.move("approach", slide.approach, slide.opening, touching=slide.object)
    yield timing.push(pushed, slide.push, slide.opening, timing.still_below(slide.object, slide.start))
    timing.put(slide.object, slide.end.pose.matrix)
    if slide.fall:
        yield Fall(slide.object, slide.end.pose)
    yield timing.move("retreat", slide.retreat, slide.opening, touching=slide.object)


def effect(action: GroundAction) -> SceneChange:
    """The object is where it was pushed to."""
    slide: Slide = action.args[-1]
    return SceneChange(action.args[-2], {slide.object: slide.end})


PUSH = Skill(
    name="push",
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "sample-exposed-grasp": "tamp.streams.pushing.grasp_after_push:sample_exposed_grasp",
        "test-cfree-slide": "tamp.streams.pushing.slide:test_cfree_slide",
    },
    info={"sample-exposed-grasp": SAMPLED},
)
