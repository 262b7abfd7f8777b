"""A batch as the site serves it: answers shown again, broken folders refused in one line."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from dataset_tools.site.served_batch import SiteBatch
from ncmodel.errors import InputError


@pytest.mark.parametrize("quote", ['"', ""])
def test_batches_with_and_without_quotes_show_answers_again(batch: Path, tmp_path: Path, quote: str) -> None:
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    text = (copy / "template.html").read_text()
    (copy / "template.html").write_text(re.sub(r"name=(q\d+) ", rf"name={quote}\1{quote} ", text))
    served = SiteBatch(copy)
    assert served.fragment(served.identifiers[0], {"q02": "none"}).count(" checked") == 1


def test_a_picture_that_leads_out_of_the_batch_is_refused(batch: Path, tmp_path: Path) -> None:
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    picture = sorted((copy / "images").iterdir())[0]
    picture.unlink()
    picture.symlink_to(copy / "key.json")
    with pytest.raises(InputError, match=f"{picture.name}: a link to .*key.json; expected"):
        SiteBatch(copy)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("tasks.csv", lambda text: text.replace("questionnaire", "x", 1), "row 2: .* expected a header with questionn"),
        ("tasks.csv", lambda text: text + "only,two\n", "row 6: 2 cells"),
        ("tasks.csv", lambda text: text + text.splitlines()[-1] + "\n", "row 6: "),
        ("tasks.csv", lambda text: "", "no questionnaire"),
        ("template.html", lambda text: text + "\udcff", "template.html: not UTF-8"),
        ("template.html", lambda text: text + "${q99_d1}", "placeholder 'q99_d1'"),
        ("key.json", lambda text: text.replace('"options"', '"opt"', 1).replace('"field"', '"f"'), "not the key of a"),
        ("key.json", lambda text: text.replace('"options": {', '"options": [], "x": {', 1), "not the key of a batch"),
    ],
)
def test_a_broken_batch_is_one_line(
    batch: Path, tmp_path: Path, name: str, change: Callable[[str], str], message: str
) -> None:
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    text = change((copy / name).read_text())
    (copy / name).write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=message) as found:
        SiteBatch(copy)
    assert "\n" not in str(found.value)
