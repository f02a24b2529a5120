"""Claims in a protocol: what is read, every mistake by name, and which conditions decide them."""

import pytest

from rig.campaign.claim_cases import cases, label, varied
from rig.errors import InputError
from rig.protocol.grid import conditions
from rig.protocol.load import dump_protocol, load_protocol
from rig.protocol.spec import Expect, Protocol

HEAD = "schema: rig/protocol/1\nname: x\n"
GRID = """\
vary:
  scene.grains.fill: [0 %, 50 %, 90 %]
  drive.acceleration: [3 m/s^2, 5 m/s^2]
"""


def claims_of(*entries: str, grid: str = GRID) -> tuple[Expect, ...]:
    return load_protocol(
        HEAD + grid + "expect:\n" + "".join(f"  - {{{entry}}}\n" for entry in entries)
    ).expect


def cases_of(entry: str, grid: str = GRID) -> list[dict[str, object]]:
    protocol = load_protocol(f"{HEAD}{grid}expect:\n  - {{{entry}}}\n")
    return cases(protocol, conditions(protocol))[0]["cases"]


def test_quantities_are_read_as_elsewhere_and_margins_have_defaults() -> None:
    best, order, rise, curve, zero, offset = claims_of(
        "claim: a, optimum: scene.grains.fill, value: 90 %, at: {drive.acceleration: [3, 5 m/s^2]}",
        "claim: a, order: scene.grains.material, values: [alumina, heavy], over: drive.acceleration",
        "claim: a, rise: scene.grains.diameter, from: 1 mm, to: 5 mm",
        "claim: a, nonlinear: drive.acceleration",
        "claim: a, nearly_zero: scene.bed, value: empty, full: layers",
        "claim: a, offset_within: [5.5 %, 8.5 %], per: scene.grains.material, imposed: it was put in",
    )
    assert best == Expect(
        "a", "optimum", "scene.grains.fill", (0.9,), {"drive.acceleration": (3.0, 5.0)}
    )
    assert order == Expect(
        "a", "order", "scene.grains.material", ("alumina", "heavy"), over="drive.acceleration"
    )
    assert rise.values == (0.001, 0.005)
    assert curve.limits == (0.1,)
    assert zero.limits == (0.02,)
    assert offset.limits == pytest.approx((0.055, 0.085))
    assert offset.imposed == "it was put in"


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("claim: a, optimun: scene.grains.fill, value: 90 %", "did you mean 'optimum'?"),
        ("claim: a, value: 90 %", "found a claim without a kind"),
        ("claim: a, rise: scene.bed, fall: scene.bed", "found the kinds rise and fall"),
        ("claim: a, optimum: scene.grains.fil, value: 1", "did you mean 'scene.grains.fill'?"),
        ("claim: a, optimum: scene.grains, value: 1", "found 'scene.grains'"),
        ("claim: a, optimum: scene.losses, value: noise", "found 'scene.losses'"),
        ("claim: a, optimum: scene.grains.fill, valu: 1", "did you mean 'value'?"),
        ("claim: a, optimum: scene.grains.fill", "found no value"),
        ("optimum: scene.grains.fill, value: 1", "found no claim"),
        ("claim: ' ', optimum: scene.grains.fill, value: 1", "found no words"),
        ("claim: a, optimum: scene.grains.fill, value: 90", "did you mean 90 %?"),
        ("claim: a, optimum: scene.grains.fill, value: []", "found an empty list"),
        ("claim: a, rise: scene.grains.diameter, from: 1 mm, to: 1 mm", "found a value twice"),
        ("claim: a, rise: scene.grains.diameter, from: [1 mm], to: 1 mm", "found a list"),
        ("claim: a, rise: scene.grains.diameter, from: 1 s, to: 2 mm", "found '1 s'"),
        ("claim: a, order: scene.bed, values: [empty]", "found one value"),
        ("claim: a, nonlinear: drive.frequency", "allowed: drive.acceleration"),
        ("claim: a, nonlinear: drive.acceleration, margin: 0", "found 0"),
        ("claim: a, nearly_zero: scene.bed, value: emty, full: layers", "did you mean 'empty'?"),
        ("claim: a, offset_within: 7 %", "a list of two numbers"),
        ("claim: a, offset_within: [8 %, 5 %]", "the lower limit first"),
        (
            "claim: a, offset_within: [5 %, 8 %], at: {scene.grain.fill: 1}",
            "did you mean 'scene.grains.fill'?",
        ),
        ("claim: a, offset_within: [5 %, 8 %], at: 5", "found 5"),
        ("claim: a, offset_within: [5 %, 8 %], imposed: true", "found True"),
    ],
)
def test_mistakes_are_named_with_their_line(entry: str, found: str) -> None:
    with pytest.raises(InputError) as error:
        claims_of("claim: a, optimum: scene.grains.fill, value: 0.5", entry)
    text = str(error.value)
    assert found.lower() in text.lower()
    assert all(line.startswith("protocol:8: expect[2]") for line in text.splitlines())


