"""The gallery of bad experiments: each is as wrong as its rule says, and right once its error is
taken away.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from daq.session.record import open_session
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.errors import InputError
from rig.protocol.deliberate_errors import DeliberateError
from rig.protocol.grid import conditions
from rig.protocol.load import dump_protocol, load_protocol

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "protocols" / "gallery").glob("*.yaml"))
KINDS = ("pole", "corners", "cycles", "skew", "clock", "coil", "offset", "friction")
NULL = ("scene.bed=[empty, locked]", "drive.acceleration=[1 m/s^2, 2 m/s^2, 3 m/s^2]")
every = pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)


def report_of(
    path: Path, out: Path, *sets: str, varies: tuple[str, ...] = (), workers: int = 2
) -> dict[str, Any]:
    protocol = load_protocol(path, sets, varies)
    return run(
        campaign_of(protocol, load_rig(protocol.rig), path.read_text()), out, workers=workers
    ).document()


def said_in_the_docs(kind: str) -> tuple[list[float], list[float]]:
    """Errors and the rule's, in %, of a row of the first table of docs/gallery.md."""
    rows = (ROOT / "docs" / "gallery.md").read_text().splitlines()
    cells = next(row for row in rows if row.startswith(f"| `{kind}` |")).split("|")
    found, rule = (
        [float(word) for word in cell.replace("%", "").split("/")] for cell in cells[5:7]
    )
    return found, rule


def test_every_deliberate_error_has_its_protocol() -> None:
    assert [path.stem for path in FILES] == sorted(KINDS)
    assert {load_protocol(path).deliberate_error.kinds for path in FILES} == {
        (kind,) for kind in KINDS
    }


@every
def test_it_is_as_wrong_as_its_rule_says(path: Path, tmp_path: Path) -> None:
    """At least 1 % wrong, and that within a tenth of the rule; the sheet of the report says so."""
    report = report_of(path, tmp_path)
    found = report["deliberate_error"]
    assert found["kind"] == path.stem
    assert [row["id"] for row in found["conditions"]] == [row["id"] for row in report["conditions"]]
    for row, condition in zip(found["conditions"], report["conditions"], strict=True):
        assert row["W_exp"] == condition["W_exp"]
        assert row["error"] == pytest.approx(row["W_exp"] / row["W_true"] - 1, abs=1e-12)
        assert abs(row["error"]) > 0.01
        assert abs(row["ratio"] - 1) < 0.10
    for name, said in zip(("error", "predicted"), said_in_the_docs(path.stem), strict=True):
        assert [100 * row[name] for row in found["conditions"]] == pytest.approx(
            said, rel=0.01, abs=0.06
        )
    # The friction is really there: only what it is taken for is wrong, and the chain has nothing to
    # complain of.
    assert report["verdict"] == ("passes" if path.stem == "friction" else "fails")
    for name in ("report.md", "report.html"):
        assert "This is a deliberately bad experiment: " in (tmp_path / name).read_text()
    assert json.loads((tmp_path / "report.json").read_text())["deliberate_error"] == found


@every
def test_without_the_error_it_is_right(path: Path, tmp_path: Path) -> None:
    """W_exp meets the right W of the bad experiment within U: deliberate errors leave the bed as it is."""
    bad = report_of(path, tmp_path / "bad")
    sets = ("scene.losses=[]", "scene.support=none") if path.stem == "friction" else ()
    good = report_of(path, tmp_path / "good", "deliberate_error={}", *sets)
    assert "deliberate_error" not in good
    assert "deliberate" not in (tmp_path / "good" / "report.html").read_text()
    assert good["verdict"] == "passes"
    for row, condition in zip(
        bad["deliberate_error"]["conditions"], good["conditions"], strict=True
    ):
        assert abs(condition["W_exp"] - row["W_true"]) <= condition["U_W_exp"]
        assert abs(condition["E_n_truth"]) <= 1


@pytest.mark.parametrize("kind", ["pole", "corners", "cycles", "skew", "clock", "offset"])
def test_the_locked_bed_finds_it(kind: str, tmp_path: Path) -> None:
    """The null's angle is eta times the relative error that the gallery's bed shows."""
    path = ROOT / "protocols" / "gallery" / f"{kind}.yaml"
    (null,) = report_of(path, tmp_path / "null", varies=NULL)["nulls"]
    row = report_of(path, tmp_path / "bed")["deliberate_error"]["conditions"][0]
    assert null["verdict"] == "does not hold"
    assert null["dphi"] == pytest.approx(row["predicted"] * row["eta"], rel=0.1)


