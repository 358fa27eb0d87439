"""Section 4: pixels from a field, in fixed blocks."""
