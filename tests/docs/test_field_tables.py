"""The page of all fields is what the readers say of themselves."""

from pathlib import Path

from daq.documents.field_table import field_table
from rig.catalog.rig_file import rig_shape
from rig.importing.mapping import mapping_shape
from rig.protocol.load import protocol_shape
from rig.protocol.vary import Axes

PAGE = Path(__file__).parents[2] / "docs" / "fields.md"
HEAD = """\
# Every field, what it may be and its default

Made from the classes that read the files ([decision 9](decisions/0009-one-strict-reader.md)); `rig schema` writes
the same for editors. A number is in SI where it has no unit.
"""


def page() -> str:
    parts = {
        "Protocol": protocol_shape(Path(), Axes()),
        "Mapping of your own records": mapping_shape(),
        "Rig file": rig_shape(None),
    }
    return HEAD + "".join(f"\n## {title}\n{field_table(shape)}" for title, shape in parts.items())


def test_the_page_is_todays() -> None:
    """Written anew by `python tests/docs/test_field_tables.py`."""
    assert PAGE.read_text(encoding="utf-8") == page()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
