"""Many tasks, many workers, and a results file that survives a crash."""

from tamp.batch.run import RESULTS, Batch

__all__ = ["RESULTS", "Batch"]
