"""Of an effect's forms the one with the fewest numbers stands, unless another has strong evidence over it."""

from types import SimpleNamespace

from fsm_calib.diagnosis.candidates.ranked import STRONG, simplest


def form(evidence, size):
    return SimpleNamespace(evidence=evidence, fit=SimpleNamespace(size=size))


def test_a_form_of_fewer_numbers_stands_where_another_has_hardly_more_evidence():
    plain, rich = form(100.0, 7), form(100.0 + 0.5 * STRONG, 10)
    assert simplest([rich, plain]) is plain


def test_a_form_with_strong_evidence_over_all_others_stands():
    plain, rich = form(100.0, 7), form(101.0 + STRONG, 10)
    assert simplest([plain, rich]) is rich


def test_of_forms_with_as_many_numbers_the_one_with_more_evidence_stands():
    one, other = form(100.0, 7), form(101.0, 7)
    assert simplest([one, other]) is other
