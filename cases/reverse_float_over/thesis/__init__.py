"""The thesis (Plasterk 2017) held against many seeds:
``python -m cases.reverse_float_over.thesis --seeds 50``.

Each table is a module with

    TABLE: str                                        # title
    VARIANTS: Mapping[str, Mapping[str, object]]      # settings of each variant
    def figures(variant: str, seed: int) -> dict[str, float]    # of one run

`runner` computes and keeps the figures of every run, `aggregates` has their intervals, `score`
holds them against the statements of the thesis.
"""
