"""The contest: API, sandbox, evaluation, service."""
