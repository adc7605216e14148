"""Holding a skill against its domain: what it says outside the PDDL agrees with that, and the checker's rules look."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from tamp.checking import Verdict
from tamp.conformance.checks import Check, Fault, Said, asked, judged
from tamp.conformance.findings import PartJudgement
from tamp.conformance.form import short
from tamp.conformance.sameness import same
from tamp.conformance.skill.spoiling import spoilt
from tamp.domains.catalog import load_domain
from tamp.domains.domain import Domain
from tamp.domains.samplers import load_sampler, resolve_samplers
from tamp.domains.skill import Fact, FactChange, Question, SceneChange, Skill, no_facts
from tamp.domains.timing import NotFree
from tamp.errors import PlanningFailure
from tamp.language.domain import Effect
from tamp.language.formula import TRUE, Constant
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.prepare import Setup, prepare
from tamp.planning import GroundAction, Problem, solve
from tamp.planning.problem import check_sampler
from tamp.streams.cache import SampleCache
from tamp.streams.values import Configuration
from tamp.streams.workspace import Workspace
from tamp.task import Action, Move, Plan, Task
from tamp.threads import one_thread

LIMIT_S = 60.0
"""What planning a task is given [s]."""

NEAR = 1e-3
"""How far from the end of one motion the next may begin [rad]."""


def check_skill(domain: str, skill: str, task: Task, *, seed: int = 0, timeout: float = LIMIT_S) -> PartJudgement:
    """Hold a skill against its domain: samplers, affordances, plan, effect, steps, facts, the checker's rules.

    Args:
        domain: that has the skill: an installed one's name, "package.module" or "package.module:NAME".
        skill: its name.
        task: one that the skill is needed for; it is planned, and what the plan has of the skill is looked at.
        seed: decides every random choice.
        timeout: for planning the task [s].
    """
    with one_thread():
        return judged("skill", f"{skill} of {domain}", _checks(domain, skill, task, seed, timeout))


def _checks(domain: str, skill: str, task: Task, seed: int, timeout: float) -> Iterator[Check]:
    yield "domain", lambda: _loaded(domain, skill)
    trial = _Trial(domain, skill, task, seed, timeout)
    yield "samplers", trial.samplers
    yield "affordances", trial.affordances
    if trial.skill.actions:
        yield "plan", trial.plan
        yield "effect", trial.effects
        yield "steps", trial.steps
        yield "facts", trial.facts
        yield "rules", trial.rules
        yield "attacks", trial.attacks


def _loaded(domain: str, skill: str) -> Said:
    found = asked("", lambda: load_domain(domain))
    names = [one.name for one in found.skills]
    if skill not in names:
        raise Fault(f"domain {found.name} has no skill {skill!r}; it has {', '.join(names)}")
    asked("", lambda: found.rules)
    return "ok", "its PDDL, streams and rules are read"


@dataclass(frozen=True)
class _Trial:
    """One skill at work in the plan of a task; each public method is one check."""

    address: str
    name: str
    task: Task
    seed: int
    timeout: float

    @cached_property
    def domain(self) -> Domain:
        return load_domain(self.address)

    @cached_property
    def skill(self) -> Skill:
        return next(skill for skill in self.domain.skills if skill.name == self.name)

    def samplers(self) -> Said:
        """What serves its streams can be had, and takes their inputs."""
        for stream, address in self.skill.samplers.items():
            function = asked("", partial(load_sampler, address, stream))
            if not self._is_stream(stream):
                raise Fault(f"a sampler is given for {stream}, which is no stream of domain {self.domain.name}")
            asked("", partial(check_sampler, self.domain.stream(stream), function))
        return "ok", ", ".join(self.skill.samplers) or "it has no streams"

    def _is_stream(self, name: str) -> bool:
        return name.lower() in {stream.name for stream in self.domain.stream_file.streams}

    def affordances(self) -> Said:
        """They are facts of the domain, and the same whenever they are asked for."""
        try:
            first, second = (self._affordances(self._fresh()) for _ in range(2))
        except PlanningFailure as failure:
            raise Fault(f"task {self.task.name} cannot be prepared: {str(failure).splitlines()[0]}") from None
        for fact in first:
            if wrong := self._misfit(fact):
                raise Fault(f"affordances gives {short(fact)}: {wrong}")
            if self.skill is not self.domain.skills[0] and str(fact[0]).lower() in self.domain.pddl.fluents:
                raise Fault(
                    f"affordances gives {short(fact)}, which actions change: the domain's first skill says what holds "
                    "at the start"
                )
        if not same(first, second):
            raise Fault(
                f"affordances gives {len(first)} facts, and others the second time: they may depend on the geometry of "
                "the workspace alone"
            )
        return "ok", f"{len(first)} facts of {self.task.name}"

    def _affordances(self, workspace: Workspace) -> list[Fact]:
        return asked("affordances", lambda: list(self.skill.affordances(workspace, self._question)))

    def _misfit(self, fact: Any) -> str:
        """What keeps something from being a fact of the domain; "" where nothing does."""
        if not isinstance(fact, tuple) or not fact or not isinstance(fact[0], str):
            return "a fact is a tuple of its predicate and arguments"
        declared = self.domain.pddl.predicates.get(fact[0].lower())
        if declared is None:
            return f"no predicate of domain {self.domain.name} is called {fact[0]!r}"
        if len(fact) - 1 != declared.arity:
            return f"{fact[0]} takes {declared.arity} arguments, not {len(fact) - 1}"
        return ""

    def plan(self) -> Said:
        """There is a plan in which the skill is used."""
        solution = self._solution
        return "ok", " ".join(action.name for action in solution)

    @cached_property
    def _setup(self) -> Setup:
        return asked("", lambda: prepare(self.task, settings=Settings(domain=self.address)))

    @cached_property
    def _workspace(self) -> Workspace:
        return self._setup.observe(self._setup.start)

    def _fresh(self) -> Workspace:
        """The workspace, with nothing remembered."""
        scene = self._workspace
        return replace(scene, world=scene.world.with_nothing_answered(), cache=SampleCache())

    @cached_property
    def _question(self) -> Question:
        spec = self._setup.world.robot.spec
        return Question(Configuration(spec.home, spec.gripper.stroke), facts=self.task.init)

    @cached_property
    def _solution(self) -> Sequence[GroundAction]:
        """The first plan with one of the skill's actions, of the problem or one of its variants."""
        samplers = resolve_samplers(self.domain.samplers)
        others: list[str] | None = None
        unsolved = ""
        mine = {name.lower() for name in self.skill.actions}
        for problem in self._problems(samplers):
            found = asked(
                f"planning {self.task.name}",
                partial(solve, problem, seed=self.seed, timeout=self.timeout),
                self.timeout,
            )
            if found.plan is None:
                unsolved = f"{found.status}: {found.report.message}" if found.report.message else found.status
            elif any(action.name in mine for action in found.plan):
                return tuple(found.plan)
            else:
                others = [action.name for action in found.plan]
        if others is not None:
            raise Fault(
                f"the plan of task {self.task.name} ({' '.join(others) or 'no actions'}) has none of "
                f"{', '.join(self.skill.actions)}; "
                "give a task that the skill is needed for"
            )
        raise Fault(f"there is no plan of task {self.task.name}, {unsolved}")

    def _problems(self, samplers: Mapping[str, Callable[..., Any]]) -> Iterator[Problem]:
        problems = self.domain.problems(self._workspace, samplers, self._question)
        while (problem := asked("", lambda: next(problems, None))) is not None:
            yield problem

    def _mine(self) -> Iterator[tuple[int, GroundAction]]:
        """The skill's own actions of the plan, with their places in it."""
        mine = {name.lower() for name in self.skill.actions}
        return ((place, action) for place, action in enumerate(self._solution) if action.name in mine)

    def effects(self) -> Said:
        """Where it says that arm and objects are left is where the PDDL leaves them."""
        for _, action in self._mine():
            change = asked("effect", partial(self.skill.effect, action))
            if not isinstance(change, SceneChange):
                raise Fault(f"effect of {action.name} must be a SceneChange, found {short(change)}")
            self._arm_as_in_pddl(action, change)
            self._objects_as_in_pddl(action, change)
        return "ok", "leaves arm and objects where the PDDL does"

    def _arm_as_in_pddl(self, action: GroundAction, change: SceneChange) -> None:
        ends = [fact[1] for fact, holds in self._changed(action) if holds and fact[0] == "atconf"]
        if ends and change.configuration is None and any(end != self._before(action) for end in ends):
            raise Fault(f"the PDDL of {action.name} moves the arm (AtConf), and effect leaves it where it was")
        if change.configuration is not None and change.configuration not in ends:
            raise Fault(f"effect of {action.name} leaves the arm in another configuration than the PDDL's (AtConf)")

    def _before(self, action: GroundAction) -> Any:
        """The arm's configuration that the PDDL has an action end, if it has."""
        return next((fact[1] for fact, holds in self._changed(action) if not holds and fact[0] == "atconf"), None)

    def _objects_as_in_pddl(self, action: GroundAction, change: SceneChange) -> None:
        changed = self._changed(action)
        left: dict[str, Any] = {fact[1]: None for fact, holds in changed if not holds and fact[0] == "atpose"}
        left |= {fact[1]: fact[2] for fact, holds in changed if holds and fact[0] == "atpose"}
        left |= {fact[1]: None for fact, holds in changed if holds and fact[0] == "atgrasp"}
        for name in sorted(left.keys() | change.placements.keys()):
            if name not in change.placements:
                raise Fault(f"the PDDL of {action.name} moves {name} (AtPose), and effect says nothing of it")
            if name not in left:
                raise Fault(f"effect of {action.name} moves {name}, and its PDDL does not (AtPose)")
            if change.placements[name] != left[name]:
                raise Fault(f"effect of {action.name} leaves {name} elsewhere than its PDDL does (AtPose)")

    def _changed(self, action: GroundAction) -> list[tuple[Fact, bool]]:
        """The facts that an action makes true or false in any case, by its PDDL."""
        schema = self.domain.pddl.actions[action.name.lower()]
        bound = {p.variable: value for p, value in zip(schema.parameters, action.args, strict=True)}

        def ground(effect: Effect) -> Fact:
            terms = effect.atom.args
            return (effect.atom.predicate, *(t.value if isinstance(t, Constant) else bound[t] for t in terms))

        plain = [effect for effect in schema.effects if not effect.parameters and effect.condition == TRUE]
        made = {ground(effect) for effect in plain if effect.positive}
        gone = {ground(effect) for effect in plain if not effect.positive} - made
        return [*((fact, True) for fact in made), *((fact, False) for fact in gone)]

    def steps(self) -> Said:
        """They are timed actions with words, the same each time, and each begins where the arm is and ends as said."""
        once, again = (self._timed() for _ in range(2))
        for _, action in self._mine():
            self._is_timed(action, once)
        if not same([a.steps for a in once], [a.steps for a in again]):
            raise Fault("steps gives other steps for the same action the second time")
        at = np.array(self._question.configuration.q)
        mine = {place for place, _ in self._mine()}
        for place, (ground, timed) in enumerate(zip(self._solution, once, strict=True)):
            moves = [step for step in timed.steps if isinstance(step, Move)]
            said = self.domain.effect(ground).configuration
            there = at if said is None else np.array(said.q)
            if place in mine:
                _continuous(timed.name, moves, at, there)
            at = there
        return "ok", ", ".join(dict.fromkeys(self._timed_names()))

    def _timed(self) -> tuple[Action, ...]:
        def timed() -> tuple[Action, ...]:
            try:
                return self.domain.timed(self._fresh(), self._solution)
            except NotFree as error:
                raise Fault(f"a timed motion of the plan is not free: {error}") from None

        return asked("", timed)

    def _is_timed(self, ground: GroundAction, timed: Sequence[Any]) -> None:
        place = next(n for n, action in self._mine() if action is ground)
        made = timed[place]
        if strange := [a for a in made.arguments if not isinstance(a, str)]:
            raise Fault(f"steps of {ground.name}: the arguments of an Action are names, found {short(strange[0])}")

    def _timed_names(self) -> list[str]:
        return [self._actions[place].name for place, _ in self._mine()]

    @cached_property
    def _actions(self) -> tuple[Action, ...]:
        return self._timed()

    def facts(self) -> Said:
        """What it says of symbolic facts is what the PDDL does to them."""
        told = 0
        for place, ground in self._mine():
            change = asked("facts", partial(self.skill.facts, self._actions[place]))
            if not isinstance(change, FactChange):
                raise Fault(f"facts of {ground.name} must be a FactChange, found {short(change)}")
            told += self._facts_as_in_pddl(ground, change)
        return "ok", f"{told} changes told"

    def _facts_as_in_pddl(self, ground: GroundAction, change: FactChange) -> int:
        said = [*((fact, True) for fact in change.added), *((fact, False) for fact in change.deleted)]
        pddl = {fact: holds for fact, holds in self._changed(ground) if fact[0] in self._symbolic()}
        for fact, holds in said:
            if wrong := self._misfit(fact):
                raise Fault(f"facts of {ground.name} gives {short(fact)}: {wrong}")
            if fact[0] != fact[0].lower():
                raise Fault(f"facts of {ground.name} gives {short(fact)}: predicates are in lower case here")
            derived = fact[0] in self.domain.pddl.derived
            conditional = self._is_conditional(ground, fact[0])
            if not derived and not conditional and pddl.get(fact) is not holds:
                raise Fault(f"facts of {ground.name} makes {_written(fact)} {_truth(holds)}, its PDDL does not")
        if self.skill.facts is not no_facts:
            for fact, holds in pddl.items():
                if (fact, holds) not in said:
                    raise Fault(f"the PDDL of {ground.name} makes {_written(fact)} {_truth(holds)}, facts does not")
        return len(said)

    def _is_conditional(self, ground: GroundAction, predicate: str) -> bool:
        effects = self.domain.pddl.actions[ground.name.lower()].effects
        return any(e.atom.predicate == predicate and (e.parameters or e.condition != TRUE) for e in effects)

    def _symbolic(self) -> tuple[str, ...]:
        """The predicates about names that the skill's actions change, and that no silent skill changes as well."""
        named = {fact[0] for _, g in self._mine() for fact, _ in self._changed(g) if _is_about_names(fact)}
        others = [s for s in self.domain.skills if s is not self.skill and s.facts is no_facts]
        silent = {
            e.atom.predicate for s in others for n in s.actions for e in self.domain.pddl.actions[n.lower()].effects
        }
        return tuple(sorted(named - silent))

    def rules(self) -> Said:
        """The checker accepts the plan, and says of facts what the skill says."""
        verdict = asked("", lambda: self._judged(self._actions))
        if not verdict.accepted:
            raise Fault(f"the checker refuses the plan: {verdict.problems[0]}")
        followed = self.domain.followed
        said = {f for f in self.domain.facts_after(self.task.init, self._actions) if f[0] in followed}
        known = {fact for fact in verdict.facts if fact[0] in followed}
        for more, less, facts in (("facts", "rules", said - known), ("rules", "facts", known - said)):
            if facts:
                raise Fault(f"after the plan {_written(min(facts))} holds by its {more}, and not by its {less}")
        return "ok", "accept the plan"

    def attacks(self) -> Said:
        """The checker refuses the plan where one of the skill's actions is spoilt."""
        refused = 0
        for place, _ in self._mine():
            for how, action in spoilt(self._actions[place]):
                actions = (*self._actions[:place], action, *self._actions[place + 1 :])
                verdict = asked(f"rule for {action.name} {how}", partial(self._judged, actions))
                if verdict.accepted:
                    raise Fault(f"the checker accepts {action.name} {how}: its rule does not look")
                refused += 1
        return "ok", f"{refused} spoilt actions are refused"

    def _judged(self, actions: tuple[Action, ...]) -> Verdict:
        setup, task = self._setup, self.task
        goals = {name: place.pose for name, place in self._workspace.goals.items()}
        start = {name: place.pose for name, place in self._workspace.start.items()}
        plan = Plan(task.name, task.robot, self.seed, start, self._question.configuration.q, goals, actions)
        return setup.check(plan, start=start, goals=goals, facts=task.init)


def _continuous(name: str, moves: Sequence[Move], at: Any, there: Any) -> None:
    """Refuse motions that do not lead from one configuration to another without a jump."""
    for move in moves:
        if (off := _apart(move.trajectory.positions[0], at)) > NEAR:
            raise Fault(f"steps of {name}: the {move.phase} motion begins {off:.3f} rad from where the arm is")
        at = move.trajectory.positions[-1]
    if (off := _apart(at, there)) > NEAR:
        raise Fault(f"steps of {name} end {off:.3f} rad from where effect says that the arm is then")


def _apart(a: Any, b: Any) -> float:
    return float(np.abs(np.asarray(a) - np.asarray(b)).max()) if len(a) == len(b) else math.inf


def _is_about_names(fact: Fact) -> bool:
    return len(fact) > 1 and all(isinstance(value, str) for value in fact[1:])


def _written(fact: Fact) -> str:
    return f"({' '.join(map(str, fact))})"


def _truth(holds: bool) -> str:
    return "true" if holds else "false"
