"""Linear analysis: equilibrium, natural modes, responses to waves."""
