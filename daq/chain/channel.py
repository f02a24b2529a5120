"""An instrument channel: data sheet, certified state, actual state, and its row in the record's
channel table.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

__all__ = [
    "COUPLINGS",
    "SPOTS",
    "AnalyzerSpec",
    "Channel",
    "ChannelInfo",
    "ChannelState",
    "NoSuchRate",
    "Quantity",
    "TransducerSpec",
    "certified_state",
    "channel_info",
    "draw_clock_error",
    "draw_state",
    "ideal_analyzer",
    "ideal_transducer",
]  # fmt: skip

Quantity = Literal["force", "acceleration", "voltage", "current"]

REFERENCE_RANGE = 10.0  # V, at which AnalyzerSpec.noise_rms is stated
REFERENCE_RATE = 51200.0  # Hz, at which AnalyzerSpec.noise_rms is stated
COUPLINGS = ("DC", "AC", "IEPE")
SPOTS = (1.0, 10.0, 100.0, 1000.0)  # Hz, at which a sheet states its noise density
# Hz, hardware.md: 102.4 kS/s and 51.2 kS/s / n
LISTED_RATES = (102400.0, *(51200.0 / n for n in range(1, 32)))


class NoSuchRate(ValueError):
    """No listed rate of the analyzer gives the requested number of samples per cycle."""


@dataclass(frozen=True)
class TransducerSpec:
    """Data sheet of a transducer, as the catalog states it.

    sensitivity: V per unit. full_scale: unit. time_constant: discharge time constant in s
    (high-pass pole at 1 / (2 pi time_constant) Hz), None for a response down to DC.
    time_constant_spread: relative, sigma of a lognormal. noise_rms: unit, white over
    0..noise_bandwidth (Hz). calibration_U: relative expanded uncertainty (k = 2) of the
    sensitivity. statuses: field name -> sourced, recalled, computed or assumed.

    Optional: linearity, largest deviation from the straight line, as a fraction of full scale;
    resonance, Hz, with its damping ratio; noise_spots, noise densities in unit/sqrt(Hz) at `SPOTS`,
    with which noise rises towards low frequencies (1/f) and the last of which is the white floor;
    clips_at, V at which an IEPE sensor's own amplifier clips, None for other sensors.
    """

    model: str
    quantity: Quantity
    unit: str
    sensitivity: float
    full_scale: float
    time_constant: float | None
    time_constant_spread: float
    noise_rms: float
    noise_bandwidth: float
    calibration_U: float
    statuses: Mapping[str, str] = field(default_factory=dict, hash=False)
    linearity: float | None = None
    resonance: float | None = None
    resonance_damping: float = 0.0
    noise_spots: tuple[float, ...] = ()
    clips_at: float | None = None

    def noise_in_band(self, rate: float) -> float:
        """Return the rms white noise (unit) in 0..rate/2, the band of a record at `rate` (Hz)."""
        band = min(rate / 2, self.noise_bandwidth)
        if self.noise_spots:
            return self.noise_spots[-1] * math.sqrt(band)
        return self.noise_rms * math.sqrt(band / self.noise_bandwidth)

    @property
    def flicker(self) -> float:
        """1/f noise: density K (unit/sqrt(Hz)) at 1 Hz such that K^2/f plus the white floor covers
        every spot; 0 without spots.
        """
        excess = (
            f * max(s**2 - self.noise_spots[-1] ** 2, 0.0)
            for f, s in zip(SPOTS, self.noise_spots, strict=False)
        )
        return math.sqrt(max(excess, default=0.0))


@dataclass(frozen=True)
class AnalyzerSpec:
    """Data sheet of an analyzer.

    rates: listed output rates in Hz. oversampling: input intervals per output sample. bits: of the
    converter. ranges: V, each meaning +- that value. noise_rms: V rms in the output band at the 10
    V range and 51.2 kS/s. gain_tolerance: relative half-width of a rectangular distribution, per
    channel. clock_ppm: half-width of the rectangular distribution of the common clock's error, in
    1e-6. channels: number sampled simultaneously. ac_corner: Hz, high-pass of the couplings AC and
    IEPE; ac_tolerance: relative half-width of its scatter between channels. skew: s, half-width of
    the delay between channels (rectangular).
    """

    model: str
    rates: tuple[float, ...]
    oversampling: int = 8
    bits: int = 24
    ranges: tuple[float, ...] = (10.0, 1.0, 0.1)
    noise_rms: float = 50e-6
    gain_tolerance: float = 0.003
    clock_ppm: float = 50.0
    statuses: Mapping[str, str] = field(default_factory=dict, hash=False)
    channels: int = 8
    ac_corner: float = 0.5
    ac_tolerance: float = 0.1
    skew: float = 0.0

    def rate_for(self, frequency: float, samples_per_cycle: float) -> float:
        """Return the slowest listed rate (Hz) with at least `samples_per_cycle` at `frequency`
        (Hz). Raises NoSuchRate.
        """
        wanted = frequency * samples_per_cycle
        # 1e-12: round-off of the product
        enough = [rate for rate in self.rates if rate >= wanted * (1 - 1e-12)]
        if not enough:
            best = max(self.rates) / frequency
            raise NoSuchRate(
                f"no rate of {self.model} gives {samples_per_cycle:g} samples per cycle at {frequency:g} Hz; "
                f"the fastest, {max(self.rates):g} S/s, gives {best:.4g}"
            )
        return min(enough)

    def noise_in_band(self, range_V: float, rate: float) -> float:
        """Return the rms input noise in V at a range (V) and output rate (Hz): proportional to
        range and to sqrt(rate).
        """
        return self.noise_rms * range_V / REFERENCE_RANGE * math.sqrt(rate / REFERENCE_RATE)

    def volts_per_code(self, range_V: float) -> float:
        """Return the weight of one code in V: range / 2^(bits - 1)."""
        return math.ldexp(range_V, 1 - self.bits)


def ideal_transducer(quantity: Quantity) -> TransducerSpec:
    """Return a transducer without pole, noise or calibration error.

    Its sensitivities are 2 mV/N and 10 mV/(m/s^2), so that the usual ranges of 10 V and 1 V read 5
    kN and 100 m/s^2 at full scale; 0.1 V per V and per A, 100 V and 100 A at 10 V.
    """
    unit, sensitivity, full_scale = {
        "force": ("N", 2e-3, 5000.0),
        "acceleration": ("m/s^2", 1e-2, 100.0),
        "voltage": ("V", 0.1, 100.0),
        "current": ("A", 0.1, 100.0),
    }[quantity]
    return TransducerSpec(
        "ideal", quantity, unit, sensitivity, full_scale, None, 0.0, 0.0, 1e4, 0.0
    )


def ideal_analyzer() -> AnalyzerSpec:
    """Return an analyzer without noise, gain or clock error, or scatter of its AC corners.

    It still filters, samples and rounds to 24 bit codes.
    """
    return AnalyzerSpec(
        "ideal", LISTED_RATES, noise_rms=0.0, gain_tolerance=0.0, clock_ppm=0.0, ac_tolerance=0.0
    )


@dataclass(frozen=True)
class Channel:
    """The certified state of a channel: everything the laboratory knows, and the session file
    states.

    range_V: +- that value in V. corner: Hz, of the coupling's high-pass; None for coupling DC.
    skew: s by which the channel is sampled late.
    """

    name: str
    transducer: TransducerSpec
    range_V: float
    serial: str
    direction: str
    calibration_date: str = ""
    coupling: str = "DC"
    corner: float | None = None
    skew: float = 0.0


@dataclass(frozen=True)
class ChannelState:
    """The actual state of a channel.

    sensitivity: V per unit; time_constant: s, None for DC; gain: of the analyzer; corner: Hz, of
    the coupling, None for DC; skew: s by which it is sampled late; bend: quadratic and cubic
    coefficients of the response over full scale X, b2 and b3 in x (1 + b2 x/X + b3 (x/X)^2).
    """

    sensitivity: float
    time_constant: float | None
    gain: float
    corner: float | None = None
    skew: float = 0.0
    bend: tuple[float, float] = (0.0, 0.0)


def certified_state(channel: Channel) -> ChannelState:
    """Return the state of an instrument that agrees exactly with its certificate."""
    spec = channel.transducer
    return ChannelState(spec.sensitivity, spec.time_constant, 1.0, channel.corner, channel.skew)


def draw_state(channel: Channel, analyzer: AnalyzerSpec, rng: np.random.Generator) -> ChannelState:
    """Draw a channel's actual state from its certificate.

    Sensitivity: normal, standard uncertainty calibration_U / 2. Time constant: lognormal about the
    certified value. Gain, AC corner, skew: rectangular, within the analyzer's tolerances. Bend: b2
    and b3 rectangular, each within half the linearity.
    """
    spec = channel.transducer
    # Always the same draws in the same order, whether used or not: dropping one error changes no
    # other.
    z_sensitivity, z_pole = rng.standard_normal(2)
    u_gain = rng.uniform(-1.0, 1.0)
    u_corner, u_skew, u_even, u_odd = rng.uniform(-1.0, 1.0, 4).tolist()
    pole, corner, half = spec.time_constant, channel.corner, (spec.linearity or 0.0) / 2
    return ChannelState(
        sensitivity=spec.sensitivity * (1 + spec.calibration_U / 2 * float(z_sensitivity)),
        time_constant=None
        if pole is None
        else pole * math.exp(spec.time_constant_spread * float(z_pole)),
        gain=1 + analyzer.gain_tolerance * float(u_gain),
        corner=None if corner is None else corner * (1 + analyzer.ac_tolerance * u_corner),
        skew=channel.skew + analyzer.skew * u_skew,
        bend=(half * u_even, half * u_odd),
    )


def draw_clock_error(analyzer: AnalyzerSpec, rng: np.random.Generator) -> float:
    """Draw the relative error e of the analyzer's common clock: rectangular, +- clock_ppm.

    Actual rate = rate (1 + e).
    """
    return analyzer.clock_ppm * 1e-6 * float(rng.uniform(-1.0, 1.0))


@dataclass(frozen=True)
class ChannelInfo:
    """A row of the channel table in the session file: everything the analysis may know about a
    channel.

    Engineering value = (code * scale + offset) / sensitivity, in `unit`. scale, offset: V.
    sensitivity: V per unit (certified). time_constant: s, None for DC. filter_delay: samples; drive
    time of sample n = (n - filter_delay) / rate + skew. skew: s. calibration_U: relative, k = 2.
    gain_tolerance, time_constant_spread: relative (rectangular half-width, lognormal sigma).
    clock_ppm: rectangular half-width, 1e-6. noise_rms: unit, in the band of the record. corner: Hz,
    high-pass of the coupling, 0 for DC; corner_tolerance: relative; skew_tolerance: s (rectangular
    half-widths). flicker: unit/sqrt(Hz) at 1 Hz of the noise's 1/f part. full_scale: unit, 0 where
    not stated. linearity: fraction of full scale, 0 where not stated. clips_at: V at which the
    sensor clips, 0 where it does not.
    """

    name: str
    quantity: str
    unit: str
    model: str
    serial: str
    direction: str
    coupling: str
    range_V: float
    scale: float
    offset: float
    sensitivity: float
    time_constant: float | None
    time_constant_spread: float
    filter_delay: float
    skew: float
    calibration_date: str
    calibration_U: float
    gain_tolerance: float
    clock_ppm: float
    noise_rms: float
    corner: float = 0.0
    corner_tolerance: float = 0.0
    skew_tolerance: float = 0.0
    flicker: float = 0.0
    full_scale: float = 0.0
    linearity: float = 0.0
    clips_at: float = 0.0

    @property
    def time_constants(self) -> tuple[float, ...]:
        """Certified time constants (s) of all high-pass poles: the transducer's discharge, then the
        coupling.
        """
        discharge = () if self.time_constant is None else (self.time_constant,)
        return (*discharge, 1 / (2 * math.pi * self.corner)) if self.corner else discharge

    @property
    def pole_Hz(self) -> float:
        """Corner (Hz) of the transducer's certified high-pass pole; 0 for a response down to DC."""
        return 0.0 if self.time_constant is None else 1 / (2 * math.pi * self.time_constant)


