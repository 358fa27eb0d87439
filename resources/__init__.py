"""Files that travel with the program: the asset manifest, network weights, sample portraits."""
