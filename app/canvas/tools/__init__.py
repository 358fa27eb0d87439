"""Tools of the canvas: each gesture is one generator."""
