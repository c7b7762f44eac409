"""Plain switched systems and given Lyapunov functions: ladder of derivatives, strong stability, audit of a V."""
