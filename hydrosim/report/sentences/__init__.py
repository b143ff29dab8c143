"""What each kind of result says, worded once: a file for each, which gives a document."""
