"""The linear analysis: place at rest, natural modes, responses to waves."""
