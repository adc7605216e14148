"""What a domain tells before any search: invariants, fluents apart, connectors, parameters that any object fills."""
