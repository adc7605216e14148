"""Domains and skills as objects: found by name, put together, refused with a sentence where they do not fit."""

from dataclasses import replace

import pytest

import tamp
from tamp.domains import kitchen, tabletop
from tamp.domains.catalog import load_domain
from tamp.domains.domain import Domain
from tamp.domains.skill import FactChange, Question, SceneChange, Skill, motionless
from tamp.errors import DomainError, PartError
from tamp.planning import GroundAction
from tamp.streams.values import Configuration, Placement
from tamp.task import Action, Pose

HOME = Configuration((0.0,) * 7, 0.08)
RING = """(define (domain ring) (:predicates (Rung ?b))
  (:action ring :parameters (?b) :precondition (HandEmpty) :effect (Rung ?b)))"""
BELL = Skill("ring", actions=("ring",), domain=RING, words={"ring": "ring {0}"})


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("kichen", r"unknown domain 'kichen' \(one of .*\); did you mean 'kitchen'\?"),
        ("nowhere_at_all.domain", "domain 'nowhere_at_all.domain': there is no module 'nowhere_at_all'"),
        ("os.path", "os.path.DOMAIN must be a Domain, found nothing"),
        ("math:pi", "math.pi must be a Domain, found float"),
    ],
)
def test_a_domain_that_is_not_there_is_refused_in_one_sentence(name, said):
    with pytest.raises(DomainError, match=said) as refused:
        load_domain(name)
    assert "\n" not in str(refused.value)


def test_a_domain_from_anywhere_is_named_by_module_and_name():
    assert load_domain("tamp.domains.kitchen:DOMAIN") is kitchen.DOMAIN


def test_a_skill_adds_its_pddl_to_what_is_there():
    domain = tabletop.DOMAIN.extended(BELL, name="bells")
    assert domain.pddl.actions.keys() == {*tabletop.DOMAIN.pddl.actions, "ring"}
    assert domain.strategy == tabletop.DOMAIN.strategy
    assert domain.words["ring"] == "ring {0}"
    assert "ring" not in tabletop.DOMAIN.words


@pytest.mark.parametrize(
    ("skill", "said"),
    [
        (replace(BELL, actions=("rings",)), "skill ring names 'rings'"),
        (replace(BELL, actions=()), "no skill has the action ring"),
        (replace(BELL, domain="(define (domain ring) (:action ring :effect (Rung)))"), "Rung|rung"),
    ],
)
def test_pddl_and_skills_that_do_not_fit_are_refused(skill, said):
    with pytest.raises(DomainError, match=said):
        _ = tabletop.DOMAIN.extended(skill, name="bells").pddl


@pytest.mark.parametrize("address", ["nowhere_at_all:RULES", "math:pi", "math:RULES"])
def test_rules_that_are_not_there_are_refused(address):
    with pytest.raises(DomainError, match=r"rules|mapping"):
        _ = tabletop.DOMAIN.extended(replace(BELL, rules=address), name="bells").rules


def test_goals_may_be_derived_of_what_skills_tell_of_and_of_nothing_else():
    derived = """(define (domain ring) (:predicates (Rung ?b) (Heard ?b) (Loud ?b) (Idle))
      (:derived (Heard ?b) (Rung ?b)) (:derived (Loud ?b) (and (Heard ?b) (HandEmpty))) (:derived (Idle) (HandEmpty))
      (:action ring :parameters (?b) :precondition (HandEmpty) :effect (Rung ?b)))"""
    told = replace(BELL, domain=derived, facts=lambda action: FactChange(added=(("rung", "bell"), ("heard", "bell"))))
    assert tabletop.DOMAIN.extended(told, name="bells").followed == {"rung", "heard", "loud"}
    assert not tabletop.DOMAIN.extended(replace(BELL, domain=derived), name="bells").followed


def test_facts_follow_from_timed_actions_in_their_order():
    domain: Domain = kitchen.DOMAIN
    cooked = domain.facts_after(
        (("sink", "basin"),), [Action("clean", ("egg", "basin"), ()), Action("cook", ("egg", "hob"), ())]
    )
    assert set(cooked) == {("sink", "basin"), ("cooked", "egg")}


