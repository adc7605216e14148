"""The independent plan checker."""
