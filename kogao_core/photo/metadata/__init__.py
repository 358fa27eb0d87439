"""What a file holds beside its pixels."""
