"""Leaving sampled values of a plan open again, so that what was drawn before competes with fresh draws."""

from __future__ import annotations

from collections.abc import Sequence

from tamp.planning.grounding.grounder import Grounder
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.fact_store import Knowledge


class Lifter:
    """Replaces values by the placeholders of the streams that gave them.

    One value may come from several streams, such as a grip that fits all objects, and there is one placeholder for all
    that a stream gives for some inputs: a value stays what it is where no action has been grounded without it.
    """

    def __init__(self, knowledge: Knowledge, grounder: Grounder) -> None:
        self._knowledge = knowledge
        self._grounder = grounder

    def lift(self, steps: Sequence[GroundOperator]) -> list[GroundOperator]:
        """The steps with as many values left open as there are grounded actions for; themselves where there are none.

        All values that are left open are so in all of the steps.
        """
        kept: set[int] = set()
        while True:
            names = {handle: handle for handle in kept}
            for step in steps:
                for handle in step.binding.values():
                    self._name(handle, names)
            lifted = [self._renamed(step, names) for step in steps]
            stuck = next((step for step, found in zip(steps, lifted, strict=True) if found is None), None)
            if stuck is None:
                return [step for step in lifted if step is not None]
            kept |= self._culprits(stuck, names)

    def _culprits(self, step: GroundOperator, names: dict[int, int]) -> set[int]:
        """The value of a step that must stay what it is for the step to be grounded; all where one is not enough."""
        changed = [h for h in dict.fromkeys(step.binding.values()) if names[h] != h]
        for handle in changed:
            fewer = {h: name for h, name in names.items() if h not in changed} | {handle: handle}
            for other in changed:
                self._name(other, fewer)
            if self._grounder.renamed(step, fewer) is not None:
                return {handle}
        return set(changed)

    def _renamed(self, step: GroundOperator, names: dict[int, int]) -> GroundOperator | None:
        """A step with other objects; None where it is not grounded."""
        same = all(names[handle] == handle for handle in step.binding.values())
        return step if same else self._grounder.renamed(step, names)

    def _name(self, handle: int, names: dict[int, int]) -> int:
        """What stands for what a stream gave or may give: the placeholder of the stream for lifted inputs."""
        source = self._knowledge.source(handle) or self._knowledge.objects.origin(handle)
        if handle in names or source is None or source.fluents:
            return names.setdefault(handle, handle)
        names[handle] = handle
        inputs = tuple(self._name(h, names) for h in source.inputs)
        template = self._knowledge.find(source.external, inputs) or source
        outputs = source.placeholders if handle in source.placeholders else source.outputs_with(handle)
        found = next((new for new, old in zip(template.placeholders, outputs, strict=False) if old == handle), handle)
        if found not in names.values():
            names[handle] = found
        return names[handle]
