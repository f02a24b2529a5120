"""Materials, exciters, transducers, analyzers and rigs: data files in which every number states its
origin.
"""
