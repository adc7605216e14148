"""Pick, place and unstack at a table."""

from tamp.domains.tabletop.assembly import NotFree, assemble
from tamp.domains.tabletop.problem import DEFAULT_SAMPLERS, DOMAIN, STREAMS, VARIANTS, tabletop_problem

__all__ = ["DEFAULT_SAMPLERS", "DOMAIN", "STREAMS", "VARIANTS", "NotFree", "assemble", "tabletop_problem"]
