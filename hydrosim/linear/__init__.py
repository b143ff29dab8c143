"""Results of one linearisation: modes, step limits, motions without steps. This package takes a
model and compiles none."""
