"""Where an object is that should be somewhere: in the hand, or about where it was let go or pushed to."""
