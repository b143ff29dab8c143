"""What follows from one linearisation: modes, step limits, motions without steps. Takes a model,
compiles none."""
