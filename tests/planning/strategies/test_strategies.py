"""Strategies: plans of every one are valid; goal by goal is no less complete; soft goals are weighed rightly."""

import dataclasses
from typing import ClassVar

import pytest

from tamp.errors import DomainError, PartError
from tamp.language import atoms
from tamp.planning import AllAtOnce, Constraints, GroundAction, NetBenefit, Problem, Serialized, solve
from tamp.planning.strategies.net_benefit import compiled
from tamp.planning.strategies.serialized import conjuncts
from tests.planning.problems import blocksworld, continuous, costs, ported, tabletop, unsolvable
from tests.planning.test_problems import ALGORITHMS, check

TRAP = """
(define (domain trap)
  (:predicates (key) (a) (b) (burnt))
  (:action burn :precondition (key) :effect (and (a) (burnt) (not (key))))
  (:action open :precondition (and (key) (not (burnt))) :effect (b))
  (:action work :precondition (b) :effect (and (a))))
"""

ERRANDS = """
(define (domain errands)
  (:requirements :action-costs)
  (:predicates (at ?x) (road ?x ?y) (been ?x))
  (:functions (total-cost) (length ?x ?y))
  (:action go :parameters (?x ?y) :precondition (and (at ?x) (road ?x ?y))
    :effect (and (at ?y) (been ?y) (not (at ?x)) (increase (total-cost) (length ?x ?y)))))
"""


def errands(soft, goal=None):
    roads = {("home", "shop"): 2, ("shop", "home"): 2, ("home", "sea"): 9, ("sea", "home"): 9, ("shop", "bank"): 1}
    roads[("bank", "home")] = 2
    init = [("at", "home"), *(("road", *road) for road in roads)]
    init += [("=", ("length", *road), length) for road, length in roads.items()]
    return Problem(domain=ERRANDS, init=init, goal=goal, soft_goals=soft)


@pytest.mark.parametrize(
    "make",
    [
        lambda: blocksworld.inversion(5),
        lambda: continuous.line(2),
        lambda: continuous.occupied(2),
        lambda: ported.spawn(2),
        costs.delivery,
    ],
)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_goal_by_goal_gives_valid_plans(make, algorithm):
    problem = make()
    solution = solve(problem, algorithm=algorithm, strategy="serialized", timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)
    assert solution.report.strategy == {"name": "serialized", "ladder": (0.02, 0.08, 0.2)}


