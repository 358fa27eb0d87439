"""2, 3.3 and 4 of the paper: the lattice, its fit, the domain, the resampling."""
