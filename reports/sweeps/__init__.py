"""Many scenes that differ in a few numbers: the plan, the store, the workers, borders between answers, the table."""
