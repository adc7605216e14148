"""Blocksworld without streams: turn a tower over."""

from tamp.planning import Problem

DOMAIN = """
(define (domain blocksworld)
  (:requirements :strips)
  (:predicates (clear ?x) (on-table ?x) (arm-empty) (holding ?x) (on ?x ?y))
  (:action pick-up
    :parameters (?x)
    :precondition (and (clear ?x) (on-table ?x) (arm-empty))
    :effect (and (holding ?x) (not (clear ?x)) (not (on-table ?x)) (not (arm-empty))))
  (:action put-down
    :parameters (?x)
    :precondition (holding ?x)
    :effect (and (clear ?x) (arm-empty) (on-table ?x) (not (holding ?x))))
  (:action stack
    :parameters (?x ?y)
    :precondition (and (clear ?y) (holding ?x))
    :effect (and (arm-empty) (clear ?x) (on ?x ?y) (not (clear ?y)) (not (holding ?x))))
  (:action unstack
    :parameters (?x ?y)
    :precondition (and (on ?x ?y) (clear ?x) (arm-empty))
    :effect (and (holding ?x) (clear ?y) (not (on ?x ?y)) (not (clear ?x)) (not (arm-empty)))))
"""


def inversion(n: int) -> Problem:
    """A tower of n blocks, to be built again upside down: 2n actions at least where n > 1."""
    blocks = [f"b{i}" for i in range(n)]
    tower = list(zip(blocks[1:], blocks, strict=False))
    init = [("arm-empty",), ("on-table", blocks[0]), ("clear", blocks[-1]), *(("on", a, b) for a, b in tower)]
    return Problem(domain=DOMAIN, streams=None, samplers={}, init=init, goal=("and", *(("on", b, a) for a, b in tower)))
