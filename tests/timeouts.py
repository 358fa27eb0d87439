"""How long a test waits for what must come; where it comes at once, nothing is lost."""

LONGEST_S = 60.0
