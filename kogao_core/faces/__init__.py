"""3.1 and 3.2 of the paper: feature points, centres and target points."""
