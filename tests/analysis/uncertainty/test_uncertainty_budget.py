"""GUM: Welch-Satterthwaite, coverage factors, the budget's lines, coverage of the stated intervals."""

import dataclasses
import math

import numpy as np
import pytest
from analytic_record import (
    FREQUENCY,
    IDEAL,
    NOMINAL,
    OMEGA,
    Bench,
    condition,
    dashpot_energy,
    drive_time,
    motion,
    prediction_for,
    session,
)
from scipy import stats

from analysis import dissipated_energy, read_session
from analysis.uncertainty.budget import (
    angle_uncertainty,
    certificate_lines,
    combine,
    mass_and_loss,
    noise_of,
    scatter_line,
)
from analysis.uncertainty.estimate import Estimate, coverage_factor, effective_dof


def test_gauge_block_of_gum_annex_h1():
    """GUM H.1: parts of 25 nm (nu 18), 9.7 nm (25.6), 2.9 nm (50) and 16.6 nm (2) make u_c = 32 nm
    with nu = 16.7.
    """
    parts = [(25.0, 18.0), (9.7, 25.6), (2.9, 50.0), (16.6, 2.0)]
    assert combine(0, parts).u == pytest.approx(32, abs=0.5)
    assert effective_dof(parts) == pytest.approx(16.7, abs=0.2)
    assert coverage_factor(16, 0.99) == pytest.approx(2.92, abs=0.005)


def test_equal_parts_add_their_degrees_of_freedom():
    assert effective_dof([(1.0, 5.0), (1.0, 5.0)]) == pytest.approx(10.0)
    assert math.isinf(effective_dof([(1.0, math.inf)]))
    assert math.isinf(effective_dof([]))


@pytest.mark.parametrize("nu", [1.0, 3.0, 7.5, 50.0])
def test_coverage_factor_is_student_s(nu):
    assert coverage_factor(nu) == pytest.approx(stats.t.ppf(0.975, nu))
    assert coverage_factor(math.inf) == pytest.approx(stats.norm.ppf(0.975))


def coverage(nu, apart, k_of):
    """Share of the intervals that hold the truth, by quadrature over the scatter of nu + 1 values
    whose mean has the standard deviation 1, beside a known uncertainty `apart`; k_of: from the two
    standard uncertainties."""
    chance = (np.arange(400) + 0.5) / 400
    found = np.sqrt(stats.chi2.ppf(chance, nu) / nu)
    U = np.array([k_of(s, apart) * math.hypot(s, apart) for s in found])
    return float(np.mean(2 * stats.norm.cdf(U / math.hypot(1, apart)) - 1))


APART = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 4.0)


@pytest.mark.parametrize(
    ("nu", "least", "most"), [(2, 0.940, 0.960), (3, 0.946, 0.958), (7, 0.949, 0.954)]
)
def test_few_repeats_beside_a_certificate_are_covered(nu, least, most):
    """Within 1 % with three repeats, 0.7 % with four, where Welch-Satterthwaite's k covers as
    little as 92 %.
    """

    def welch(s, u):
        return coverage_factor(effective_dof([(s, nu), (u, math.inf)]))

    def ours(s, u):
        return Estimate.of(0.0, [(s, nu), (u, math.inf)]).k

    found = [coverage(nu, u, ours) for u in APART]
    assert least <= min(found)
    assert max(found) <= most
    assert min(coverage(nu, u, welch) for u in APART) < min(found)


