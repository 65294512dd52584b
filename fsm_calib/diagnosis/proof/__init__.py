"""What a name must withstand: held-out recordings, forms without a name, plausibility, one law in all drives."""
