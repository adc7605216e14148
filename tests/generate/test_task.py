from __future__ import annotations

import itertools
import math

import pytest

import tamp
from tamp.execution.settling.settle import settle
from tamp.generate.levels import LEVELS, level
from tamp.generate.placement.contact import hits
from tamp.generate.placement.object_model import thing
from tamp.generate.reach import reachable
from tamp.generate.run import copy_library, write_task
from tamp.generate.task import Recipe, make_task
from tamp.scenarios.library.model import FOLDER, read_library
from tamp.scoring.relations import extent, holds
from tamp.task import On


def scenes(one):
    """Graph and poses of start and goal."""
    yield one.start, {o.name: o.pose for o in one.task.objects}
    yield one.goal, {o.name: o.goal.pose for o in one.task.objects}


def models(one):
    by_path = {model.shape: model for model in read_library()}
    return {o.name: by_path[o.shape] for o in one.task.objects}


def test_every_level_and_family_generates_what_its_level_asks(made):
    assert {one.recipe.level for one in made} == {of.number for of in LEVELS}
    assert {one.recipe.family for one in made} == {"food", "tableware", "stationery", "mixed"}
    for one in made:
        assert one.features.fit(level(one.recipe.level))
        assert one.features.objects == len(one.task.objects)
        assert one.features.do_nothing_ede_m > 0.03 > 0.005 > one.features.floor_ede_m


def test_trial_tasks_hold_known_objects_and_contest_tasks_some_of_both(made):
    for one in made:
        sets = {model.set for model in models(one).values()}
        assert sets == ({"trial"} if one.recipe.set == "trial" else {"trial", "contest"})


def test_scenes_stay_where_they_are(made):
    for one in made:
        for _, poses in scenes(one):
            settled = settle(one.task, poses, limit_s=2.0)
            assert max(settled.moved.values()) < 0.005


def test_what_rolls_on_slowly_is_rejected():
    made = make_task(Recipe(0, "contest", 4, 4, "food"), read_library())  # an apple crept through a basket here
    goals = {item.name: item.goal.pose for item in made.task.objects}
    assert max(settle(made.task, goals, limit_s=6.0).moved.values()) < 0.002


def test_objects_are_apart_and_within_reach(made):
    for one in made:
        things = {name: thing(model) for name, model in models(one).items()}
        for _, poses in scenes(one):
            at = {name: pose.matrix for name, pose in poses.items()}
            assert all(reachable(things[name], T) for name, T in at.items())
            for a, b in itertools.combinations(at, 2):
                assert not hits(things[a], at[a], [(things[b], at[b])], -0.003)


def test_relations_hold_after_settling(made):
    found = set()
    for one in made:
        for graph, poses in scenes(one):
            for node in graph.nodes:
                found.add(node.relation)
                assert relation_holds(one.task, node, poses), f"{one.task.name}: {node}"
    assert {"table", "stacked", "beside"} <= found


def relation_holds(task, node, poses) -> bool:
    """What the words mean, from the poses alone."""
    lower, upper = extent(task.object(node.name).shape, poses[node.name])
    if node.parent is None:
        return abs(lower[2]) < 0.004
    below, above = extent(task.object(node.parent).shape, poses[node.parent])
    gap = math.hypot(*(max(0.0, a - b, c - d) for a, b, c, d in zip(lower, above, below, upper, strict=True)))
    match node.relation:
        case "on" | "stacked":
            return holds(task, node.name, On(node.parent), poses) and lower[2] > below[2] + 0.002
        case "in" | "standing":
            return lower[2] < above[2] - 0.005 and holds(task, node.name, On(node.parent), poses)
        case "leaning":
            return gap < 0.005 and abs(lower[2]) < 0.004
        case _:
            return gap < 0.06 and abs(lower[2]) < 0.004


def test_the_same_recipe_makes_the_same_task_and_another_seed_another(made):
    again = make_task(made[1].recipe, read_library())
    assert again.task == made[1].task
    assert again.comment == made[1].comment
    first, second = (make_task(Recipe(seed, "trial", 1, 1, "mixed"), read_library()) for seed in (1, 2))
    assert first.task.objects != second.task.objects


def test_files_load_as_the_same_tasks_and_say_how_they_were_made(made, tmp_path):
    copy_library(FOLDER, tmp_path)
    library = read_library(tmp_path / "objects")
    for one in made[:2]:
        copy = make_task(one.recipe, library)
        path = write_task(copy, tmp_path)
        loaded = tamp.load_task(path)
        assert loaded.objects == copy.task.objects
        assert loaded.level == one.recipe.level
        first = path.read_text().splitlines()[0]
        assert f"seed 1): {one.recipe.set} task {one.recipe.index}, level {one.recipe.level}, family" in first


def test_a_library_without_what_a_family_needs_is_said_so():
    cans = [model for model in read_library() if model.kind == "can"]
    with pytest.raises(tamp.TaskError, match="no tableware task of level 1 in 400 attempts"):
        make_task(Recipe(0, "trial", 1, 1, "tableware"), cans)
