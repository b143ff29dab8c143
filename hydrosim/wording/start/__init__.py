"""What `check` says of the start of a run."""
