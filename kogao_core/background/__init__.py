"""What the warp must not bend or move: straight lines and neighbours."""
