"""A plan with its sampled values left open again, each as an output of the stream that gave it."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from tamp.planning.binding.attempt import BoundStep
from tamp.planning.binding.skeleton import Skeleton, make_skeleton, renamed
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.schema import Schema
from tamp.planning.model.stream_instances import Instance, ground


def reopened(
    skeleton: Skeleton,
    steps: Iterable[BoundStep],
    kept: Collection[int],
    schema: Schema,
    knowledge: Knowledge,
    connectors: Connectors,
) -> tuple[Skeleton, dict[int, int]]:
    """A skeleton with what a plan of it got from streams left open, and what stood there.

    Nothing must be assumed that there is a plan without, so that this works among real values as well.

    Args:
        skeleton: some values of which may be real ones.
        steps: the plan, without moves.
        kept: objects that stay what they are, as those that the goal names.
        schema: of the problem.
        knowledge: with the streams that gave the values.
        connectors: the moves.
    """
    opener = _Opener(knowledge, kept)
    made = []
    for left, step in zip(skeleton.steps, steps, strict=True):
        facts = {ground(pattern, step.binding) for pattern in step.schema.condition.positive}
        names = {handle: opener.name(step.binding[variable], facts) for variable, handle in left.binding.items()}
        made.append(_with_needs(left, names, opener))
    return make_skeleton(made, schema, knowledge, connectors), opener.values


def _with_needs(step: GroundOperator, names: dict[int, int], opener: _Opener) -> GroundOperator:
    found = renamed(step, names)
    found.needs = tuple(dict.fromkeys(need for name in names.values() for need in opener.needed(name)))
    return found


class _Opener:
    """Gives values placeholders.

    Attributes:
        values: placeholder -> the value that it stands for.
    """

    def __init__(self, knowledge: Knowledge, kept: Collection[int]) -> None:
        self.values: dict[int, int] = {}
        self._knowledge = knowledge
        self._kept = frozenset(kept)
        self._templates: dict[tuple[Instance, int], Instance] = {}

    def name(self, value: int, facts: Collection[Fact]) -> int:
        """The placeholder of a value, or the value itself where it is not sampled, or told the state.

        `facts`: what holds of it. Several streams may have given the value: one is meant that has certified such facts.
        """
        given = [] if value in self._kept else [g for g in self._knowledge.givers(value) if _may_vary(g[0], value)]
        if not given:
            return value
        instance, number = max(given, key=lambda g: sum(f in facts for f in g[0].certified(g[0].results[g[1]])))
        template = self._template(instance, number)
        return template.placeholders[instance.results[number].index(value)]

    def needed(self, name: int) -> Iterable[Instance]:
        """The instance that a placeholder is an output of, after those that its inputs are outputs of."""
        template = self._knowledge.objects.origin(name)
        if template is not None:
            yield from (*template.supports, template)

    def _template(self, instance: Instance, number: int) -> Instance:
        key = instance, number
        if key not in self._templates:
            objects = self._knowledge.objects
            inputs = tuple(self.name(h, instance.domain) for h in instance.inputs)
            supports = dict.fromkeys(need for name in inputs for need in self.needed(name))
            template = Instance(instance.external, inputs, supports=tuple(supports))
            outputs = instance.results[number]
            template.placeholders = tuple(objects.placeholder(f"{objects.key(h)}?", template) for h in outputs)
            self.values.update(zip(template.placeholders, outputs, strict=True))
            self._templates[key] = template
        return self._templates[key]


def _may_vary(instance: Instance, value: int) -> bool:
    """Whether a value may be left open as an output of an instance: one of objects that were there before it."""
    external = instance.external
    return not external.fluents and not external.optimizer and all(handle < value for handle in instance.inputs)