def test_a_claim_built_in_python_is_checked_too() -> None:
    with pytest.raises(InputError, match="without a kind"):
        conditions(Protocol("x", expect=(Expect("a", "best"),)))
    with pytest.raises(InputError, match=r"scene\.fill"):
        conditions(Protocol("x", expect=(Expect("a", "optimum", "scene.fill", (1,)),)))


def test_a_claim_is_judged_at_every_combination_of_the_others() -> None:
    assert cases_of("claim: a, optimum: scene.grains.fill, value: 90 %") == [
        {
            "at": {"drive.acceleration": f"{a} m/s^2"},
            "levels": [
                {"value": v, "conditions": [c]}
                for v, c in zip(("0.00", "0.50", "0.90"), ids, strict=True)
            ],
        }
        for a, ids in ((3, ("c01", "c03", "c05")), (5, ("c02", "c04", "c06")))
    ]


def test_at_restricts_and_over_takes_conditions_together() -> None:
    one = cases_of(
        "claim: a, fall: scene.grains.fill, from: 90 %, to: 50 %, at: {drive.acceleration: 5}"
    )
    assert one == [
        {
            "at": {},
            "levels": [
                {"value": "0.90", "conditions": ["c06"]},
                {"value": "0.50", "conditions": ["c04"]},
            ],
        }
    ]
    both = cases_of(
        "claim: a, nearly_zero: scene.grains.fill, value: 0, full: 90 %, at: {scene.grains.fill: [0, 90 %]}"
    )
    assert [case["at"] for case in both] == [
        {"drive.acceleration": "3 m/s^2"},
        {"drive.acceleration": "5 m/s^2"},
    ]
    (mean,) = cases_of(
        "claim: a, optimum: scene.grains.fill, value: 90 %, over: drive.acceleration"
    )
    assert mean == {"at": {}, "levels": [
        {"value": "0.00", "conditions": ["c01", "c02"]}, {"value": "0.50", "conditions": ["c03", "c04"]},
        {"value": "0.90", "conditions": ["c05", "c06"]}]}  # fmt: skip


def test_offsets_are_taken_over_all_or_per_value() -> None:
    (whole,) = cases_of("claim: a, offset_within: [5 %, 8 %]")
    assert whole == {
        "at": {},
        "levels": [{"value": "", "conditions": [f"c0{n}" for n in range(1, 7)]}],
    }
    per = cases_of("claim: a, offset_within: [5 %, 8 %], per: scene.grains.fill")
    assert [case["at"] for case in per] == [
        {"scene.grains.fill": v} for v in ("0.00", "0.50", "0.90")
    ]


def test_fields_that_vary_together_make_no_cases() -> None:
    grid = "vary: {zip: {scene.grains.diameter: [2 mm, 4 mm], drive.frequency: [20 Hz, 30 Hz]}}\n"
    (case,) = cases_of("claim: a, rise: scene.grains.diameter, from: 2 mm, to: 4 mm", grid)
    assert [level["value"] for level in case["levels"]] == ["2 mm", "4 mm"]


def test_what_the_grid_lacks_gives_no_level_and_no_mistake() -> None:
    """--set may take an axis away: the claim stays, and the report says that nothing decides it."""
    (case,) = cases_of("claim: a, optimum: scene.grains.fill, value: 90 %", "")
    assert case["levels"] == [{"value": "0.85", "conditions": ["c01"]}]
    assert cases_of("claim: a, rise: scene.bed, from: empty, to: locked", "") == []


def test_labels_are_short() -> None:
    assert [label("scene.grains.diameter", v) for v in (0.001, 0.0055)] == ["1 mm", "5.5 mm"]
    assert [label("scene.grains.fill", v) for v in (0.9, 0.905)] == ["0.90", "0.905"]
    assert label("scene.bed", "empty") == "empty"
    assert label("drive.frequency", 20.0) == "20 Hz"
    assert label("scene.grains.density", 7900.0) == "7.9 g/cm^3"
    assert label("scene.layers.side_walls", True) == "True"


def test_dump_writes_margins_out() -> None:
    text = dump_protocol(
        load_protocol(f"{HEAD}expect:\n  - {{claim: a, nonlinear: drive.acceleration}}\n")
    )
    assert "margin: 0.1" in text


def test_what_else_varies_is_named_with_its_value() -> None:
    """What every condition of a report shows anyway (fill, level, bed) is left out, and so are
    whole groups.
    """
    grid = "vary: {scene.single_mass.gap: [1 mm, 2 mm], scene.grains.fill: [0.5, 0.6], scene.losses: [[], [noise, air]]}\n"
    protocol = load_protocol(
        f"schema: rig/protocol/1\nname: x\nscene: {{bed: single_mass}}\n{grid}"
    )
    found = [varied(protocol, condition) for condition in conditions(protocol)]
    assert found[0] == {"gap": "1 mm", "losses": "none"}
    assert found[-1] == {"gap": "2 mm", "losses": "noise, air"}
