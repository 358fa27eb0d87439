"""The displacement field of all faces: spline, fade, protection, proofs against folds."""
