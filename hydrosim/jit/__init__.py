"""How kernels become machine code, each once, and how wide tuples are handed to them."""
