"""A domain: what a robot can be asked to do. From a workspace to a problem, from its solution to timed actions."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tamp import plugins
from tamp.domains.skill import Fact, FactChange, Question, Samplers, SceneChange, Skill, no_facts
from tamp.domains.timing import DEFAULT_SPEEDS, NotFree, Speeds, Timing
from tamp.errors import DomainError, PartError, SamplerError, TampError, meant, told
from tamp.frozen import FrozenDict
from tamp.language import Domain as PDDLDomain
from tamp.language import Stream, StreamFile, atoms, parse_domain, parse_streams
from tamp.language.sexpr import suggest
from tamp.planning import GroundAction, Problem, StreamInfo
from tamp.streams.values import Configuration, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Action

RETURNED: Mapping[str, type] = MappingProxyType(
    {"affordances": Iterable, "steps": Action, "effect": SceneChange, "facts": FactChange}
)
"""What the functions of a skill return."""


@dataclass(frozen=True)
class Domain:
    """What tasks of a kind are planned with.

    Attributes:
        name: as in `domain:` of a task file.
        skills: what the robot can do in it. Their PDDL is read as one; the first has what the others build on, and its
            affordances say where everything is.
        goal: workspace -> the conditions that its objects' goals ask for.
        strategy: by which its tasks are planned where nobody says otherwise.
        variants: further questions about a workspace, in which streams have something to do that are seldom used.
    """

    name: str
    skills: tuple[Skill, ...]
    goal: Callable[[Workspace], Iterable[Fact]]
    strategy: str = "all-at-once"
    variants: tuple[Callable[[Workspace, Question], Question], ...] = ()

    def extended(self, *skills: Skill, name: str, strategy: str | None = None) -> Domain:
        """The domain with further skills, under a name of its own, planned by a strategy of its own."""
        return replace(self, name=name, skills=(*self.skills, *skills), strategy=strategy or self.strategy)

    @cached_property
    def pddl(self) -> PDDLDomain:
        """Actions, predicates and axioms, of the domain and all its skills.

        Raises:
            DomainError: where they cannot be read, or a skill names an action that is not there.
        """
        parsed = parse_domain(self._domain_files)
        for skill in self.skills:
            for name in skill.actions:
                if name.lower() not in parsed.actions:
                    raise DomainError(
                        f"domain {self.name}: skill {skill.name} names {name!r}, which is no action of it"
                    )
        if unserved := sorted(parsed.actions.keys() - self._skill_of.keys()):
            raise DomainError(f"domain {self.name}: no skill has the action {', '.join(unserved)}")
        return parsed

    @cached_property
    def stream_file(self) -> StreamFile:
        """The streams, of the domain and all its skills."""
        return parse_streams(self._stream_files, self.pddl)

    @cached_property
    def samplers(self) -> Mapping[str, str]:
        """Stream name -> "module:function" that serves it by default."""
        return MappingProxyType(dict(chain.from_iterable(skill.samplers.items() for skill in self.skills)))

    @cached_property
    def rules(self) -> Mapping[str, Any]:
        """Name of a timed action -> the checker's rule for it.

        Raises:
            DomainError: where a skill names rules that are not there, or an action has none.
        """
        addresses = [skill.rules for skill in self.skills if skill.rules is not None]
        rules = dict(chain.from_iterable(self._rules(address).items() for address in addresses))
        for skill in self.skills:
            for action in skill.words.keys() - rules.keys():
                told = f"the checker has no rule for {action!r} and would refuse every plan with it"
                raise DomainError(f"domain {self.name}: skill {skill.name}: {told}")
        return MappingProxyType(rules)

    def _rules(self, address: str) -> Mapping[str, Any]:
        module, _, name = address.partition(":")
        rules = getattr(plugins.imported(module, f"domain {self.name}: rules {address!r}", DomainError), name, None)
        if not isinstance(rules, Mapping):
            found = "nothing" if rules is None else type(rules).__name__
            raise DomainError(
                f"domain {self.name}: {address!r} must be a mapping of action names to rules, found {found}"
            )
        return rules

    @cached_property
    def followed(self) -> frozenset[str]:
        """Predicates of which skills say by `facts` when they hold: of others nobody can tell at the end of a plan.

        They are those that actions of such skills change, and those derived of what such actions change.
        """
        telling = [
            self.pddl.actions[name.lower()] for s in self.skills if s.facts is not no_facts for name in s.actions
        ]
        found = {effect.atom.predicate for action in telling for effect in action.effects}
        size = -1
        while size < (size := len(found)):
            for axiom in self.pddl.axioms:
                if any(atom.predicate in found for atom in atoms(axiom.condition)):
                    found.add(axiom.predicate)
        return frozenset(found)

    @cached_property
    def words(self) -> Mapping[str, str]:
        """Name of a timed action -> what it does, in words."""
        return FrozenDict(chain.from_iterable(skill.words.items() for skill in self.skills))

    def stream(self, name: str) -> Stream:
        """The stream called `name`.

        Raises:
            SamplerError: where there is none; lists those that there are.
        """
        for stream in self.stream_file.streams:
            if stream.name == name.lower():
                return stream
        names = [stream.name for stream in self.stream_file.streams]
        raise SamplerError(f"no stream {name!r}; {meant(name, names)}{self.name} has {', '.join(names)}")

    def problem(self, workspace: Workspace, samplers: Samplers, question: Question) -> Problem:
        """The planning problem of a workspace as it is now.

        Args:
            workspace: what stands where, and where it shall stand.
            samplers: one function for each stream.
            question: where the arm is, and what may move.
        """
        affordances = chain.from_iterable(self._affordances(skill, workspace, question) for skill in self.skills)
        infos: Iterator[tuple[str, StreamInfo]] = chain.from_iterable(skill.info.items() for skill in self.skills)
        return Problem(
            domain=self._domain_files,
            streams=self._stream_files,
            samplers=samplers,
            init=[*affordances, *question.facts],
            goal=("and", *self.goal(workspace), *workspace.task.goal),
            scene=workspace,
            info=dict(infos),
        )

    def problems(self, workspace: Workspace, samplers: Samplers, question: Question) -> Iterator[Problem]:
        """The usual problem of a workspace, then its variants."""
        yield self.problem(workspace, samplers, question)
        for variant in self.variants:
            yield self.problem(workspace, samplers, variant(workspace, question))

    def timed(
        self, workspace: Workspace, solution: Sequence[GroundAction], speeds: Speeds = DEFAULT_SPEEDS
    ) -> tuple[Action, ...]:
        """Turn ground actions into timed ones.

        Args:
            workspace: where they happen, objects at their start.
            solution: the planner's, in order.
            speeds: how fast the arm moves.

        Raises:
            NotFree: where a timed motion touches something.
            PartError: where a skill makes something else of an action, or a timed action that no skill has words for.
        """
        poses = {name: placement.pose.matrix for name, placement in workspace.start.items()}
        actions = []
        for ground in solution:
            actions.append(self._timed(Timing(workspace, poses, speeds), ground))
            for name, placement in self.effect(ground).placements.items():
                if placement is None:
                    poses.pop(name, None)
                else:
                    poses[name] = placement.pose.matrix
        return tuple(actions)

    def effect(self, ground: GroundAction) -> SceneChange:
        """Where an action of a solution leaves arm and objects."""
        change: SceneChange = self._asked(self._of(ground.name), "effect", ground)
        return change

    def after(
        self, start: Mapping[str, Placement], configuration: Configuration, solution: Iterable[GroundAction]
    ) -> tuple[dict[str, Placement], Configuration]:
        """Where objects and arm are when a solution that ends with an empty hand has been carried out."""
        placements: dict[str, Placement | None] = dict(start)
        for ground in solution:
            change = self.effect(ground)
            placements |= change.placements
            configuration = change.configuration or configuration
        return {name: place for name, place in placements.items() if place is not None}, configuration

    def facts_after(self, facts: Iterable[Fact], actions: Iterable[Action]) -> tuple[Fact, ...]:
        """The symbolic facts that hold when timed actions have been carried out."""
        known = dict.fromkeys(facts)
        for action in actions:
            change = self._asked(self._of_timed(action.name), "facts", action)
            known = {fact: None for fact in known if fact not in change.deleted} | dict.fromkeys(change.added)
        return tuple(known)

    def _affordances(self, skill: Skill, workspace: Workspace, question: Question) -> list[Fact]:
        """Facts that say when a skill applies; PartError for a predicate that the domain does not have."""
        facts: list[Fact] = list(self._asked(skill, "affordances", workspace, question))
        for predicate in {fact[0] for fact in facts if isinstance(fact, tuple) and fact}:
            if str(predicate).lower() not in self.pddl.predicates:
                near = suggest(str(predicate), self.pddl.predicates, "predicates")
                raise PartError(
                    f"domain {self.name}: affordances of skill {skill.name}: no predicate {predicate!r}{near}"
                )
        return facts

    def _timed(self, timing: Timing, ground: GroundAction) -> Action:
        """One action of a solution as its skill carries it out."""
        skill = self._of(ground.name)
        action: Action = self._asked(skill, "steps", timing, ground)
        if action.name not in self.words:
            known = f"{meant(action.name, self.words)}there are words for {', '.join(sorted(self.words))}"
            made = f"steps of skill {skill.name} make the action {action.name!r}"
            raise PartError(f"domain {self.name}: {made}, for which no skill has words; {known}")
        return action

    def _asked(self, skill: Skill, part: str, *given: Any) -> Any:
        """What a function of a skill returns; what it raises, or something else, as a PartError that names it."""
        what = f"domain {self.name}: {part} of skill {skill.name}"
        try:
            made = getattr(skill, part)(*given)
            made = list(made) if isinstance(made, Iterator) else made
        except (TampError, NotFree):
            raise
        except Exception as error:
            raise PartError(f"{what}: {told(error)}") from error
        if not isinstance(made, RETURNED[part]) or isinstance(made, str):
            raise PartError(f"{what}: expected {RETURNED[part].__name__}, found {reprlib.repr(made)}")
        return made

    @property
    def _domain_files(self) -> tuple[str | Path, ...]:
        return tuple(skill.domain for skill in self.skills if skill.domain is not None)

    @property
    def _stream_files(self) -> tuple[str | Path, ...]:
        return tuple(skill.streams for skill in self.skills if skill.streams is not None)

    @cached_property
    def _skill_of(self) -> Mapping[str, Skill]:
        return {name.lower(): skill for skill in self.skills for name in skill.actions}

    def _of(self, action: str) -> Skill:
        if action.lower() not in self._skill_of:
            raise ValueError(f"domain {self.name} has no action {action!r}")
        return self._skill_of[action.lower()]

    def _of_timed(self, action: str) -> Skill:
        """The skill of a timed action: the one that has words for it."""
        for skill in self.skills:
            if action in skill.words:
                return skill
        raise ValueError(f"domain {self.name} has no timed action {action!r}")
