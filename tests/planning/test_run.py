"""A run that survives questions: states that plans lead to, what stays frozen, what need not be sampled again."""

import dataclasses

import pytest

from tamp.errors import DomainError
from tamp.planning import Options, PlanningRun, Settings
from tests.planning.oracles.validator import validate
from tests.planning.problems import blocksworld, continuous, ported, tabletop, unsolvable
from tests.planning.test_problems import ALGORITHMS


def settings(algorithm="adaptive", timeout=20.0):
    return Settings(algorithm, "ff", Options(timeout=timeout))


def check(problem, goals, solutions):
    plan = [(action.name, action.args) for solution in solutions for action in solution.plan]
    facts = [*problem.init, *(fact for solution in solutions for fact in solution.certified)]
    validate(problem.parsed_domain, facts, plan, goals, problem.parsed_streams, problem.samplers)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("make", "goals"),
    [
        (lambda: blocksworld.inversion(4), None),
        (lambda: continuous.line(2), None),
        (lambda: ported.spawn(1), None),
    ],
)
def test_questions_follow_one_another(make, goals, algorithm):
    problem = make()
    run = PlanningRun(problem, settings(algorithm))
    first = run.solve(goals)
    assert first.status == "solved", str(first.report)
    run.commit()
    again = run.solve(goals)
    assert again.status == "solved" and again.plan == ()
    run.rollback()
    anew = run.solve(goals)
    assert [a.name for a in anew.plan] and anew.status == "solved"
    check(problem, problem.goal, [anew])


def sides(n):
    problem = tabletop.sort(n)
    goals = list(problem.goal[1:])
    return problem, goals


def test_goals_one_by_one_from_committed_states():
    problem, goals = sides(4)
    run = PlanningRun(problem, settings())
    solutions = []
    for i in range(len(goals)):
        solutions.append(run.solve(("and", *goals[: i + 1])))
        assert solutions[-1].status == "solved", str(solutions[-1].report)
        run.commit()
    check(problem, problem.goal, solutions)


def test_what_was_sampled_is_not_sampled_again():
    problem, _ = sides(3)
    run = PlanningRun(problem, settings())
    calls = [sum(stream.calls for stream in run.solve().report.streams) for _ in range(2)]
    assert calls[1] <= calls[0] // 4


def test_frozen_objects_stay():
    problem = blocksworld.inversion(3)
    run = PlanningRun(problem, settings())
    top = run.solve().plan[0].args[0]
    assert run.solve(frozen=[top]).status == "infeasible"
    assert run.solve().status == "solved"


def test_infeasible_questions_leave_the_run_as_it_was():
    problem = unsolvable.impossible_goal()
    run = PlanningRun(problem, settings())
    assert run.solve().status == "infeasible"
    assert run.solve(("held", "cup")).status == "solved"
    run.commit()
    assert run.solve(("held", "jug")).status == "infeasible"
    run.rollback()
    assert run.solve(("held", "jug")).status == "solved"


def test_no_time_for_a_question():
    problem, _ = sides(2)
    run = PlanningRun(problem, settings())
    assert run.solve(budget=0.0).status == "timeout"
    assert run.solve().status == "solved"
    assert run.solve(budget=0.0).status == "timeout"
    assert run.solve().status == "solved"


def test_what_cannot_be_done_is_said():
    run = PlanningRun(blocksworld.inversion(2))
    with pytest.raises(ValueError, match="no plan to commit"):
        run.commit()
    with pytest.raises(ValueError, match="nothing to take back"):
        run.rollback()
    with pytest.raises(DomainError, match="unknown algorithm 'fast'"):
        PlanningRun(run.problem, dataclasses.replace(settings(), algorithm="fast"))
    run.solve()
    run.commit()
    with pytest.raises(ValueError, match="no plan to commit"):
        run.commit()
