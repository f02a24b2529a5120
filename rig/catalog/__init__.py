"""Materials, exciters, transducers, analyzers and rigs: data files in which every number states its origin."""

from rig.catalog.entries import CatalogValue, Exciter, Material, Rig
from rig.catalog.rigfile import dump_rig, load_rig, rig_names, rig_with_losses
from rig.catalog.shelves import analyzer, exciter, material, names, transducer
from rig.catalog.table import Row, listing

__all__ = [
    "CatalogValue",
    "Exciter",
    "Material",
    "Rig",
    "Row",
    "analyzer",
    "dump_rig",
    "exciter",
    "listing",
    "load_rig",
    "material",
    "names",
    "rig_names",
    "rig_with_losses",
    "transducer",
]
