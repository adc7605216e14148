"""Many tasks, many workers, and a results file that survives a crash."""

from tamp.batch.run import RESULTS, Batch, run_together

__all__ = ["RESULTS", "Batch", "run_together"]
