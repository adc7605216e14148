"""Values for all that an optimizer shall give in a plan, found at once: its variables, and the constraints on them."""

from __future__ import annotations

from collections.abc import Callable

from tamp.planning.binding.assignment import Walk
from tamp.planning.binding.skeleton import Apply, Check, Choose, Rewind
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.model.objects import Fact
from tamp.planning.model.state import State
from tamp.planning.model.stream_instances import ground
from tamp.planning.sampling.assignments import Assignments
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.stream_calls import Sampling

Progress = Callable[[Evaluator, ActionSchema, dict[str, int], State], State]


class Optimizers:
    """Asks optimizers about the rest of a plan, as far as what their values depend on is chosen.

    What a procedure gives becomes what its streams have given, so that it can be chosen as any value; the walk notes
    which values belong together.
    """

    def __init__(self, knowledge: Knowledge, sampling: Sampling, evaluator: Evaluator, progress: Progress) -> None:
        """`progress`: the state after an action."""
        self._knowledge = knowledge
        self._assignments = Assignments(knowledge, sampling)
        self._evaluator = evaluator
        self._progress = progress

    def propose(self, walk: Walk, position: int) -> tuple[int, ...] | None:
        """Values for a choice, found together with those of later choices that are tied to it; None where none are.

        The walk notes the latter.
        """
        item = walk.items[position]
        assert isinstance(item, Choose)
        external = item.template.external
        chosen, facts = self._gathered(walk, position, external.optimizer)
        tied = _tied(position, chosen, facts)
        chosen = {i: choice for i, choice in chosen.items() if i in tied}
        outputs = [h for choice in chosen.values() for h in choice.template.placeholders]
        facts = [f for f in facts if not set(outputs).isdisjoint(f[1:])]
        if len(chosen) == 1 and len(facts) == len(external.certified):
            return None  # nothing is tied to it: it is asked for alone
        found = self._assignments.draw(external, outputs, facts)
        if found is None:
            return None
        values = dict(zip(outputs, found, strict=True))
        for i, choice in chosen.items():
            stream = choice.template.external
            inputs = tuple(values.get(h, walk.values.value(h)) for h in choice.template.inputs)
            given = tuple(values[h] for h in choice.template.placeholders)
            self._knowledge.record(self._knowledge.instance(stream, inputs), given)
            if i > position:
                walk.following[i] = given
        for fact in facts:
            self._hold((fact[0], *(values.get(h, h) for h in fact[1:])), external.optimizer)
        return tuple(values[h] for h in item.template.placeholders)

    def _gathered(self, walk: Walk, position: int, optimizer: str) -> tuple[dict[int, Choose], list[Fact]]:
        """The choices that an optimizer can make from a position on, and what shall hold of them."""
        schema, is_real = self._knowledge.schema, self._knowledge.objects.is_real
        constraints = {str(p[0]) for e in schema.externals.values() if e.optimizer == optimizer for p in e.certified}
        objectives = dict(schema.problem.parsed_streams.objectives)[optimizer]
        chosen: dict[int, Choose] = {}
        wanted: dict[Fact, None] = {}
        promised: set[Fact] = set()
        state = walk.states[position]
        for i, item in enumerate(walk.items[position:], start=position):
            if isinstance(item, Rewind):
                break
            if isinstance(item, Choose):
                promised.update(map(walk.values.fact, item.template.certified(item.template.placeholders)))
                inputs = [walk.values.value(h) for h in item.template.inputs]
                open_inputs = {h for h in inputs if not is_real(h)}
                made = {h for choice in chosen.values() for h in choice.template.placeholders}
                if item.template.external.optimizer == optimizer and open_inputs <= made:
                    chosen[i] = item
                    certified = item.template.certified(item.template.placeholders)
                    wanted.update(dict.fromkeys(map(walk.values.fact, certified)))
            elif isinstance(item, Check):
                fact = walk.values.fact(item.fact)
                wanted.update(dict.fromkeys(self._evaluator.assumed(fact, item.positive, state, promised)))
            elif isinstance(item, Apply):
                step = walk.skeleton.steps[item.step]
                binding = walk.values.binding(step.binding)
                state = self._progress(self._evaluator, step.schema, binding, state)
                for term in step.schema.cost or ():
                    if isinstance(term, tuple) and term[0] in objectives:
                        wanted[ground(term, binding)] = None
        made = {h for choice in chosen.values() for h in choice.template.placeholders}
        kinds = constraints.union(objectives)
        return chosen, [f for f in wanted if f[0] in kinds and all(is_real(h) or h in made for h in f[1:])]

    def _hold(self, fact: Fact, optimizer: str) -> None:
        """Let a constraint be known to hold, as the optimizer has certified it."""
        for test in self._knowledge.schema.externals.values():
            for pattern in test.certified if test.optimizer == optimizer and test.is_test else ():
                if pattern[0] == fact[0]:
                    terms = dict(zip(pattern[1:], fact[1:], strict=True))
                    instance = self._knowledge.instance(test, tuple(terms[v] for v in test.inputs))
                    instance.exhausted = True
                    self._knowledge.record(instance, ())
                    self._knowledge.announce(instance)


def _tied(position: int, chosen: dict[int, Choose], facts: list[Fact]) -> set[int]:
    """The choices that one is tied to by facts of both, directly or through others; itself too."""
    groups = [set(choice.template.placeholders) for choice in chosen.values()]
    groups += [set(fact[1:]) & set().union(*groups) for fact in facts]
    reached = set(chosen[position].template.placeholders)
    while True:
        more = set().union(*(group for group in groups if group & reached)) - reached
        if not more:
            return {i for i, choice in chosen.items() if reached & set(choice.template.placeholders)}
        reached |= more
