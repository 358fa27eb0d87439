"""What a result says of its retouching."""
