"""The laboratory's commands of ``kogao-cli``."""
