"""A report with every part of the page, made without the stand."""

import numpy as np
from analytic_record import NOMINAL, Bench, condition, dashpot_energy, prediction_for, session

from analysis import Report, read_session


def demo_report() -> Report:
    """Sixteen conditions, four repeats each, a null, text that is not safe as it is."""
    table = [
        condition(
            f"c{i}{j}",
            fill=fill,
            bed_mass=44.8 * fill,
            carried=fill == 1,
            acceleration_set=a,
            settle_cycles=1,
            record_cycles=4,
        )
        for i, fill in enumerate((0.0, 0.5, 0.9, 1.0))
        for j, a in enumerate((2.0, 3.0, 4.0, 5.0))
    ]

    def bed(entry):
        return 300 * entry["fill"] * (entry["fill"] < 1)

    documents = {
        "prediction": prediction_for(table, lambda entry, a: dashpot_energy(bed(entry), a), 1e-3),
        "protocol": {"name": "demo", "question": "Is 5 < 6 & true?"},
        "rig": {
            "values": [
                {
                    "path": "mu",
                    "value": 0.45,
                    "unit": "",
                    "status": "assumed",
                    "source": "<b>us</b> | me",
                }
            ]
        },
    }
    bench = Bench(channels=dict(NOMINAL), noise=(0.02, 5e-4), level_error=0.003, samples=6 * 512)
    return read_session(
        session(
            table, lambda entry, _r: 20 + bed(entry), bench, np.random.default_rng(4), **documents
        )
    )
