"""Many runs at once, into one file: by threads, processes or a cluster."""
