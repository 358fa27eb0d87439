"""What is not in the paper: lens, head, photo edge, exact fit, guard, strokes, limits."""
