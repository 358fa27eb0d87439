"""Files damaged at random, and programs that have to bear them; all of it follows from a seed."""
