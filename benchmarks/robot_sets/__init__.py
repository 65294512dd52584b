"""What sets of robots of several engines share: who hides what, how it is driven, measured, sized and recorded."""
