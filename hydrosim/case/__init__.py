"""Case files: YAML, checked key by key, with units."""

from hydrosim.case.load import Case, load_case

__all__ = ["Case", "load_case"]
