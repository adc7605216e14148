"""A skill: what the robot can do, as one object: its actions, streams, applicability, timed steps, effects and words.

Precedents: predicators' NSRT with its option and sampler (Silver et al., 2021), and the stages of MoveIt's Task
Constructor (Goerner et al., ICRA 2019).
"""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tamp.domains.timing import Timing
from tamp.errors import DomainError, PartError
from tamp.frozen import FrozenDict
from tamp.planning import GroundAction, StreamInfo
from tamp.streams.values import Configuration, Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Action

SAMPLED = StreamInfo(complete=False)
"""Of a stream whose sampler draws from a continuum: that it has ended proves nothing."""
FRESH = StreamInfo(complete=False, fresh=True)
"""Of one that besides never draws the same twice."""
Fact = tuple[Any, ...]
Samplers = Mapping[str, Callable[..., Any]]


@dataclass(frozen=True)
class Question:
    """What a planning problem is made of beside the workspace.

    Attributes:
        configuration: where the arm is.
        held: the object in the hand and its grasp, or None.
        movable: objects that may be moved; None for all.
        regrasped: those of them with a goal pose that shall reach it only by way of another placement and grasp.
        facts: symbolic facts that hold now, such as ("clean", "mug"), of the task or brought about by actions.
        either: objects with a goal pose that may reach it by one grasp or by way of another placement and grasp.
    """

    configuration: Configuration
    held: tuple[str, Grasp] | None = None
    movable: Container[str] | None = None
    regrasped: Container[str] = ()
    facts: tuple[Fact, ...] = ()
    either: Container[str] = ()

    def may_move(self, name: str) -> bool:
        """Whether an object may be moved."""
        return self.movable is None or name in self.movable


@dataclass(frozen=True)
class SceneChange:
    """Where an action leaves the arm and the objects that it moves.

    Attributes:
        configuration: of the arm; None where it stays.
        placements: object -> where it rests then; None for one that the hand holds then.
    """

    configuration: Configuration | None = None
    placements: Mapping[str, Placement | None] = field(default_factory=dict)


@dataclass(frozen=True)
class FactChange:
    """Symbolic facts that an action makes true and false; their arguments are names.

    Raises:
        PartError: where these are something else.
    """

    added: tuple[Fact, ...] = ()
    deleted: tuple[Fact, ...] = ()

    def __post_init__(self) -> None:
        for field_name in ("added", "deleted"):
            facts = getattr(self, field_name)
            if not isinstance(facts, tuple) or not all(_is_fact(fact) for fact in facts):
                valid = "valid is a tuple of facts such as (('clean', 'mug'),)"
                raise PartError(f"FactChange: {field_name} is {reprlib.repr(facts)}; {valid}")


def _is_fact(fact: Any) -> bool:
    """Whether something is a predicate with names."""
    return isinstance(fact, tuple) and bool(fact) and all(isinstance(part, str) for part in fact)


def motionless(timing: Timing, action: GroundAction) -> Action:
    """The timed form of an action that the arm takes no part in; PartError where an argument is no name."""
    if values := [arg for arg in action.args if not isinstance(arg, str)]:
        kind = type(values[0]).__name__
        raise PartError(
            f"action {action.name}: an argument is a {kind}, which a stream made; a skill whose actions are about more "
            "than names says by `steps` how they are carried out"
        )
    return Action(action.name, action.args, ())


def no_affordances(workspace: Workspace, question: Question) -> Iterable[Fact]:
    """What is said of objects by a skill that applies wherever its streams find something."""
    return ()


def no_facts(action: Action) -> FactChange:
    """What is said by a skill that changes nothing but where things are."""
    return FactChange()


@dataclass(frozen=True)
class Skill:
    """One thing that the robot can do.

    Attributes:
        name: what it is called in the manual and in reports.
        actions: names of its actions in the PDDL.
        samplers: stream name -> "module:function" that serves it by default.
        domain: what it adds to the domain's PDDL: a file, or text.
        streams: what it adds to the stream PDDL.
        info: what the planner may know of its streams.
        affordances: facts that say when the skill applies, by the geometry of the workspace alone: they may depend
            neither on who serves a stream nor on the clock.
        steps: an action of a solution as the robot carries it out, timed; raises `NotFree` where that cannot be.
        effect: where an action of a solution leaves arm and objects: the one place where that is said outside the PDDL.
        facts: which symbolic facts a timed action makes true and false.
        rules: "module:NAME" of a mapping from timed actions to the checker's rules for them (`tamp.checking`), written
            without the code that plans them; None where another skill's rules cover them.
        words: name of each timed action -> what it does, for reports: "{0}" is the first argument.

    Raises:
        DomainError: where `actions` is no tuple of names; a text would be taken for the names of its letters.
    """

    name: str
    actions: tuple[str, ...] = ()
    samplers: Mapping[str, str] = field(default_factory=dict)
    domain: str | Path | None = None
    streams: str | Path | None = None
    info: Mapping[str, StreamInfo] = field(default_factory=dict)
    affordances: Callable[[Workspace, Question], Iterable[Fact]] = no_affordances
    steps: Callable[[Timing, GroundAction], Action] = motionless
    effect: Callable[[GroundAction], SceneChange] = lambda action: SceneChange()
    facts: Callable[[Action], FactChange] = no_facts
    rules: str | None = None
    words: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.actions, tuple) or not all(isinstance(name, str) for name in self.actions):
            valid = "valid is a tuple of names such as ('wipe',)"
            raise DomainError(f"skill {self.name}: actions is {reprlib.repr(self.actions)}; {valid}")
        for name in ("samplers", "info", "words"):
            object.__setattr__(self, name, FrozenDict(getattr(self, name)))
