"""Tasks, plans and pictures made or translated: generate, dataset, import, export."""
