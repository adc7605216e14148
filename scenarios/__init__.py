"""Tasks, their objects, and the generators that made them."""