@pytest.mark.parametrize("family", ["sort", "permutation"])
def test_goal_by_goal_on_a_tabletop(family):
    problem = getattr(tabletop, family)(4)
    solution = solve(problem, strategy="serialized", timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


@pytest.mark.parametrize("goal", [("and", ("a",), ("b",)), ("and", ("and", ("a",)), ("and", ("b",)))])
def test_what_one_goal_makes_impossible_is_planned_at_once(goal):
    problem = Problem(domain=TRAP, init=[("key",)], goal=goal)
    solution = solve(problem, strategy=Serialized(ladder=(0.5,)), timeout=10.0)
    assert solution.status == "solved"
    check(problem, solution)


@pytest.mark.parametrize("make", [unsolvable.impossible_goal, unsolvable.no_streams, unsolvable.unknown_thing])
def test_infeasible_is_said_of_the_whole(make):
    solution = solve(make(), strategy="serialized", timeout=20.0)
    assert (solution.plan, solution.status) == (None, "infeasible")


def test_goals_in_order():
    assert conjuncts(("and", ("a",), ("AND", ("b",), ["and", ("c",)]))) == (("a",), ("b",), ("c",))
    assert conjuncts(None) == () and conjuncts(("or", ("a",), ("b",))) == (("or", ("a",), ("b",)),)


@pytest.mark.parametrize(
    ("soft", "cost", "forgone"),
    [
        ([(("been", "shop"), 3.0), (("been", "sea"), 5.0)], 2.0 + 5.0, [("been", "sea")]),
        ([(("been", "shop"), 5.0), (("been", "sea"), 30.0)], 2.0 + 2.0 + 9.0, []),
        ([(("been", "shop"), 1.0), (("been", "sea"), 5.0)], 6.0, [("been", "shop"), ("been", "sea")]),
        ([(("and", ("been", "bank"), ("at", "home")), 6.0)], 5.0, []),
        ([(("not", ("at", "home")), 2.5)], 2.0, []),
    ],
)
def test_net_benefit_is_the_greatest(soft, cost, forgone):
    solution = solve(errands(soft), strategy="net-benefit", timeout=20.0)
    assert (solution.status, solution.cost, list(solution.forgone)) == ("solved", cost, forgone)
    assert all(action.name == "go" for action in solution.plan)
    assert solution.report.message.startswith(f"Forgone: {len(forgone)} of {len(soft)} soft goals.")


def softened(problem, worth=100.0):
    goals = conjuncts(problem.goal)
    hard = ("and", *(goal for goal in goals if goal[0] in ("AtConf", "HandEmpty")))
    return dataclasses.replace(problem, goal=hard, soft_goals=tuple((g, worth) for g in goals if g not in hard))


def test_moves_are_left_out_of_the_search_where_soft_goals_are_weighed():
    problem = softened(tabletop.permutation(4))
    solution = solve(problem, strategy=NetBenefit(enough=40.0), timeout=60.0, max_iterations=20)
    assert (solution.status, solution.forgone) == ("solved", ())
    check(tabletop.permutation(4), solution)


def test_a_soft_goal_of_where_the_hand_is_is_reached_before_the_acting_ends():
    problem = dataclasses.replace(tabletop.sort(1), goal=None)
    problem = dataclasses.replace(problem, soft_goals=((("AtConf", "home"), 50.0), (("AtGrasp", "o0", "unknown"), 1.0)))
    solution = solve(problem, strategy=NetBenefit(enough=10.0), timeout=20.0)
    assert solution.forgone == (("AtGrasp", "o0", "unknown"),)


def test_only_what_changes_soft_goals_ends_with_the_acting():
    actions = compiled(softened(tabletop.sort(2))).parsed_domain.actions
    conditions = {name: {atom.predicate for atom in atoms(a.precondition)} for name, a in actions.items()}
    acting = [name for name, predicates in conditions.items() if "net-benefit-acting" in predicates]
    assert acting == ["pick", "unstack", "place", "net-benefit-end"]


def test_hard_goals_come_first():
    solution = solve(errands([(("at", "home"), 1.0)], goal=("been", "sea")), strategy="net-benefit", timeout=20.0)
    assert [action.args for action in solution.plan] == [("home", "sea")]
    assert solution.forgone == (("at", "home"),)


@dataclasses.dataclass(frozen=True)
class Thrifty:
    """Net benefit under another name."""

    name: ClassVar[str] = "thrifty"
    supports_soft_goals: ClassVar[bool] = True

    def __call__(self, problem, settings):
        return NetBenefit()(problem, settings)


def test_a_strategy_of_ones_own_plans_for_soft_goals_where_it_says_so():
    solution = solve(errands([(("been", "shop"), 5.0)]), strategy=Thrifty(), timeout=20.0)
    assert (solution.status, solution.forgone) == ("solved", ())
    with pytest.raises(DomainError, match=r"'silent' does not plan for soft_goals; .* supports_soft_goals: ClassVar"):
        solve(errands([(("been", "shop"), 5.0)]), strategy=Silent())


def test_what_does_not_fit_is_refused():
    problem = blocksworld.inversion(2)
    with pytest.raises(DomainError, match="unknown strategy 'serialised'; there are: all-at-once, serialized"):
        solve(problem, strategy="serialised")
    with pytest.raises(DomainError, match="are about a whole plan"):
        solve(problem, strategy="serialized", constraints=Constraints(skeleton=()))
    with pytest.raises(DomainError, match="shares of the time limit"):
        Serialized(ladder=())
    with pytest.raises(DomainError, match="no soft_goals"):
        solve(problem, strategy="net-benefit")
    with pytest.raises(DomainError, match="'all-at-once' does not plan for soft_goals"):
        solve(dataclasses.replace(problem, soft_goals=((problem.goal, 1.0),)))
    with pytest.raises(DomainError, match="expected pairs such as"):
        dataclasses.replace(problem, soft_goals=((problem.goal, 0.0),))


@dataclasses.dataclass
class Changing:
    name = "changing"

    def __call__(self, problem, settings):
        return None


@dataclasses.dataclass(frozen=True)
class Nameless:
    answer: object = None

    def __call__(self, problem, settings):
        return self.answer


@dataclasses.dataclass(frozen=True)
class Changed:
    """All at once, whose solution is changed, or that raises."""

    changes: dict
    raised: BaseException | None = None
    name: ClassVar[str] = "changed"

    def __call__(self, problem, settings):
        if self.raised is not None:
            raise self.raised
        return dataclasses.replace(AllAtOnce()(problem, settings), **self.changes)


@dataclasses.dataclass(frozen=True)
class Silent(Nameless):
    name: ClassVar[str] = "silent"


@pytest.mark.parametrize(
    ("strategy", "said"),
    [
        (5, "5 cannot be called; a strategy is called with"),
        (Serialized, r"is the class Serialized; give an instance, such as Serialized\(\)"),
        (lambda problem: None, r"must take \(problem, settings\): too many"),
        (Changing(), r"is no frozen dataclass, whose fields are its options: put @dataclass\(frozen=True\)"),
        (Nameless(), "has no name; give its class one"),
        (Silent(), "strategy 'silent': expected a Solution, found None"),
        (Changed({"status": "failed"}), "strategy 'changed': its status is 'failed', with a plan"),
        (Changed({"plan": None}), "strategy 'changed': its status is 'solved', with no plan"),
        (Changed({"plan": (("stack", ("a", "b")),)}), "expected a plan of GroundAction, .*, found ..stack., ..a., .b"),
        (Changed({"plan": (GroundAction("fly", ()),)}), "each an action of the domain, found GroundAction.*fly"),
        (Changed({"plan": (GroundAction("stack", ()),)}), "strategy 'changed': stack has . parameters, in its plan 0"),
        (
            Changed({}, raised=ZeroDivisionError("by zero")),
            "'changed' raised ZeroDivisionError: by zero at .*/test_str",
        ),
        (Changed({}, raised=SystemExit(3)), "'changed' raised SystemExit: 3 at .*/test_strategies.py:"),
    ],
)
def test_what_is_no_strategy_is_refused_in_one_sentence(strategy, said):
    with pytest.raises((DomainError, PartError), match=said):
        solve(blocksworld.inversion(2), strategy=strategy)


def spin():
    while True:
        pass


@dataclasses.dataclass(frozen=True)
class Hanging:
    """Plans, and then goes on for ever."""

    name: ClassVar[str] = "hanging"

    def __call__(self, problem, settings):
        AllAtOnce()(problem, settings)
        spin()


@dataclasses.dataclass(frozen=True)
class Asking:
    """Asks about what hangs for a moment, and then plans without it."""

    name: ClassVar[str] = "asking"

    def __call__(self, problem, settings):
        brief = dataclasses.replace(settings, options=dataclasses.replace(settings.options, timeout=0.2))
        hanging = Problem(
            domain="(define (domain d) (:predicates (p ?x) (q))"
            " (:action a :parameters (?x) :precondition (p ?x) :effect (q)))",
            streams="(define (stream s) (:stream sample :outputs (?x) :certified (p ?x)))",
            samplers={"sample": lambda context: spin()},
            goal=("q",),
        )
        first = AllAtOnce()(hanging, brief)
        assert first.status == "timeout" and "'sample' went on past the limit" in first.report.message
        return AllAtOnce()(problem, settings)


def test_a_strategy_that_does_not_look_at_the_clock_is_ended():
    solution = solve(blocksworld.inversion(2), strategy=Hanging(), timeout=0.5)
    assert solution.status == "timeout" and solution.report.total_s < 2.0
    assert solution.report.message == (
        "The time limit of 0.5 s was reached: strategy 'hanging' was interrupted 0.4 s past the limit."
    )
    assert solution.report.strategy == {"name": "hanging"}


def test_each_question_of_a_strategy_of_ones_own_is_ended_by_its_own_limit():
    assert solve(blocksworld.inversion(2), strategy=Asking(), timeout=20.0).solved
