"""The Standard API, the contestant's side: what `Solution.run(goal, robot)` is given, and how it reaches the server.

Imports NumPy and the standard library only.
"""
