"""Read records from files: its meaning is read, asked for or refused, never guessed."""
