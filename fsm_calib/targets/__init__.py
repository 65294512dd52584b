"""What a person prints and lays out: boards, floor tags and the whole area at true scale, and the plan of it."""
