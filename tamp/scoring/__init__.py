"""How well a task was done: the paper's EDE with its baselines, and the metrics of OCRTOC's own programs beside it."""

from tamp.scoring.ede import ede, upper_error_bound
from tamp.scoring.evaluate import Evaluation, ObjectError, evaluate
from tamp.scoring.metrics import METRICS, Metric, metric
from tamp.scoring.score import ObjectScore, Score, score

__all__ = [
    "METRICS", "Evaluation", "Metric", "ObjectError", "ObjectScore", "Score", "ede", "evaluate", "metric", "score",
    "upper_error_bound",
]  # fmt: skip
