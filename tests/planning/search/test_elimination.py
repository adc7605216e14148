"""Plans without actions that their goals do not need."""

from tamp.planning.grounding.ground_task import GroundTask, TaskAxiom, TaskEffect, TaskOperator
from tamp.planning.search.elimination import eliminate


def operator(positive, adds, deletes=(), negative=(), cost=1):
    effects = tuple(TaskEffect(a, True) for a in adds) + tuple(TaskEffect(a, False) for a in deletes)
    return TaskOperator(None, tuple(positive), tuple(negative), effects, cost)


def task(goal, axioms=(), unwanted=()):
    return GroundTask(tuple(("p", i) for i in range(9)), frozenset({0}), goal, unwanted, (), tuple(axioms))


FIRST, SECOND = operator([0], [1]), operator([1], [2])


def test_what_the_goal_needs_stays():
    assert eliminate(task((2,)), (FIRST, SECOND)) == (FIRST, SECOND)


def test_an_action_and_what_rests_on_it_alone_are_left_out_together():
    detour, further = operator([0], [3]), operator([3], [4])
    assert eliminate(task((2,)), (detour, FIRST, further, SECOND)) == (FIRST, SECOND)


def test_what_is_undone_again_is_left_out():
    undo, again = operator([1], [], [1]), operator([0], [1])
    assert eliminate(task((2,)), (FIRST, undo, again, SECOND)) == (again, SECOND)


def test_what_makes_something_false_is_needed_where_it_is_wanted_so():
    clear = operator([0], [], [0])
    assert eliminate(task((), unwanted=(0,)), (FIRST, clear)) == (clear,)


def test_axioms_count():
    other = operator([0], [5])
    axioms = [TaskAxiom(7, (2,), ()), TaskAxiom(7, (5,), ()), TaskAxiom(8, (), (7,))]
    assert eliminate(task((7,), axioms), (FIRST, SECOND, other)) == (other,)
    assert eliminate(task((8,), axioms), (FIRST, SECOND)) == ()


def test_conditional_effects_count():
    lit = TaskOperator(None, (0,), (), (TaskEffect(2, True, positive=(1,)),), 1)
    assert eliminate(task((2,)), (FIRST, lit)) == (FIRST, lit)


def test_long_plans_stay_as_they_are():
    plan = (operator([0], [3]),) * 700 + (FIRST,)
    assert eliminate(task((1,)), plan) == plan
