"""Members: their mean, their spread, and how sure either is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modules.api import Accuracy, Identity, Samples, Source, Spread, Term, deviation
from modules.modellers.calculator import calculator
from modules.modellers.ensemble import ensemble

RANDOM = np.random.default_rng(2)
TRUE = np.linspace(0, 5, 30).reshape(5, 6)
MEMBERS = TRUE + 0.3 * RANDOM.standard_normal((12, 5, 6))


def field(values: object, *terms: Term, unit: str = "m") -> Samples:
    return Samples.from_array(np.asarray(values, float), unit=unit, name="h", accuracy=Accuracy(terms))


FIELDS = [field(v) for v in MEMBERS]


def test_mean_and_spread_are_numpys_and_the_members_go_on() -> None:
    made = ensemble(FIELDS)
    assert np.allclose(made.values, MEMBERS.mean(axis=0))
    (term,) = made.accuracy.terms
    assert term.kind == "members"
    assert term.error() == pytest.approx(MEMBERS.std(axis=0, ddof=1).ravel())
    assert np.allclose(ensemble(FIELDS, show="spread").values, MEMBERS.std(axis=0, ddof=1))
    assert np.allclose(ensemble(FIELDS, show="median").values, np.median(MEMBERS, axis=0))
    assert np.allclose(ensemble(FIELDS, show="largest").values, MEMBERS.max(axis=0))
    assert np.allclose(ensemble(FIELDS, show="share above", level=2.0).values, (MEMBERS > 2).mean(axis=0))


def test_of_repeated_measurements_the_mean_covers_the_truth_as_stated() -> None:
    """Over many ensembles two standard errors of 12 members cover what Student's law says of 11 degrees of freedom."""
    random, inside = np.random.default_rng(7), []
    for _ in range(60):
        members = [field(TRUE + 0.3 * random.standard_normal(TRUE.shape)) for _ in range(12)]
        made = ensemble(members, members_are="repeated measurements")
        inside.append(np.abs(made.values - TRUE).ravel() <= 2 * made.accuracy.terms[0].error())
    assert np.mean(inside) == pytest.approx(0.929, abs=0.02)


def test_the_jackknife_is_the_error_of_a_spread() -> None:
    random, spreads, said = np.random.default_rng(8), [], []
    for _ in range(80):
        made = ensemble([field(TRUE + 0.3 * random.standard_normal(TRUE.shape)) for _ in range(12)], show="spread")
        spreads.append(made.values)
        said.append(made.accuracy.terms[0].error())
    assert np.sqrt(np.mean(np.square(said))) == pytest.approx(np.std(spreads, axis=0).mean(), rel=0.15)


def test_what_members_know_of_themselves_averages_out_unless_it_is_common() -> None:
    source = Source("offset", "data", "estimated", "made up")
    offset = Term(source, "linear", "value", "m", np.asarray(0.2), Spread(30), id="offset")
    made = ensemble([field(v, offset, deviation("noise", 0.4, 30, unit="m", id=f"n{i}")) for i, v in enumerate(MEMBERS[:4])])
    by = {t.id: t.size() for t in made.accuracy.terms}
    assert by["offset"] == pytest.approx(np.full(30, 0.2))
    assert np.sqrt(sum(by[f"n{i}"] ** 2 for i in range(4))) == pytest.approx(np.full(30, 0.2))


def test_members_that_one_field_carries_are_an_ensemble() -> None:
    mean = MEMBERS.mean(axis=0)
    off = (MEMBERS - mean).reshape(12, 30)
    carried = field(mean, Term(Source("m", "data", "sampled", "read"), "members", "value", "m", off, Identity(30), id="m"))
    assert np.allclose(ensemble([carried], show="spread").values, MEMBERS.std(axis=0, ddof=1))
    squared = calculator(carried, formula="a**2")
    assert np.allclose(ensemble([squared]).values, (MEMBERS**2).mean(axis=0))
    assert "m" in ensemble([carried]).accuracy.ended


def test_units_are_brought_together_and_few_members_flagged() -> None:
    made = ensemble([field([1.0, 2.0]), field([0.003, 0.004], unit="km")])
    assert np.allclose(made.values, [2, 3])
    assert any(f.name == "few members" for f in made.accuracy.flags)
    assert made.accuracy.missing


def test_what_is_no_ensemble_is_refused() -> None:
    with pytest.raises(ValueError, match="carries no members"):
        ensemble([FIELDS[0]])
    with pytest.raises(ValueError, match="nothing is wired"):
        ensemble([])
    with pytest.raises(ValueError, match="member 2 lies on another grid"):
        ensemble([FIELDS[0], field([1.0, 2.0])])
    with pytest.raises(ValueError, match="measure different things"):
        ensemble([FIELDS[0], replace(FIELDS[1], unit="s")])
