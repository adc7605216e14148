"""What runs have come to: score, compare, report, render, view."""
