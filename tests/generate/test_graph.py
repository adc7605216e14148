from __future__ import annotations

import numpy as np
import pytest

from tamp.errors import TaskError
from tamp.generate.draw import _filled
from tamp.generate.graph import RELATIONS, Node, SceneGraph, read_patterns
from tamp.scenarios.library.model import read_library


def test_families_of_the_competition_are_there_and_mixed_has_all():
    families = read_patterns()
    assert {"food", "tableware", "stationery"} <= set(families)
    for patterns in families.values():
        assert set(patterns) <= set(families["mixed"])
        assert min(pattern.first_level for pattern in patterns) == 1


def test_every_relation_of_the_paper_occurs():
    assert {slot.relation for p in read_patterns()["mixed"] for slot in p.slots} == set(RELATIONS)


@pytest.mark.parametrize(
    "pattern", read_patterns()["mixed"], ids=lambda pattern: "-".join(s.role for s in pattern.slots)
)
def test_every_graph_can_be_filled_from_our_trial_set(pattern):
    models = [model for model in read_library() if model.set == "trial"]
    draws = (_filled(pattern, models, {}, np.random.default_rng(seed)) for seed in range(20))
    things, nodes = next(drawn for drawn in draws if drawn is not None)
    assert [node.name for node in nodes] == list(things)


def test_groups_are_the_trees_root_first():
    graph = SceneGraph((Node("a"), Node("b"), Node("c", "on", "b"), Node("d", "beside", "c")))
    assert [[node.name for node in group] for group in graph.groups()] == [["a"], ["b", "c", "d"]]
    assert str(graph) == "a table, b table, c on b, d beside c"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("food: {tea: {dish: plate, cup: cup over dish}}", r"food.tea.cup: 'cup over dish' must read `kinds` or"),
        ("food: {tea: {cup: cup on dish}}", "a role named before"),
        ("food: {tea: {cup: 3}}", "must read"),
        ("food: {tea: []}", "must be a mapping of at least one role"),
        ("food: []", "must be a mapping of at least one graph"),
        ("just text", "has a mapping of graphs for each family"),
    ],
)
def test_bad_graphs_are_refused_in_one_sentence(tmp_path, text, said):
    path = tmp_path / "scenes.yaml"
    path.write_text(text)
    with pytest.raises(TaskError, match=said):
        read_patterns(path)
