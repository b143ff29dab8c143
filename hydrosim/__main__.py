"""`python -m hydrosim` is the command `hydrosim`."""

from hydrosim.cli import main

if __name__ == "__main__":
    main()