def test_where_things_are_after_a_solution_follows_from_the_effects_of_its_actions():
    here, there = (Placement(Pose((x, 0.0, 0.0)), ("table",)) for x in (0.0, 0.1))
    moved = Skill("shift", actions=("shift",), effect=lambda action: SceneChange(None, {action.args[0]: there}))
    domain = Domain("shifting", (moved,), lambda workspace: ())
    placements, configuration = domain.after({"a": here, "b": here}, HOME, [GroundAction("shift", ("a",))])
    assert placements == {"a": there, "b": here}
    assert configuration == HOME
    with pytest.raises(ValueError, match="has no action 'jump'"):
        domain.effect(GroundAction("jump", ()))


def test_a_motionless_action_keeps_its_name_and_arguments():
    assert motionless(None, GroundAction("ring", ("bell",))) == Action("ring", ("bell",), ())
    assert BELL.facts(Action("ring", ("bell",), ())) == FactChange()


def test_an_action_that_no_rule_judges_is_said_before_anything_runs():
    with pytest.raises(DomainError, match="skill ring: the checker has no rule for 'ring'"):
        _ = tabletop.DOMAIN.extended(BELL, name="bells").rules


def test_what_a_skill_raises_is_said_with_its_line():
    def steps(timing, action):
        raise KeyError("bell")

    domain = tabletop.DOMAIN.extended(replace(BELL, effect=lambda ground: steps(None, ground)), name="bells")
    with pytest.raises(PartError, match=r"bells: effect of skill ring: KeyError: 'bell' at .*test_domain.py:\d+"):
        domain.effect(GroundAction("ring", ("b",)))


def test_a_package_that_cannot_be_imported_is_said_with_its_line(tmp_path, monkeypatch):
    (tmp_path / "brokenbells.py").write_text("import math\nmath.nothing\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(DomainError, match=r"'brokenbells' cannot be imported: AttributeError: .* at .*bells.py:2"):
        load_domain("brokenbells")


@pytest.mark.parametrize(
    ("part", "made", "said"),
    [
        ("steps", None, "steps of skill ring: expected Action, found None"),
        ("steps", ("ring",), r"steps of skill ring: expected Action, found \('ring',\)"),
        (
            "steps",
            Action("rings", ("b",), ()),
            r"make the action 'rings', .* no skill has words; did you mean 'ring'\?",
        ),
        ("effect", {}, "effect of skill ring: expected SceneChange, found {}"),
        ("facts", (("rung", "b"),), r"facts of skill ring: expected FactChange, found \(\('rung', 'b'\),\)"),
    ],
)
def test_what_a_function_of_a_skill_returns_is_what_the_manual_says(part, made, said):
    domain = tabletop.DOMAIN.extended(replace(BELL, **{part: lambda *given: made}), name="bells")
    workspace = tamp.prepare(tamp.Task("bells", ()))
    with pytest.raises(PartError, match=said):
        domain.facts_after((), domain.timed(workspace, [GroundAction("ring", ("b",))]))


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (None, "affordances of skill ring: expected Iterable, found None"),
        ("(rung b)", r"affordances of skill ring: expected Iterable, found '\(rung b\)'"),
        ([("Rungg", "b")], r"affordances of skill ring: no predicate 'Rungg'; did you mean 'rung'\?"),
    ],
)
def test_affordances_are_facts_of_the_domain(made, said):
    domain = tabletop.DOMAIN.extended(replace(BELL, affordances=lambda workspace, question: made), name="bells")
    with pytest.raises(PartError, match=said):
        domain.problem(tamp.prepare(tamp.Task("bells", ())), {}, Question(HOME))


@pytest.mark.parametrize("facts", [("rung", "b"), [("rung", "b")], (("rung", 1),), ((),)])
def test_facts_that_change_are_tuples_of_names(facts):
    with pytest.raises(PartError, match=r"FactChange: added is .*; valid is a tuple of facts"):
        FactChange(added=facts)


def test_the_actions_of_a_skill_are_a_tuple():
    with pytest.raises(DomainError, match=r"skill ring: actions is 'ring'; valid is a tuple"):
        replace(BELL, actions="ring")


def test_an_action_about_more_than_names_needs_steps():
    with pytest.raises(PartError, match=r"action ring: an argument is a Configuration, .* says by `steps`"):
        motionless(None, GroundAction("ring", ("bell", HOME)))


def test_rules_that_cannot_be_imported_are_said_with_their_line(tmp_path, monkeypatch):
    (tmp_path / "brokenrules.py").write_text("class Ring\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(DomainError, match=r"domain bells: rules .* cannot be imported: SyntaxError: .*rules.py:1"):
        _ = tabletop.DOMAIN.extended(replace(BELL, rules="brokenrules:RULES"), name="bells").rules
