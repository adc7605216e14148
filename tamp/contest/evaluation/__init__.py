"""Running solutions: the simulated cell that answers their calls, one run, and what counts of all runs.

- workcell: robot, cameras and clock in a simulator
- session: the server's side of the socket
- trial: one run of a solution on a task, isolated and scored
- standings: best of runs, best of simulators, the ranking
"""
