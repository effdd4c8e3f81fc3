"""What recordings and known poses tell of a joint's sensors."""