@pytest.mark.parametrize("nus", [(1.0, 60.0), (2.0, math.inf), (3.0, 50.0)])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_k_of_two_groups_is_the_quantile_of_their_posterior(nus, share):
    """Against draws from the posterior as it is written: prior (s1 s2)^-2.4 (s1^2 + s2^2)^0.7, so
    that nu s^2/chi^2 with nu + 1.4 degrees of freedom are drawn and weighted with their sum's
    power. 5 standard errors of 4e5 draws."""
    rng, n = np.random.default_rng(5), 400_000
    estimate = Estimate.of(
        1.0, [(math.sqrt(u), nu) for u, nu in zip((share, 1 - share), nus, strict=True)]
    )
    total = sum(
        u * (np.ones(n) if math.isinf(nu) else nu / rng.chisquare(nu + 1.4, n))
        for u, nu in zip((share, 1 - share), nus, strict=True)
    )
    weight = total**0.7
    for level in (0.9, 0.95):
        inside = 2 * stats.norm.cdf(estimate.factor(level) / np.sqrt(total)) - 1
        got = float(np.average(inside, weights=weight))
        error = float(np.sqrt(np.mean((weight * (inside - got)) ** 2) / n)) / float(weight.mean())
        assert got == pytest.approx(level, abs=5 * error + 1e-4)  # 1e-4: the quadrature
    outside = 1 - np.average(2 * stats.norm.cdf(1 / np.sqrt(total)) - 1, weights=weight)
    assert estimate.p() == pytest.approx(outside, abs=5e-3)


def test_a_group_alone_has_student_s_k():
    """One group, and in the limit of a share that vanishes beside the other."""
    assert Estimate.of(0.0, [(1.0, 3.0), (1.0, 3.0)]).k == pytest.approx(stats.t.ppf(0.975, 6))
    assert Estimate.of(0.0, [(1.0, 3.0), (1e-6, math.inf)]).k == pytest.approx(
        stats.t.ppf(0.975, 3), rel=1e-4
    )
    assert Estimate.of(0.0, [(1e-6, 3.0), (1.0, 50.0)]).k == pytest.approx(
        stats.t.ppf(0.975, 50), rel=1e-4
    )
    assert Estimate.of(0.0, []).p() == 1.0
    assert Estimate(3.0, 1.5, 4.0).p() == pytest.approx(2 * stats.t.sf(2, 4))


@pytest.mark.parametrize("nu", range(1, 12))
@pytest.mark.parametrize("certified", [0.5, 1.0, 2.0, 3.0])
def test_p_of_zero_is_one_and_never_more(nu, certified):
    """At 0 all the mixture lies outside: p is the sum of its weights, 1 but for round-off of some
    hundred terms, which may not lead beyond 1."""
    p = Estimate.of(0.0, [(1.0, nu), (certified, 50.0)]).p()
    assert p <= 1.0
    assert p == pytest.approx(1.0, abs=1e-13)


def test_an_estimate_without_uncertainty_has_none_expanded():
    assert Estimate(1.0, 0.0, math.inf).U == 0.0
    assert pytest.approx(6.36, abs=0.01) == Estimate(1.0, 2.0, 3.0).U


def test_scatter_is_the_standard_deviation_of_the_mean():
    values = [1.0, 2.0, 4.0, 5.0]
    (line,) = scatter_line(values)
    assert line.part == pytest.approx(np.std(values, ddof=1) / 2)
    assert line.nu == 3
    assert scatter_line([1.0]) == ()


