"""Cook and clean: a second domain over the tabletop's samplers, small enough to copy from."""

from tamp.domains.kitchen.problem import DEFAULT_SAMPLERS, kitchen_problem
from tamp.domains.kitchen.timing import assemble

__all__ = ["DEFAULT_SAMPLERS", "assemble", "kitchen_problem"]
