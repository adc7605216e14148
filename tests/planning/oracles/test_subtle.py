"""Problems whose streams must be read exactly: every algorithm solves them; and what is no proof is not called one."""

import time

import pytest

from tamp.errors import DomainError
from tamp.planning import Problem, solve
from tests.planning.oracles.exhaustive import search
from tests.planning.problems import unsolvable
from tests.planning.problems.subtle import SUBTLE, exogenous
from tests.planning.test_problems import ALGORITHMS, check


@pytest.mark.parametrize("name", SUBTLE)
def test_the_second_opinion_solves_it(name):
    plan, _ = search(SUBTLE[name](), rounds=6, calls=5)
    assert plan is not None


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", SUBTLE)
def test_solved(name, algorithm):
    problem = SUBTLE[name]()
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_a_stream_certifies_ends_with_its_domain(algorithm):
    problem = exogenous(more="(not (hot ?x))")
    assert search(problem, rounds=6, calls=5) == (None, True)
    assert solve(problem, algorithm=algorithm, timeout=20.0).status == "infeasible"


def test_a_stream_cannot_bring_about_what_it_waits_for():
    streams = """(define (stream s)
      (:stream cook :inputs (?x) :domain (hot ?x) :outputs (?y) :certified (and (meal ?x ?y) (eaten))))"""
    with pytest.raises(DomainError, match=r"stream:2:.*cook.*'eaten'"):
        Problem(domain=exogenous().domain, streams=streams, samplers={"cook": lambda context, pot: iter(())})


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_giving_up_is_no_proof(algorithm):
    def three_grasps_at_most(context, thing):
        yield from range(3)
        context.fail("three tries", proven=False)

    problem = unsolvable._reach(three_grasps_at_most, unsolvable.out_of_reach, ("Held", "cup"))
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "failed"
    assert "sample-grasp" in solution.report.message


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_ending_at_the_deadline_is_no_proof(algorithm):
    def slow(context, thing):
        time.sleep(0.3)
        yield from ()

    problem = unsolvable._reach(slow, unsolvable.in_reach, ("Held", "cup"))
    assert solve(problem, algorithm=algorithm, timeout=0.2).status == "timeout"