def test_friction_is_no_angle_and_the_coil_shows_in_the_empty_box(tmp_path: Path) -> None:
    """Friction grows as a: the part growing as a^2 stays nil. The armature is in both boxes: the
    null takes it off, but the empty box weighs too little by k/w^2 - m."""
    folder = ROOT / "protocols" / "gallery"
    (null,) = report_of(folder / "friction.yaml", tmp_path / "friction", varies=NULL)["nulls"]
    assert null["verdict"] == "holds"
    assert (
        null["U_dphi"] < 1e-4
    )  # friction is distinguished from an angle: 5 mrad would be found fifty times over
    coil = report_of(folder / "coil.yaml", tmp_path / "coil", varies=NULL)
    assert [null["verdict"] for null in coil["nulls"]] == ["holds"]
    assert "does not hold" in {
        row["verdict"] for row in coil["references"] if row["reference"] == "rigid mass"
    }
    assert coil["verdict"] == "fails"


def test_a_longer_record_slides_further(tmp_path: Path) -> None:
    short, long = (
        report_of(
            ROOT / "protocols" / "gallery" / "clock.yaml",
            tmp_path / str(n),
            f"acquire.record={n} cycles",
        )
        for n in (20, 140)
    )
    for less, more in zip(
        short["deliberate_error"]["conditions"], long["deliberate_error"]["conditions"], strict=True
    ):
        assert more["error"] / less["error"] == pytest.approx((20 + 70) / (20 + 10), rel=0.02)
        assert abs(more["ratio"] - 1) < 0.10


@pytest.mark.parametrize("kind", ["clock", "skew", "coil"])
def test_codes_do_not_hang_on_the_number_of_workers(kind: str, tmp_path: Path) -> None:
    path = ROOT / "protocols" / "gallery" / f"{kind}.yaml"
    one, two = (
        report_of(path, tmp_path / str(n), "acquire.record=12 cycles", workers=n) for n in (1, 2)
    )
    assert one == two


def test_the_analysis_needs_no_truth_to_read_wrongly_or_rightly(tmp_path: Path) -> None:
    """The record says what was done; without the ledger the right W is not known, and said so."""
    from analysis.pipeline import read_session

    class Blind:
        """A record whose truth was deleted."""

        truth = None

        def __init__(self, record: Any) -> None:
            self._record = record

        def __getattr__(self, name: str) -> Any:
            return getattr(self._record, name)

    report = report_of(ROOT / "protocols" / "gallery" / "skew.yaml", tmp_path)
    with open_session(tmp_path / "session.h5") as record:
        blind = read_session(Blind(record)).document()
    for row, full in zip(
        blind["deliberate_error"]["conditions"],
        report["deliberate_error"]["conditions"],
        strict=True,
    ):
        assert row["W_exp"] == full["W_exp"]
        assert row["W_true"] is row["error"] is row["ratio"] is None


@every
def test_the_protocol_survives_the_file(path: Path) -> None:
    protocol = load_protocol(path)
    text = dump_protocol(protocol)
    assert load_protocol(text) == protocol
    assert dump_protocol(load_protocol(text)) == text
    plain = load_protocol(path, ("deliberate_error={}",))
    assert plain.deliberate_error == DeliberateError()
    assert "deliberate_error" not in dump_protocol(plain)
    keys = [[c.seed_key for c in conditions(p)] for p in (protocol, plain)]
    assert keys[0] == keys[1]


BAD = {
    "deliberate_error={skw: 1}": ("deliberate_error.skw", "skew"),
    "deliberate_error={skew: 0}": ("deliberate_error.skew", "at least 1 samples"),
    "deliberate_error={skew: 1, clock: 50 ppm}": ("skew and clock", "one deliberate error at most"),
    "deliberate_error={pole: 0.5}": ("a pole of ideal", "a sensor with a time constant"),
    "deliberate_error={cycles: 40.3}": ("40.3 of 40 cycles", "acquire.record"),
    "deliberate_error={clock: 50}": (),
    "deliberate_error={friction: true}": ("deliberate_error.friction", "support guide"),
    "deliberate_error={coil: 1}": ("deliberate_error.coil", "true or false"),
}


@pytest.mark.parametrize("change", BAD)
def test_what_cannot_be_done_wrong_is_refused(change: str) -> None:
    path = ROOT / "protocols" / "gallery" / "skew.yaml"
    if not BAD[change]:
        assert load_protocol(path, (change,)).deliberate_error.clock == 50.0
        return
    with pytest.raises(InputError) as error:
        load_protocol(path, (change,))
    for words in BAD[change]:
        assert words in str(error.value)
