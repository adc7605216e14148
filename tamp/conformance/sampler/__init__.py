"""The kit for samplers: does a sampler do what its stream promises?"""

from tamp.conformance.sampler.kit import check_sampler

__all__ = ["check_sampler"]
