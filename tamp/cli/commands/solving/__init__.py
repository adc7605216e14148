"""Tasks solved whole or step by step: solve, plan, check, execute, perceive."""
