"""What there is to set, the choices of a user as one value, and such values with names."""