def test_certificate_lines_are_the_derivatives_of_the_energy():
    """Each line's c against a finite change of that instrument error, through the whole analysis of
    a signal.
    """
    a0, mass, c = 5.0, 38.0, 400.0
    t = drive_time(8 * 512, delay=0)
    a, v = motion(t, a0)
    force = mass * a + c * v
    tau = {name: NOMINAL[name].time_constant for name in NOMINAL}
    lead = {name: math.atan(1 / (OMEGA * tau[name])) for name in tau}

    def energy(f_scale=1.0, a_scale=1.0, f_log=0.0, a_log=0.0):
        """Energy read with certified poles while the actual ones are tau exp(log)."""
        turned = []
        for name, log in (("force", f_log), ("acceleration", a_log)):
            actual = math.atan(1 / (OMEGA * tau[name] * math.exp(log)))
            shift = t + actual / OMEGA
            moved_a, moved_v = motion(shift, a0)
            turned.append(mass * moved_a + c * moved_v if name == "force" else moved_a)
        return dissipated_energy(
            f_scale * turned[0], a_scale * turned[1], 10240.0, FREQUENCY,
            time_constants=(tau["force"], tau["acceleration"]),
        )  # fmt: skip

    assert force.shape == a.shape
    assert lead["acceleration"] > lead["force"]
    base = energy()
    lines = {
        line.source: line
        for line in certificate_lines(
            NOMINAL["force"], NOMINAL["acceleration"], FREQUENCY, base.W, base.reactive
        )
    }
    h = 1e-3
    found = {
        "force sensitivity": energy(f_scale=1 + h),
        "acceleration sensitivity": energy(a_scale=1 + h),
        "force pole (ln tau)": energy(f_log=h),
        "acceleration pole (ln tau)": energy(a_log=h),
    }
    M, eta = base.M_eff, base.eta
    for source, moved in found.items():
        line = lines[source]
        # Second-order terms: h; the pole's change of amplitude, left out of the line: tan(phase) of
        # it.
        assert line.c == pytest.approx((moved.W - base.W) / h, rel=3e-2, abs=1e-3 * abs(base.W))
        of_mass, of_loss = (line.ratio - line.turn * eta) * M, line.turn * (1 + eta**2)
        assert of_mass == pytest.approx((moved.M_eff - M) / h, rel=3e-2, abs=1e-3 * M)
        assert of_loss == pytest.approx((moved.eta - eta) / h, rel=3e-2, abs=1e-3 * eta)
    assert lines["acceleration gain"].u == pytest.approx(0.003 / math.sqrt(3))


def test_mass_and_loss_scatter_as_their_noise_says():
    """300 records with white noise: the standard deviations are known to 1/sqrt(600) = 4 %, three
    of them allowed.
    """
    rng, noise, n, a0, mass, c = np.random.default_rng(5), (2.0, 0.02), 8 * 512, 5.0, 38.0, 4000.0
    a, v = motion(drive_time(n, delay=0), a0)
    signals = [
        (mass * a + c * v + noise[0] * f, a + noise[1] * g)
        for f, g in rng.standard_normal((300, 2, n))
    ]
    found = [dissipated_energy(force, own, 10240.0, FREQUENCY) for force, own in signals]
    facts = [
        dataclasses.replace(IDEAL[name], noise_rms=rms)
        for name, rms in zip(("force", "acceleration"), noise, strict=True)
    ]
    M, eta = mass_and_loss(found[:1], (), noise_of(found[0], *facts, n))
    assert np.std([one.M_eff for one in found]) == pytest.approx(M.u, rel=0.12)
    assert np.std([one.eta for one in found]) == pytest.approx(eta.u, rel=0.12)
    many = mass_and_loss(found, (), 0.0)
    assert many[0].u == pytest.approx(np.std([one.M_eff for one in found], ddof=1) / math.sqrt(300))


def test_ideal_instruments_have_no_lines_and_a_resolution_only():
    assert certificate_lines(IDEAL["force"], IDEAL["acceleration"], 20.0, 1.0, 1.0) == ()
    assert (
        pytest.approx(1e-5, rel=0.03)
        == angle_uncertainty(IDEAL["force"], IDEAL["acceleration"], 20.0).U
    )


def test_noise_of_the_energy_is_what_noise_does_to_it():
    """Standard deviation over 400 noisy copies against the formula: its own relative error is
    1/sqrt(800) = 3.5 %.
    """
    rng = np.random.default_rng(3)
    t = drive_time(10 * 512, delay=0)
    a, v = motion(t, 5.0)
    force = 38 * a + 400 * v
    W = [
        dissipated_energy(
            force + 0.02 * rng.standard_normal(t.size),
            a + 5e-4 * rng.standard_normal(t.size),
            10240.0,
            20.0,
        ).W_phasor
        for _ in range(400)
    ]
    expected = noise_of(
        dissipated_energy(force, a, 10240.0, 20.0),
        NOMINAL["force"],
        NOMINAL["acceleration"],
        t.size,
    )
    assert np.std(W) == pytest.approx(expected, rel=4 * 0.035)


