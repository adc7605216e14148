"""A picture of a plan and of the streams that feed it, as graphviz text."""

from __future__ import annotations

from collections.abc import Iterable

from tamp.planning.binding.attempt import BoundStep
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.stream_instances import Instance


def draw_plan(steps: Iterable[BoundStep], knowledge: Knowledge) -> str:
    """Actions as boxes in order, stream instances as ellipses, values on the arrows. Render it with `dot -Tsvg`."""
    lines = ["digraph plan {", "  rankdir=LR;", "  node [fontsize=10];", "  edge [fontsize=8];"]
    names: dict[Instance, str] = {}
    objects = knowledge.objects
    steps = list(steps)

    def node(instance: Instance) -> str:
        if instance not in names:
            names[instance] = f"s{len(names)}"
            me = names[instance]
            lines.append(f"  {me} [shape=ellipse, label={_quoted(instance.external.name)}];")
            for handle in dict.fromkeys(instance.inputs):
                source = knowledge.source(handle)
                if source is not None:
                    lines.append(f"  {node(source)} -> {me} [label={_quoted(objects.name(handle))}];")
        return names[instance]

    for i, step in enumerate(steps):
        args = [objects.name(h) for h in step.args if knowledge.source(h) is None]
        lines.append(f"  a{i} [shape=box, label={_quoted(' '.join((step.schema.name, *args)))}];")
        if i:
            lines.append(f"  a{i - 1} -> a{i} [style=bold];")
        for handle in dict.fromkeys(step.args):
            source = knowledge.source(handle)
            if source is not None:
                lines.append(f"  {node(source)} -> a{i} [label={_quoted(objects.name(handle))}];")
    return "\n".join([*lines, "}", ""])


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
