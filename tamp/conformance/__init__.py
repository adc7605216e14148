"""The conformance kit: does a sampler do what its stream promises? Says in words what is wrong."""

from tamp.conformance.findings import Finding, Judgement
from tamp.conformance.kit import check_sampler

__all__ = ["Finding", "Judgement", "check_sampler"]
