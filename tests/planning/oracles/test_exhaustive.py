"""The problems are what they claim to be, by the second opinion; its plans are the validator's positive cases."""

import pytest

from tests.planning.oracles.exhaustive import sample, search
from tests.planning.oracles.validator import validate
from tests.planning.problems import (
    blocksworld,
    continuous,
    costs,
    kitchen,
    negation,
    ported,
    quantified,
    recursive,
    unsolvable,
)


@pytest.mark.parametrize(
    ("make", "n", "length"),
    [
        (blocksworld.inversion, 3, 6),
        (continuous.line, 1, 4),
        (lambda n: continuous.line(n, continuous.DOMAIN.replace(continuous.UNSAFE, continuous.FORALL)), 1, 4),
        (lambda n: continuous.line(n, continuous.conditional_effects()), 1, 4),
        (continuous.plane, 1, 4),
        (continuous.occupied, 2, 8),
        (kitchen.cook, 1, 6),
        (negation.parking, 2, 2),
        (negation.inspection, 3, 3),
        (ported.grid, 2, 9),
        (ported.belief, 2, 2),
        (ported.spawn, 1, 2),
        (quantified.trays, 1, 4),
        (recursive.rooms, 3, 7),
        (recursive.painted_tower, 3, 4),
    ],
)
def test_solvable(make, n, length):
    problem = make(n)
    plan, _ = search(problem)
    assert plan is not None and len(plan) == length


@pytest.mark.parametrize(
    "make", [unsolvable.exhausted, unsolvable.impossible_goal, unsolvable.unknown_thing, unsolvable.no_streams]
)
def test_unsolvable(make):
    assert search(make(), rounds=6, calls=4) == (None, True)


@pytest.mark.parametrize("make", [unsolvable.endless, unsolvable.undecided])
def test_endless(make):
    assert search(make(), rounds=6) == (None, False)


@pytest.mark.parametrize("problem", [kitchen.cook(1), recursive.painted_tower(3), quantified.trays(1)])
def test_its_plans_are_valid(problem):
    plan, _ = search(problem)
    relation, _ = sample(problem, rounds=4, calls=2)
    facts = [(name, *(arg.value for arg in args)) for name in sorted(relation) for args in relation[name]]
    assert validate(problem.parsed_domain, facts, plan, problem.goal, problem.parsed_streams, problem.samplers) == len(
        plan
    )


def test_a_shortest_plan_is_not_always_the_cheapest():
    plan, _ = search(costs.delivery())
    assert [name for name, _ in plan] == ["fly", "deliver"]
