"""Import of one record by the text of its mapping."""

from pathlib import Path
from typing import Any

from analysis import run_energy
from daq import open_session
from rig.importing.mapping import read_mapping
from rig.importing.to_session import import_records


def imported(folder: Path, file: Path, text: str) -> Any:
    """Return the energy of the only run of the session that `rig import` writes into the folder."""
    (folder / "map.yaml").write_text(text)
    import_records([file], read_mapping(folder / "map.yaml"), folder / "s.h5", overwrite=True)
    with open_session(folder / "s.h5") as record:
        assert not record.synthetic
        return run_energy(record, "run_0001").energy
