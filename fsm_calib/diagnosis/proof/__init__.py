"""What a name must withstand: held-out recordings, forms without a name, plausibility, necessity."""