@pytest.mark.parametrize("count", [80, pytest.param(400, marks=pytest.mark.slow)])
def test_stated_intervals_cover(count):
    """Sessions with instruments drawn from their certificates and beds that scatter: W_exp +- U and
    ratio +- U_ratio hold the truth in 95 % of them, within the 99.9 % binomial band (of 80: .86 to
    1; of 400: .91 to .98)."""
    rng = np.random.default_rng(11)
    table = [
        condition(f"c{i}", acceleration_set=a, record_cycles=4) for i, a in enumerate((2.0, 4.0))
    ]
    mean_c, spread = 200.0, 0.02
    prediction = prediction_for(table, lambda _entry, a: dashpot_energy(mean_c, a))
    hit = {"W_exp": 0, "ratio": 0}
    for _ in range(count):
        z = rng.standard_normal(3)
        flat = rng.uniform(-1, 1, 2) * 0.003
        gains = (1 + 0.005 * z[0]) * (1 + flat[0]), (1 + 0.005 * z[1]) * (1 + flat[1])
        turn = math.atan(1 / (OMEGA * 1.6 * math.exp(0.1 * z[2]))) - math.atan(1 / (OMEGA * 1.6))
        scatter = iter(rng.normal(1.0, spread, 8))
        bench = Bench(
            channels=dict(NOMINAL), gains=gains, turn=turn, noise=(0.02, 5e-4), samples=16 * 512
        )
        report = read_session(
            session(
                table, lambda *_, c=scatter: mean_c * next(c), bench, rng, prediction=prediction
            )
        )
        row = report.conditions[1]
        hit["W_exp"] += abs(row.W_exp - dashpot_energy(mean_c, 4.0)) <= row.U_W_exp
        hit["ratio"] += abs(report.agreement.ratio - 1) <= report.agreement.U_ratio
    low, high = stats.binom.ppf([0.0005, 0.9995], count, 0.95)
    assert low <= hit["W_exp"] <= high
    assert low <= hit["ratio"] <= high


def test_what_a_prediction_is_uncertain_by_stands_in_its_budget():
    """Reading between levels is wrong in each condition anew and adds in quadrature over
    conditions; numerics and settling are alike in all and add up: on the ratio of n equal
    conditions u/sqrt(n) and u."""
    table = [
        condition(f"c{i}", acceleration_set=3.0, settle_cycles=2, record_cycles=8) for i in range(4)
    ]
    found = {}
    for name in ("u_rel", "u_levels", "u_settling"):
        prediction = prediction_for(table, lambda _entry, a: dashpot_energy(300.0, a))
        for entry in prediction["conditions"].values():
            entry[name] = 0.02
        bench = Bench(channels=dict(IDEAL), samples=11 * 512)
        record = session(
            table,
            lambda _entry, _repeat: 300.0,
            bench,
            np.random.default_rng(1),
            prediction=prediction,
        )
        found[name] = read_session(record)
    sources = {name: report.conditions[0].uncertainty_W_T for name, report in found.items()}
    assert {
        name: [line.source for line in lines if line.u == 0.02] for name, lines in sources.items()
    } == {
        "u_rel": ["prediction numerics"],
        "u_levels": ["prediction between levels"],
        "u_settling": ["settling of the bed"],
    }
    for report in found.values():
        row = report.conditions[0]
        assert pytest.approx(1.96 * 0.02, rel=1e-2) == row.U_W_T / row.W_T
        assert sum(line.share for line in row.uncertainty_W_T) == pytest.approx(1.0)
    ratios = {
        name: report.agreement.U_ratio / report.agreement.ratio for name, report in found.items()
    }
    assert ratios["u_levels"] == pytest.approx(1.96 * 0.02 / 2, rel=1e-2)
    assert (
        ratios["u_rel"]
        == pytest.approx(ratios["u_settling"])
        == pytest.approx(1.96 * 0.02, rel=1e-2)
    )
