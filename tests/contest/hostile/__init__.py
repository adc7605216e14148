"""Solutions that misbehave, one way each; what stops them, and what that is called, is in their first line."""
