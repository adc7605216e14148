"""The conformance kit: does what somebody swaps in do what its place asks for? Says in words what is wrong."""

from tamp.conformance.findings import Finding, Judgement
from tamp.conformance.sampler import check_sampler

__all__ = ["Finding", "Judgement", "check_sampler"]
