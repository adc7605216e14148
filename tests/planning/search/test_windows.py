"""Long plans get cheaper part by part, and what does not fit together is not taken."""

from dataclasses import replace

from tamp.planning.grounding.ground_task import GroundTask, TaskEffect, TaskOperator
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.normal_form import ActionSchema, Condition
from tamp.planning.search.best_first import BuiltinSearch, SearchResult
from tamp.planning.search.elimination import reaches
from tamp.planning.search.windows import WINDOW, cost, improve_windows, seen_as


def operator(positive, adds, deletes=(), cost=1):
    effects = tuple(TaskEffect(a, True) for a in adds) + tuple(TaskEffect(a, False) for a in deletes)
    return TaskOperator(None, tuple(positive), (), effects, cost)


def task(operators, goal, atoms):
    return GroundTask(tuple(("p", i) for i in range(atoms)), frozenset({0}), goal, (), tuple(operators), ())


def search(part, bound):
    result = BuiltinSearch()(part, 5.0, bound=bound)
    return result if result.plan is None or cost(result.plan) < bound else SearchResult(None, states=result.states)


def test_a_plan_gets_cheaper_in_parts_that_are_short_beside_it():
    count = 4 * WINDOW
    steps = [operator([i], [i + 1], [i], 10) for i in range(count)]
    leaps = [operator([i], [i + 2], [i], 3) for i in range(0, count - 1, 2)]
    sizes = []

    def noted(part, bound):
        result = search(part, bound)
        sizes.append(len(result.plan or ()))
        return result

    whole = task((*steps, *leaps), (count,), count + 1)
    better = improve_windows(whole, tuple(steps), noted)
    assert reaches(whole, better.plan) and cost(better.plan) == 3 * count // 2
    assert max(sizes) <= WINDOW


def test_a_cheaper_way_may_take_more_actions_than_the_plan_had():
    dear = operator([0], [3], cost=10)
    steps = [operator([i], [i + 1]) for i in range(3)]
    whole = task((dear, *steps), (3,), 4)
    better = improve_windows(whole, (dear,), search)
    assert better.plan == tuple(steps)


def test_what_later_effects_are_conditional_on_is_kept():
    """The cheap way does not bring what the last action's effect rests on, though that may be applied."""
    dear, cheap = operator([0], [1, 2], cost=10), operator([0], [1], cost=1)
    filler = [operator([1] if not i else [2 + i], [3 + i], cost=5) for i in range(2 * WINDOW)]
    last = TaskOperator(None, (2 + len(filler),), (), (TaskEffect(40, True, positive=(2,)),), 1)
    whole = task((dear, cheap, *filler, last), (40,), 41)
    plan = (dear, *filler, last)
    assert reaches(whole, plan)
    better = improve_windows(whole, plan, search)
    assert reaches(whole, better.plan) and cost(better.plan) == cost(plan)


def test_a_plan_that_cannot_get_cheaper_is_searched_through_a_few_times_only():
    count = 4 * WINDOW
    steps = [operator([i], [i + 1], [i]) for i in range(count)]
    asked = []

    def vain(part, bound):
        asked.append(bound)
        return SearchResult(None, states=1)

    better = improve_windows(task(steps, (count,), count + 1), tuple(steps), vain)
    assert better.plan == tuple(steps) and better.states == len(asked) <= 24


def test_a_plan_is_seen_with_the_moves_that_a_task_has_in_place_of_actions():
    go = [ActionSchema(name, ("?x",), Condition(), (), None) for name in ("take", "put", "walk")]

    def acting(schema, value, positive, adds):
        source = GroundOperator(schema, {"?x": value}, (), (), (), (), (), (), False)
        return replace(operator(positive, adds), source=source)

    take, put = acting(go[0], 7, [1], [3]), acting(go[1], 8, [2, 3], [4])
    there, on = operator([0], [1], [0]), operator([1], [2], [1])
    whole = task((take, put, there, on), (4,), 5)
    steps = [(go[2], {"?x": 1}), (go[0], {"?x": 7}), (go[2], {"?x": 2}), (go[1], {"?x": 8})]
    assert seen_as(whole, steps) == (there, take, on, put)
    assert seen_as(whole, steps[:3]) is None  # the goal is not reached
    assert seen_as(whole, steps[2:]) is None  # more than a move is missing


def test_a_plan_may_come_out_shorter_than_a_window():
    steps = [operator([i], [i + 1], [i], 10) for i in range(WINDOW)]
    leap = operator([0], [WINDOW], [0])
    whole = task((*steps, leap), (WINDOW,), WINDOW + 1)
    assert improve_windows(whole, tuple(steps), search).plan == (leap,)
