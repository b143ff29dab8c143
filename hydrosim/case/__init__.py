"""Case files: YAML, checked key by key, with units."""

from hydrosim.case.load import Case, as_case, load_case

__all__ = ["Case", "as_case", "load_case"]
