"""What a result says, apart from where it is read: one document, which a terminal, a page or a
notebook renders."""
