"""Numbers of one real field per scene, polynomials over them, and the interface that they share."""
