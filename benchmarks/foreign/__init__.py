"""A sealed benchmark of robots whose physics was written from textbooks, blind to the program under test."""
