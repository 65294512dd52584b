"""What a mismatch could depend on: generic quantities, tests of them, and corrections without a name."""
