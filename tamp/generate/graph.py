"""Scene graphs: which objects a scene has and how each stands to another.

After the OCRTOC paper's generation of tasks (section III-D): the graph stays, objects and poses are drawn anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from tamp.errors import TaskError
from tamp.scenarios.library.model import FOLDER, Model
from tamp.task.files.yaml_document import Document, FieldPath, read_document

SCENES = FOLDER.parent / "scenes.yaml"
"""The scene graphs that come with us, by family."""

TABLE = "table"
CARRIED = ("on", "in", "standing", "stacked")
"""Relations in which the other object carries the one."""
RELATIONS = (TABLE, *CARRIED, "beside", "row", "around", "leaning")
SAME = "same"
MIXED = "mixed"
"""The family that takes the graphs of all."""

FIRST_LEVEL: Mapping[str, int] = {
    **dict.fromkeys(RELATIONS, 1),
    **dict.fromkeys(CARRIED, 2),
    "leaning": 3,
    "standing": 5,
}
"""The level from which on a relation occurs."""


@dataclass(frozen=True)
class Slot:
    """A place in a graph that an object is yet to be drawn for.

    Attributes:
        role: its name in the graph.
        kinds: kinds or categories that may fill it; ("same",) for another copy of the parent's model.
        relation: one of RELATIONS.
        parent: the role it refers to; None on the table.
    """

    role: str
    kinds: tuple[str, ...]
    relation: str = TABLE
    parent: str | None = None

    def admits(self, model: Model, library: tuple[Model, ...]) -> bool:
        """Whether a model may fill it: by its kind, or by its category where the library has no such kind."""
        return model.kind in self.kinds or any(
            model.category == name and all(other.kind != name for other in library) for name in self.kinds
        )


@dataclass(frozen=True)
class Pattern:
    """A scene graph without objects.

    Attributes:
        name: such as "tea".
        slots: parents before children.
    """

    name: str
    slots: tuple[Slot, ...]

    @property
    def first_level(self) -> int:
        """The level from which on it occurs."""
        return max(FIRST_LEVEL[slot.relation] for slot in self.slots)


@dataclass(frozen=True)
class Node:
    """An object in a scene graph.

    Attributes:
        name: the object.
        relation: how it stands, one of RELATIONS.
        parent: the object it refers to; None on the table.
        resting: which of its resting poses it takes; 0 is upright, as it is used.
    """

    name: str
    relation: str = TABLE
    parent: str | None = None
    resting: int = 0


@dataclass(frozen=True)
class SceneGraph:
    """The objects of a scene; parents before children.

    Attributes:
        nodes: one an object.
    """

    nodes: tuple[Node, ...]
    _by_name: Mapping[str, Node] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_by_name", {node.name: node for node in self.nodes})

    def node(self, name: str) -> Node:
        """The node of an object."""
        return self._by_name[name]

    def groups(self) -> list[tuple[Node, ...]]:
        """The trees of the forest, each with its root, which stands on the table, first."""
        found: dict[str, list[Node]] = {}
        for node in self.nodes:
            found.setdefault(self.root(node.name), []).append(node)
        return [tuple(nodes) for nodes in found.values()]

    def root(self, name: str) -> str:
        """The object on the table that an object's place depends on."""
        node = self._by_name[name]
        return name if node.parent is None else self.root(node.parent)

    def __str__(self) -> str:
        return ", ".join(_words(node) for node in self.nodes)


def _words(node: Node) -> str:
    how = node.relation if node.parent is None else f"{node.relation} {node.parent}"
    return f"{node.name} {how}{' tipped' if node.resting else ''}"


@lru_cache(maxsize=4)
def read_patterns(path: Path = SCENES) -> Mapping[str, tuple[Pattern, ...]]:
    """Read the scene graphs of all families; "mixed" has those of all.

    Raises:
        TaskError: in one sentence with file, line, field and what would be valid.
    """
    document = read_document(path)
    if not isinstance(document.value, Mapping):
        raise TaskError(f"{document.name}: a file of scene graphs has a mapping of graphs for each family")
    found: dict[str, tuple[Pattern, ...]] = {}
    for family, graphs in document.value.items():
        if not isinstance(graphs, Mapping) or not graphs:
            raise TaskError(f"{document.where((family,))}: must be a mapping of at least one graph")
        found[family] = tuple(_pattern(document, (family, name), nodes) for name, nodes in graphs.items())
    every = tuple(pattern for family, patterns in found.items() if family != MIXED for pattern in patterns)
    return {**found, MIXED: (*found.get(MIXED, ()), *every)}


def _pattern(document: Document, where: FieldPath, nodes: object) -> Pattern:
    if not isinstance(nodes, Mapping) or not nodes:
        raise TaskError(f"{document.where(where)}: must be a mapping of at least one role")
    slots: list[Slot] = []
    for role, text in nodes.items():
        words = text.split() if isinstance(text, str) else []
        roles = [slot.role for slot in slots]
        if len(words) not in (1, 3) or (len(words) == 3 and (words[1] not in RELATIONS or words[2] not in roles)):
            raise TaskError(
                f"{document.where((*where, role))}: {text!r} must read `kinds` or `kinds relation role`, with a "
                f"relation of {', '.join(RELATIONS[1:])} and a role named before"
            )
        relation, parent = (words[1], words[2]) if len(words) == 3 else (TABLE, None)
        slots.append(Slot(role, tuple(words[0].split("|")), relation, parent))
    return Pattern(str(where[-1]), tuple(slots))
