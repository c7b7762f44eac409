"""Plain switched systems in three states and more: cells of signs, Lyapunov functions by sums of squares, verdicts."""
