"""A sealed benchmark of robots in PhysX, written from textbooks and data sheets, blind to the program under test."""
