"""Disclosure of a retouch: edit record and label."""
