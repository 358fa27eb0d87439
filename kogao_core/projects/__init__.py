"""What was done to a photo, as a file; landmarks from other programs and for them."""
