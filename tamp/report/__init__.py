"""Pictures of scenes, plans and executions."""
