"""A file, or a folder, for each thing that a user can name."""
