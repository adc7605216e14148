"""Which of the turns that a nearly symmetrical shape makes alike is the true one: by points, or by whole pictures."""
