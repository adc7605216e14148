"""The kit for skills: those that come along fit, and of each broken one its fault is told."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tamp
from tamp.checking.actions.rule import carry_out, has_steps
from tamp.conformance.skill import check_skill
from tamp.domains import tabletop
from tamp.domains.domain import Domain
from tamp.domains.skill import FactChange, SceneChange, Skill
from tamp.domains.tabletop.handling import put_down_effect, take_effect
from tamp.errors import PartError
from tamp.streams.values import ArmPath, Configuration
from tamp.task import Action

SCENARIOS = Path(tamp.__file__).parent / "scenarios"

PDDL = """(define (domain wave)
  (:predicates (Public ?b) (WaveMotion ?b ?q ?m) (Waved ?b) (Seen ?b))
  (:action wave :parameters (?b ?q ?m)
    :precondition (and (WaveMotion ?b ?q ?m) (AtConf ?q) (HandEmpty)) :effect (Waved ?b)))"""
STREAMS = """(define (stream wave)
  (:stream plan-wave :inputs (?b) :domain (Public ?b) :outputs (?q ?m)
    :certified (and (Conf ?q) (WaveMotion ?b ?q ?m))))"""
COUNT = itertools.count()


def plan_wave(context: Any, public: str) -> Iterator[tuple[Configuration, ArmPath]]:
    """The last joint turns and comes back."""
    spec = context.scene.world.robot.spec
    home = np.array(spec.home)
    there = home + np.array([*(0.0,) * (len(home) - 1), 0.3])
    yield Configuration(tuple(home), spec.gripper.stroke), ArmPath(np.array([home, there, home]))


def plan_nothing(context: Any, public: str) -> Iterator[tuple[Configuration, ArmPath]]:
    yield from ()


def plan_alone(context: Any) -> Iterator[tuple[Configuration, ArmPath]]:
    yield from ()


def steps(timing: Any, action: Any, part: slice = slice(None), name: str = "wave") -> Action:
    public, start, motion = action.args
    return Action(name, (public,), (timing.move("transit", motion.points[part], start.opening),))


def other_steps(timing: Any, action: Any) -> Action:
    """Another way each time."""
    public, start, motion = action.args
    points = np.array(motion.points)
    points[1, -1] += 0.01 * next(COUNT)
    return Action("wave", (public,), (timing.move("transit", points, start.opening),))


def raising(*given: Any) -> Any:
    raise RuntimeError("the arm is tired")


class Wave:
    """The rule: the arm moves, and comes back."""

    def check(self, replay: Any, action: Any) -> None:
        if not has_steps(replay, action):
            return
        if len(action.steps) != 1 or np.ptp(action.steps[0].trajectory.positions[:, -1]) < 0.2:
            replay.report("precondition", "nobody sees that")
            return
        carry_out(replay, action.steps[0])
        replay.state.facts.add(("waved", action.arguments[0]))


class Refusing(Wave):
    def check(self, replay: Any, action: Any) -> None:
        replay.report("precondition", "waving is not allowed")


class Knowing(Wave):
    def check(self, replay: Any, action: Any) -> None:
        super().check(replay, action)
        replay.state.facts.add(("waved", "box"))


class Blind(Wave):
    """Believes everything."""

    def check(self, replay: Any, action: Any) -> None:
        replay.state.facts.add(("waved", "crowd"))


class Trusting(Wave):
    """Does not ask whether there are any steps."""

    def check(self, replay: Any, action: Any) -> None:
        if has_steps(replay, action):
            for step in action.steps:
                carry_out(replay, step)
            replay.state.facts.add(("waved", action.arguments[0]))


class Hasty(Wave):
    """Takes it that there is one step."""

    def check(self, replay: Any, action: Any) -> None:
        (_,) = action.steps
        super().check(replay, action)


RULES = {"wave": Wave()}
REFUSING, KNOWING = {"wave": Refusing()}, {"wave": Knowing()}
BLIND, TRUSTING, HASTY = {"wave": Blind()}, {"wave": Trusting()}, {"wave": Hasty()}

HERE = __name__
WAVE = Skill(
    name="wave",
    actions=("wave",),
    domain=PDDL,
    streams=STREAMS,
    samplers={"plan-wave": f"{HERE}:plan_wave"},
    steps=steps,
    facts=lambda action: FactChange(added=(("waved", action.arguments[0]),)),
    rules=f"{HERE}:RULES",
    words={"wave": "wave to {0}"},
)


def told(*added: Any, deleted: Any = ()) -> Any:
    return lambda action: FactChange(added=added, deleted=deleted)


def shown(*facts: Any) -> Any:
    return lambda workspace, question: facts


BROKEN: dict[str, tuple[dict[str, Any], str]] = {
    "unserved": ({"samplers": {"plan-wave": f"{HERE}:nowhere"}}, "samplers: sampler for plan-wave: .* has no function"),
    "misfit": ({"samplers": {"plan-wave": f"{HERE}:plan_alone"}}, r"samplers: .*expected a function of \(context, b\)"),
    "unruled": ({"rules": None}, "domain: domain own: skill wave: the checker has no rule for 'wave'"),
    "sad": ({"affordances": raising}, "affordances: affordances: it raised RuntimeError: the arm is tired at "),
    "unknown": (
        {"affordances": shown(("Publick", "box"))},
        r"affordances: affordances gives \('Publick', 'box'\): no predicate of domain own is called 'Publick'",
    ),
    "wordy": (
        {"affordances": shown(("Public", "box", "bell"))},
        r"affordances: affordances gives .*: Public takes 1 arguments, not 2",
    ),
    "factless": ({"affordances": shown("Public")}, "a fact is a tuple of its predicate and arguments"),
    "prior": ({"affordances": shown(("Waved", "crowd"))}, r"affordances: affordances gives .* which actions change"),
    "moody": (
        {"affordances": lambda workspace, question: [("Public", f"box{next(COUNT)}")]},
        "affordances: affordances gives 1 facts, and others the second time",
    ),
    "silent": (
        {"samplers": {"plan-wave": f"{HERE}:plan_nothing"}},
        "plan: there is no plan of task parade, ",
    ),
    "changeless": ({"effect": lambda action: None}, "effect: effect of wave must be a SceneChange, found None"),
    "drifting": (
        {"effect": lambda action: SceneChange(Configuration((0.0,) * 7, 0.08))},
        r"effect: effect of wave leaves the arm in another configuration than the PDDL's \(AtConf\)",
    ),
    "thieving": (
        {"effect": lambda action: SceneChange(placements={"box": None})},
        r"effect: effect of wave moves box, and its PDDL does not \(AtPose\)",
    ),
    "tired": ({"steps": raising}, "steps: domain own: steps of skill wave: RuntimeError: the arm is tired at "),
    "stepless": ({"steps": lambda timing, action: None}, "steps: .* steps of skill wave: expected Action, found None"),
    "wordless": (
        {"steps": lambda timing, action: steps(timing, action, name="beckon")},
        "steps: .* steps of skill wave make the action 'beckon', for which no skill has words",
    ),
    "nameless": (
        {"steps": lambda timing, action: replace(steps(timing, action), arguments=(7,))},
        "steps: steps of wave: the arguments of an Action are names, found 7",
    ),
    "whimsical": ({"steps": other_steps}, "steps: steps gives other steps for the same action the second time"),
    "jumping": (
        {"steps": lambda timing, action: steps(timing, action, part=slice(1, None))},
        "steps: steps of wave: the transit motion begins 0.300 rad from where the arm is",
    ),
    "staying": (
        {"steps": lambda timing, action: steps(timing, action, part=slice(0, 2))},
        "steps: steps of wave end 0.300 rad from where effect says that the arm is then",
    ),
    "vain": ({"facts": lambda action: (("waved", "crowd"),)}, "facts: facts of wave must be a FactChange, found "),
    "loud": ({"facts": told(("Waved", "crowd"))}, r"facts: facts of wave gives .*: predicates are in lower case here"),
    "boasting": (
        {"facts": told(("waved", "crowd"), ("seen", "crowd"))},
        r"facts: facts of wave makes \(seen crowd\) true, its PDDL does not",
    ),
    "modest": ({"facts": told()}, r"facts: the PDDL of wave makes \(waved crowd\) true, facts does not"),
    "wrong": (
        {"facts": told(deleted=(("waved", "crowd"),))},
        r"facts: facts of wave makes \(waved crowd\) false, its PDDL does not",
    ),
    "refused": ({"rules": f"{HERE}:REFUSING"}, "rules: the checker refuses the plan: .* waving is not allowed"),
    "knowing": (
        {"rules": f"{HERE}:KNOWING"},
        r"rules: after the plan \(waved box\) holds by its rules, and not by its",
    ),
    "blind": ({"rules": f"{HERE}:BLIND"}, "attacks: the checker accepts wave of 'nobody', which the task has not: its"),
    "trusting": ({"rules": f"{HERE}:TRUSTING"}, "attacks: the checker accepts wave without steps: its rule does not"),
    "hasty": (
        {"rules": f"{HERE}:HASTY"},
        "attacks: rule for wave without steps: the checker's rule for 'wave': it raised ValueError: .*test_skill.py:",
    ),
}
DOMAIN = tabletop.DOMAIN.extended(WAVE, name="own", strategy="all-at-once")
DOMAINS = {
    name: tabletop.DOMAIN.extended(replace(WAVE, **changed), name="own", strategy="all-at-once")
    for name, (changed, _) in BROKEN.items()
}


def __getattr__(name: str) -> Domain:
    """A broken domain, as `load_domain` looks it up in this module."""
    if name in DOMAINS:
        return DOMAINS[name]
    raise AttributeError(name)


def parade(**changed: Any) -> tamp.Task:
    crowd = tamp.Region("crowd", center=(0.1, -0.2), size=(0.1, 0.1))
    box = tamp.Object("box", tamp.Box((0.05, 0.05, 0.08)), tamp.Pose((0.05, 0.2, 0.04)))
    task = tamp.Task("parade", (box,), regions=(crowd,), init=(("Public", "crowd"),), goal=(("Waved", "crowd"),))
    return replace(task, **{"domain": f"{HERE}:DOMAIN", **changed})


def test_a_skill_of_ones_own_fits() -> None:
    judgement = check_skill(f"{HERE}:DOMAIN", "wave", parade())
    assert judgement.fits and {f.outcome for f in judgement.findings} == {"ok"}, str(judgement)
    checks = ["domain", "samplers", "affordances", "plan", "effect", "steps", "facts", "rules", "attacks"]
    assert [f.check for f in judgement.findings] == checks
    assert judgement.findings[-1].text == "3 spoilt actions are refused"
    assert judgement.as_dict()["skill"] == f"wave of {HERE}:DOMAIN"


@pytest.mark.parametrize("name", BROKEN)
def test_the_fault_of_a_broken_skill_is_told(name: str) -> None:
    judgement = check_skill(f"{HERE}:{name}", "wave", parade(domain=f"{HERE}:{name}"), timeout=5.0)
    (said,) = [f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "wrong"]
    assert re.search(BROKEN[name][1], said) and "\n" not in said, said


def test_a_task_that_does_not_need_the_skill_tells_nothing() -> None:
    finding = check_skill(f"{HERE}:DOMAIN", "wave", parade(goal=())).findings[-1]
    assert finding.outcome == "wrong" and re.search(
        r"the plan of task parade \(.*\) has none of wave; give a task that the skill is needed for", finding.text
    ), finding


def elsewhere(action: Any) -> SceneChange:
    """What is put down is where it was before."""
    change = take_effect(action) if action.name == "pick" else put_down_effect(action)
    return replace(change, placements=dict.fromkeys(change.placements))


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (lambda action: SceneChange(), r"the PDDL of pick moves the arm \(AtConf\), and effect leaves it where it was"),
        (
            lambda action: SceneChange(action.args[-2]),
            r"the PDDL of pick moves red \(AtPose\), and effect says nothing of it",
        ),
        (elsewhere, r"effect of place leaves red elsewhere than its PDDL does \(AtPose\)"),
    ],
)
def test_an_effect_that_moves_less_than_the_pddl_is_told(
    effect: Any, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    skills = [replace(s, effect=effect) if s.name == "pick-and-place" else s for s in tabletop.DOMAIN.skills]
    monkeypatch.setitem(DOMAINS, f"putting{next(COUNT)}", replace(tabletop.DOMAIN, skills=tuple(skills)))
    task = tamp.load_task(SCENARIOS / "one_object.yaml")
    finding = check_skill(f"{HERE}:{list(DOMAINS)[-1]}", "pick-and-place", task).findings[-1]
    assert finding.check == "effect" and re.search(said, finding.text), finding


@pytest.mark.parametrize(
    ("domain", "skill", "scenario"),
    [
        ("tabletop", "tabletop", "one_object"),
        ("tabletop", "pick-and-place", "one_object"),
        ("tabletop", "move", "one_object"),
        ("tabletop", "slide", "slide_to_goal"),
        ("tabletop", "nudge", "nudge_in_crate"),
        ("tabletop", "tilted-release", "lay_book"),
        ("tabletop", "topple", "topple_pail"),
        ("kitchen", "cook-and-clean", "cook_dinner"),
    ],
)
def test_a_skill_that_comes_along_fits(domain: str, skill: str, scenario: str) -> None:
    judgement = check_skill(domain, skill, tamp.load_task(SCENARIOS / f"{scenario}.yaml"))
    assert judgement.fits and {f.outcome for f in judgement.findings} == {"ok"}, str(judgement)


def test_a_skill_or_a_domain_that_is_not_there_is_told() -> None:
    task = parade(domain="tabletop", init=(), goal=())
    for domain, skill, said in (
        ("kitchen", "fly", "domain kitchen has no skill 'fly'; it has tabletop, move, "),
        ("kichen", "fly", "unknown domain 'kichen'"),
    ):
        (finding,) = check_skill(domain, skill, task).findings
        assert finding.outcome == "wrong" and said in finding.text, finding


def test_a_rule_that_raises_is_one_sentence_to_whoever_asks_the_checker() -> None:
    plan = tamp.Plan("parade", "panda", 0, {"box": parade().objects[0].pose}, (0.0,) * 7, {}, (Action("wave", (), ()),))
    with pytest.raises(PartError, match=r"the checker's rule for 'wave': it raised ValueError: .*test_skill.py:\d+"):
        tamp.check(parade(), plan, domain=f"{HERE}:hasty")
