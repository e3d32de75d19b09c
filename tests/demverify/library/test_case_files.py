"""case.toml: variants, what laws make of them, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from demverify.cases import find_cases, load_case, load_cases, split_variant
from demverify.errors import InputError
from demverify.library import catalogue

LAW = '[[law]]\nname = "collision_restitution"\ntolerance = 1e-3\nreason = "r"\n'
ONE = "parameters = { restitution = 1 }"
VARIANTS = "".join(f'[[variant]]\nname = "e{e}"\nvariables = {{ e = {e} }}\n' for e in (0.5, 0.8))


def case(folder: Path, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "in.lammps").write_text("")
    (folder / "case.toml").write_text(text)
    return folder


def test_a_variant_is_a_case_with_its_own_variables(tmp_path: Path) -> None:
    """Law: every variant is a case named folder:variant; its variables go to the decks as text and to the laws as numbers."""
    found = load_cases(case(tmp_path / "pair", 'title = "A pair"\n' + VARIANTS + LAW + 'parameters = { restitution = "${e}" }\n'))
    assert [one.name for one in found] == ["pair:e0.5", "pair:e0.8"]
    assert [one.variables for one in found] == [{"e": ["0.5"]}, {"e": ["0.8"]}]
    assert [one.laws[0].parameters["restitution"] for one in found] == [0.5, 0.8]
    assert [one.title for one in found] == ["A pair, e0.5", "A pair, e0.8"]


def test_a_law_can_be_for_some_variants_only(tmp_path: Path) -> None:
    """Law: `only` names the variants that a law holds for."""
    found = load_cases(case(tmp_path / "pair", VARIANTS + LAW + 'only = ["e0.8"]\nparameters = { restitution = 0.8 }\n'))
    assert [len(one.laws) for one in found] == [0, 1]


def test_an_engine_can_be_left_out_of_one_variant(tmp_path: Path) -> None:
    """Law: what a variant says of engines it cannot have comes on top of what the case says."""
    text = 'without = {{ {} = "never" }}\n' + VARIANTS.replace("{", "{{").replace("}", "}}") + 'without = {{ lammps = "not here" }}\n'
    assert [one.without for one in load_cases(case(tmp_path / "pair", text.format("liggghts")))] == [
        {"liggghts": "never"}, {"liggghts": "never", "lammps": "not here"},
    ]  # fmt: skip
    assert [one.without for one in load_cases(case(tmp_path / "pair", text.format("lammps")))] == [{"lammps": "never"}, {"lammps": "not here"}]


def test_a_folder_without_variants_is_one_case(tmp_path: Path) -> None:
    """Law: without [[variant]] a folder is one case of its own name, and load_case takes it without a word."""
    assert load_case(case(tmp_path / "pair", "")).name == "pair"
    assert load_case(case(tmp_path / "two", VARIANTS), "e0.5").name == "two:e0.5"


def test_cases_are_found_in_any_depth(tmp_path: Path) -> None:
    """Law: every case.toml below a folder is a case, and the folder itself where it has one."""
    (tmp_path / "deep").mkdir()
    folders = [case(tmp_path / "a", ""), case(tmp_path / "deep" / "b", "")]
    assert list(find_cases(tmp_path)) == folders
    assert find_cases(folders[0]) == (folders[0],)


WRONG = {
    "unknown key": ("tilte = 'x'", "key 'tilte' is not one of title, what"),
    "unknown engine": ('without = { mercury = "x" }', "without: expected lammps or liggghts = a text, got mercury = 'x'"),
    "accept is no text": ("accept = [3]", "'accept' must be a list of texts, got 3 in it"),
    "variant without a name": ("[[variant]]\nvariables = { e = 1 }", "a [[variant]] needs a name of letters, digits and _ . + -, got ''"),
    "variant with a bad name": ('[[variant]]\nname = "a b"', "a [[variant]] needs a name of letters, digits and _ . + -, got 'a b'"),
    "variant twice": ('[[variant]]\nname = "a"\n[[variant]]\nname = "a"', "variant 'a' is there twice"),
    "a variable that is a list": ('[[variant]]\nname = "a"\nvariables = { e = [1] }', "variant a: variable e must be a number or a text, got [1]"),
    "a law for nobody": (VARIANTS + LAW + 'only = ["e9"]\n' + ONE, "is only for variant 'e9', which is not one of e0.5, e0.8"),
    "no such variable": (VARIANTS + LAW + ONE.replace("1", '"${f}"'), "law parameter restitution: no variable 'f' in this variant; it has e"),
    "a parameter misspelt": (LAW + "parameters = { restitutoin = 1 }", "law collision_restitution takes restitution; got restitutoin"),
    "a parameter missing": (LAW, "law collision_restitution takes restitution; got none"),
    "no such law": (LAW.replace("collision_", "colision_"), "law 'colision_restitution' is not one of "),
    "a tolerance of nothing": (LAW.replace("1e-3", "0.0") + ONE, "must be a number above zero, got 0"),
    "no reason": (LAW.replace('reason = "r"\n', "") + ONE, "a [[law]] needs name, tolerance and reason; reason is missing"),
    "not toml": ("title = ", "not a readable case.toml"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_said_in_one_line(name: str, tmp_path: Path) -> None:
    """Law: a case.toml that is wrong is refused in one line that names the file and what was expected."""
    text, told = WRONG[name]
    with pytest.raises(InputError) as error:
        load_cases(case(tmp_path / "pair", text))
    assert told in str(error.value)
    assert "case.toml" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_variant_that_is_not_there(tmp_path: Path) -> None:
    """Law: asked for no variant where there are some, or for one that is not there, the answer lists them."""
    folder = case(tmp_path / "pair", VARIANTS)
    for variant, told in (("", "which variant?"), ("e9", "there is no variant 'e9'")):
        with pytest.raises(InputError, match=r"e0\.5, e0\.8") as error:
            load_case(folder, variant)
        assert told in str(error.value)


def test_folder_and_variant(tmp_path: Path) -> None:
    """Law: FOLDER and FOLDER:VARIANT are told apart, also below a folder with a colon in its name; a folder that is not there, or a colon with no
    variant behind it, is neither. A variant that its folder lacks is told by the library too."""
    folder = tmp_path / "a:b"
    folder.mkdir()
    assert split_variant(folder) == (folder, "")
    assert split_variant(Path(f"{folder}:e0.5")) == (folder, "e0.5")
    for wrong in (f"{folder}:", f"{tmp_path / 'gone'}:e0.5", "e0.5"):
        assert split_variant(Path(wrong)) is None
    made = case(tmp_path / "pair", VARIANTS)
    assert [one.name for one in catalogue([f"{made}:e0.8"])] == ["pair:e0.8"]
    with pytest.raises(InputError, match=r"there is no variant 'e9'; there are e0.5, e0.8"):
        catalogue([f"{made}:e9"])
