"""Make bundles and release files; not part of the wheel."""
