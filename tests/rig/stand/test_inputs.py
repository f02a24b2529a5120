"""Coupling, ranges and effects in a protocol, and the channels that come of them."""

import pytest

from rig.campaign.campaign import Campaign
from rig.campaign.resolve import campaign_of
from rig.catalog.entries_by_name import analyzer, transducer
from rig.catalog.rig_file import load_rig
from rig.errors import InputError
from rig.protocol.load import dump_protocol, load_protocol

PLAIN = "schema: rig/protocol/1\nname: x\n"


def made(*sets: str) -> Campaign:
    return campaign_of(load_protocol(PLAIN, sets), load_rig())


def test_without_being_asked_nothing_is_there() -> None:
    for channel, state in zip(made().instruments.channels, made().instruments.states, strict=True):
        assert (channel.coupling, channel.corner, state.corner, state.bend) == (
            "DC",
            None,
            None,
            (0.0, 0.0),
        )
        assert channel.transducer.resonance is None
        assert channel.transducer.noise_spots == ()


def test_the_sheets_extras_come_where_asked() -> None:
    force, acceleration = made(
        "acquire.effects=[linearity, resonance, flicker]"
    ).instruments.channels
    assert (force.transducer.linearity, force.transducer.resonance) == (0.01, 36e3)
    assert acceleration.transducer.resonance == 50e3
    assert acceleration.transducer.noise_spots == pytest.approx(
        [9.80665e-6 * s for s in (39, 11, 3.4, 1.4)]
    )
    assert force.transducer.noise_spots == ()  # none on its sheet


def test_one_word_for_all_channels_or_one_for_each() -> None:
    every = load_protocol(PLAIN, ["acquire.coupling=IEPE"])
    each = load_protocol(PLAIN, ["acquire.coupling={force: IEPE, acceleration: IEPE}"])
    assert every == each
    assert load_protocol(dump_protocol(every)) == every
    mixed = load_protocol(
        PLAIN, ["acquire.coupling.force=AC", "acquire.ranges={force: 1 V, acceleration: auto}"]
    )
    assert load_protocol(dump_protocol(mixed)) == mixed


def test_a_corner_is_certified_as_on_the_sheet_and_drawn() -> None:
    tools = made("acquire.coupling=AC").instruments
    assert [channel.corner for channel in tools.channels] == [0.5, 0.5]
    corners = [state.corner for state in tools.states]
    assert len(set(corners)) == 2
    assert all(corner is not None and 0.45 <= corner <= 0.55 for corner in corners)
    assert [info.corner for info in tools.table(10240.0, 0.0)] == [0.5, 0.5]
    assert [
        info.clips_at for info in made("acquire.coupling=IEPE").instruments.table(1e4, 0.0)
    ] == [5.0, 5.0]


def test_ranges_left_to_the_look_ahead() -> None:
    """5 m/s^2 on 10.2 mV/(m/s^2) is 51 mV: 0.1 V is less than twice that, and 1 V is the next;
    impacts reach 0.8 V.
    """
    channels = made("acquire.ranges=auto").instruments.channels
    assert [channel.range_V for channel in channels] == [10.0, 1.0]
    light = made(
        "acquire.ranges=auto", "scene.bed=empty", "drive.acceleration=1.5"
    ).instruments.channels
    assert [channel.range_V for channel in light] == [0.1, 0.1]  # 18 N are 40 mV; 15 mV
    given = made("acquire.ranges={force: 1 V, acceleration: 0.1 V}").instruments.channels
    assert [channel.range_V for channel in given] == [1.0, 0.1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("acquire.ranges.force=5 V", "10 V, 1 V, 0.1 V, or auto"),
        ("acquire.ranges=aut", "did you mean 'auto'?"),
        ("acquire.coupling=IEP", "did you mean 'IEPE'?"),
        ("acquire.effects=[resonanc]", "did you mean 'resonance'?"),
        ("acquire.effects=skew", "a list of"),
        (
            "acquire={coupling: IEPE, sensors: {acceleration: dc-accelerometer}}",
            "no amplifier to feed",
        ),
        ("acquire={coupling: AC}\n", ""),
    ],
)
def test_incompatible_inputs_are_reported(change: str, words: str) -> None:
    sets = (
        [change.strip()]
        if words
        else [change.strip(), "drive.frequency=0.4", "acquire.samples_per_cycle=1000"]
    )
    with pytest.raises(InputError, match=words or "below the coupling's corner") as caught:
        load_protocol(PLAIN, sets)
    assert "acquire" in str(caught.value)


def test_instruments_belong_to_the_session() -> None:
    text = PLAIN + "vary: {acquire.coupling.force: [DC, AC]}\n"
    with pytest.raises(InputError, match="one set of instruments"):
        campaign_of(load_protocol(text), load_rig())


def test_the_catalog_says_what_the_analyzer_is() -> None:
    spec = analyzer("INV-3118")
    assert (spec.channels, spec.ac_corner, spec.ac_tolerance) == (8, 0.5, 0.1)
    assert spec.skew == pytest.approx(0.05 / 360 / 1000, rel=1e-15)
    assert transducer("dc-accelerometer").clips_at is None
    assert transducer("208C03").statuses["linearity"] == "recalled"