def channel_info(
    channel: Channel, analyzer: AnalyzerSpec, rate: float, filter_delay: float
) -> ChannelInfo:
    """Return the channel table row of a channel read by an analyzer at `rate` (Hz), from certified
    values only.
    """
    spec = channel.transducer
    sensor, converter = (
        spec.noise_in_band(rate),
        analyzer.noise_in_band(channel.range_V, rate) / spec.sensitivity,
    )
    return ChannelInfo(
        name=channel.name,
        quantity=spec.quantity,
        unit=spec.unit,
        model=spec.model,
        serial=channel.serial,
        direction=channel.direction,
        coupling=channel.coupling,
        range_V=channel.range_V,
        scale=analyzer.volts_per_code(channel.range_V),
        offset=0.0,
        sensitivity=spec.sensitivity,
        time_constant=spec.time_constant,
        time_constant_spread=spec.time_constant_spread,
        filter_delay=filter_delay,
        skew=channel.skew,
        calibration_date=channel.calibration_date,
        calibration_U=spec.calibration_U,
        gain_tolerance=analyzer.gain_tolerance,
        clock_ppm=analyzer.clock_ppm,
        noise_rms=math.hypot(sensor, converter),
        corner=channel.corner or 0.0,
        corner_tolerance=0.0 if channel.corner is None else analyzer.ac_tolerance,
        skew_tolerance=analyzer.skew,
        flicker=spec.flicker,
        full_scale=spec.full_scale,
        linearity=spec.linearity or 0.0,
        clips_at=(spec.clips_at or 0.0) if channel.coupling == "IEPE" else 0.0,
    )
