"""Batches hold what was asked for, and nothing in them tells a sentinel or a drawing's settings."""

import csv
import json
import re
import stat
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import MAX_TEMPLATE, Look
from dataset_tools.questionnaires.pages import asset, batch_template, render
from dataset_tools.questionnaires.questionnaire import NONE, Key, Scheme
from dataset_tools.questionnaires.sentinels import ArtistsFolder, Drawing, SentinelPool
from dataset_tools.questionnaires.stimuli import pad_png
from dataset_tools.simulation.crowd import SimulatedArtists
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError, UsageError
from ncmodel.images import from_ink, png_bytes
from tests.helpers.crowd_data import make_artists, make_data, scribble

SCHEME = Scheme(real=10, sentinels=3, pool=6)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_data(tmp_path_factory.mktemp("crowd") / "data")


@pytest.fixture(scope="module")
def artists(data: Path) -> Path:
    return make_artists(data.parent / "artists", data, each=3)


@pytest.fixture(scope="module")
def batch(data: Path, artists: Path) -> Path:
    folder = data.parent / "batch"
    make_batch(data, folder, dict.fromkeys(DataFolder(data).items(), 3), SCHEME, Look(64, 48), ArtistsFolder(artists))
    return folder


def rows(batch: Path) -> list[dict[str, str]]:
    with (batch / "tasks.csv").open(newline="") as file:
        found = list(csv.DictReader(file))
    assert len(found) > 1
    return found


def test_the_scheme_is_kept(batch: Path, data: Path) -> None:
    key = Key.load(batch)
    asked = Counter(item for questionnaire in key.questionnaires.values() for item in questionnaire.items)
    assert set(asked) == set(DataFolder(data).items())
    assert min(asked.values()) == 3
    assert len(key.questionnaires) == -(-24 * 3 // 10)
    for questionnaire in key.questionnaires.values():
        assert [question.field for question in questionnaire.questions] == [f"q{i:02d}" for i in range(1, 14)]
        assert sum(question.sentinel for question in questionnaire.questions) == 3
        for question in questionnaire.questions:
            assert sorted(question.options.values()) == list(range(8))


def test_the_paper_scheme_is_the_default() -> None:
    assert Scheme() == Scheme(real=30, sentinels=5, pool=15, votes=3)


def test_tasks_and_template_fit_together(batch: Path) -> None:
    template = (batch / "template.html").read_text()
    placeholders = set(re.findall(r"\$\{([^}]*)\}", template))
    for row in rows(batch):
        assert placeholders == set(row)
        assert all(row.values())
        pictures = [cell for name, cell in row.items() if re.fullmatch(r"q\d+_[dr]\d+", name)]
        assert len(pictures) == 13 * 11
        assert len(set(pictures)) == len(pictures)
        assert all((batch / cell).is_file() for cell in pictures)


def test_the_template_is_a_fragment_that_mturk_takes(batch: Path) -> None:
    template = (batch / "template.html").read_text().lower()
    for forbidden in ("<form", "<html", "<body", "<!doctype", 'src="http', "src='http", "<link", "@import", "url(http"):
        assert forbidden not in template
    assert "<input type=radio name=q01" in template
    assert 'type="submit"' in template


def test_the_paper_scheme_stays_below_turkles_limit_with_a_margin() -> None:
    assert len(batch_template(35, 3, (512, 512), (384, 384)).encode()) <= MAX_TEMPLATE - 2048


def test_a_template_above_turkles_limit_is_noted(data: Path, artists: Path, tmp_path: Path) -> None:
    needs, look = dict.fromkeys(DataFolder(data).items(), 3), Look(16, 16)
    built = make_batch(
        data, tmp_path / "b", needs, Scheme(real=24, sentinels=12, pool=15), look, ArtistsFolder(artists)
    )
    assert f"Turkle takes {MAX_TEMPLATE}" not in "".join(built.notes)
    built = make_batch(
        data, tmp_path / "c", needs, Scheme(real=24, sentinels=15, pool=15), look, ArtistsFolder(artists)
    )
    assert f"Turkle takes {MAX_TEMPLATE}" in "".join(built.notes)


def test_scripts_and_styles_lose_comments_and_indentation_only() -> None:
    """The rule drops lines; no comment that it takes for one stands inside a string or goes over several lines."""
    for name in ("questionnaire.js", "questionnaire.css", "site.js", "site_begin.js"):
        for line in asset(name).splitlines():
            assert line.count("/*") == line.count("*/") <= 1, line
    page = batch_template(1, 1, (8, 8), (8, 8))
    assert "Time counts while" not in page
    assert "/* private mode */" in page


def test_the_key_is_private(batch: Path) -> None:
    assert stat.S_IMODE((batch / "key.json").stat().st_mode) == 0o600
    assert stat.S_IMODE((batch / "tasks.csv").stat().st_mode) & 0o044


def test_who_serves_pictures_elsewhere_is_told_to_keep_the_key(data: Path, artists: Path, tmp_path: Path) -> None:
    look = Look(16, 16, base_url="https://study.example/pictures")
    built = make_batch(
        data, tmp_path / "b", dict.fromkeys(DataFolder(data).items(), 1), SCHEME, look, ArtistsFolder(artists)
    )
    assert "and nothing else: key.json tells all answers" in "".join(built.notes)


def test_one_shape_has_no_sentinels_and_the_command_says_so(tmp_path: Path) -> None:
    data = make_data(tmp_path / "data", shapes=1, views=2)
    built = make_batch(
        data, tmp_path / "b", dict.fromkeys(DataFolder(data).items(), 3), Scheme(), Look(16, 16), SimulatedArtists(data)
    )
    assert (built.real, built.sentinels) == (2, 0)
    assert sum("no sentinels" in note for note in built.notes) == 1
    assert Key.load(tmp_path / "b").settings["scheme"]["sentinels"] == 0


def test_templates_refuse_missing_values_and_escape_what_they_get() -> None:
    with pytest.raises(Exception, match="undefined"):
        render("site_message.html.j2", title="x", text="y")
    page = render("site_message.html.j2", title="<b>", text="<script>alert(1)</script>", contact="")
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


def test_a_curious_participant_finds_no_clue(batch: Path) -> None:
    """Names, values, order, bytes, pixels' size, metadata and ages are the same for sentinels and real questions."""
    key = Key.load(batch)
    template = (batch / "template.html").read_text()
    assert "sentinel" not in template.lower()
    assert "artist" not in template.lower()
    kinds: dict[str, set[tuple[int, int, int, str, str, float]]] = {"d": set(), "r": set()}
    for row in rows(batch):
        for name, cell in row.items():
            assert not re.search(r"shape|sentinel|artist|_0", cell), cell
            match = re.fullmatch(r"q\d+_([dr])\d+", name)
            if match:
                path = batch / cell
                with Picture.open(path) as picture:
                    seen = (*picture.size, path.stat().st_size, picture.mode, str(picture.info), path.stat().st_mtime)
                assert re.fullmatch(r"images/[a-f][0-9a-f]{15}\.png", cell)
                kinds[match[1]].add(seen)
    assert len(kinds["d"]) == 1
    assert len(kinds["r"]) == 1
    values = [value for one in key.questionnaires.values() for question in one.questions for value in question.options]
    assert len(set(values)) == len(values)
    # A spreadsheet takes what begins with a digit for a number, if it can.
    assert all(re.fullmatch(r"[a-f][0-9a-f]{15}", value) for value in (*values, *key.questionnaires))


def test_no_picture_occurs_twice_in_a_questionnaire(batch: Path) -> None:
    """The same drawing in two questions would tell that one of them is a sentinel."""
    for row in rows(batch):
        contents = [(batch / row[name]).read_bytes() for name in row if re.fullmatch(r"q\d+_d\d+", name)]
        assert len(set(contents)) == len(contents) == 13 * 8


def test_sentinels_stand_anywhere_and_so_do_their_answers(data: Path, artists: Path, tmp_path: Path) -> None:
    make_batch(
        data, tmp_path / "b", dict.fromkeys(DataFolder(data).items(), 30), SCHEME, Look(16, 16), ArtistsFolder(artists)
    )
    key = Key.load(tmp_path / "b")
    sentinels = [q for one in key.questionnaires.values() for q in one.questions if q.sentinel]
    places = Counter(question.number for question in sentinels)
    answers = Counter(question.position(question.correct) for question in sentinels)
    assert len(sentinels) == 216
    assert set(places) == set(range(1, 14))
    assert max(places.values()) < 3 * 216 / 13
    assert set(answers) == set(range(1, 9))
    assert max(answers.values()) < 2 * 216 / 8


def test_sentinels_show_one_drawing_of_the_shape_and_seven_of_others(data: Path, artists: Path) -> None:
    items = DataFolder(data).items()
    drawings = [Drawing(item, artists / item.name / f"{i}.png") for item in items for i in range(3)]
    pool = SentinelPool(drawings, [], 6, np.random.default_rng(0))
    block = items[:4]
    sentinels = pool.draw(3, block)
    assert len(pool) == 6
    assert len({sentinel.item for sentinel in sentinels}) == 3
    used = [drawing for sentinel in sentinels for drawing in sentinel.drawings]
    assert len(set(used)) == len(used)
    for sentinel in sentinels:
        right, *others = sentinel.drawings
        assert right.item == sentinel.item
        assert sentinel.item.shape not in {item.shape for item in block}
        assert len({other.item.shape for other in others}) == 7
        assert sentinel.item.shape not in {other.item.shape for other in others}


def test_sentinels_need_two_shapes() -> None:
    one = [Drawing(Item("only", str(i)), Path(f"{i}.png")) for i in range(9)]
    with pytest.raises(InputError, match="two shapes or more"):
        SentinelPool(one, [], 5, np.random.default_rng(0))


def test_same_seed_same_bytes_other_seed_other_names(data: Path, artists: Path, tmp_path: Path, batch: Path) -> None:
    needs = dict.fromkeys(DataFolder(data).items(), 3)
    make_batch(data, tmp_path / "same", needs, SCHEME, Look(64, 48), ArtistsFolder(artists))
    make_batch(
        data,
        tmp_path / "other",
        needs,
        Scheme(real=10, sentinels=3, pool=6, seed=1),
        Look(64, 48),
        ArtistsFolder(artists),
    )
    for name in ("tasks.csv", "template.html"):
        assert (tmp_path / "same" / name).read_bytes() == (batch / name).read_bytes()
    assert Key.load(tmp_path / "same").questionnaires == Key.load(batch).questionnaires
    assert {path.name for path in (tmp_path / "same/images").iterdir()} == {
        p.name for p in (batch / "images").iterdir()
    }
    assert not set(Key.load(tmp_path / "other").questionnaires) & set(Key.load(batch).questionnaires)


def test_pictures_keep_what_they_show(batch: Path, data: Path) -> None:
    key, row = Key.load(batch), rows(batch)[0]
    question = next(q for q in key.questionnaires[row["questionnaire"]].questions if not q.sentinel)
    assert question.item is not None
    for place, index in enumerate(question.options.values(), 1):
        shown = np.asarray(Picture.open(batch / row[f"{question.field}_d{place}"]).convert("L"), dtype=float)
        source = Picture.open(data / "views" / question.item.name / "drawings" / f"{index}.png").convert("L")
        expected = np.asarray(source.resize((64, 64), Picture.Resampling.BOX), dtype=float)
        assert np.abs(shown - expected).mean() < 8


def test_embedded_pictures(data: Path, artists: Path, tmp_path: Path) -> None:
    needs = dict.fromkeys(DataFolder(data).items()[:4], 2)
    make_batch(data, tmp_path / "b", needs, SCHEME, Look(16, 16, embed=True), ArtistsFolder(artists))
    assert rows(tmp_path / "b")[0]["q01_d1"].startswith("data:image/png;base64,")


def test_small_data_sets_are_asked_about_as_far_as_they_go(tmp_path: Path) -> None:
    data = make_data(tmp_path / "data", shapes=2, views=2)
    artists = make_artists(tmp_path / "artists", data)
    needs = dict.fromkeys(DataFolder(data).items(), 3)
    built = make_batch(data, tmp_path / "b", needs, Scheme(), Look(16, 16), ArtistsFolder(artists))
    assert (built.questionnaires, built.real, built.sentinels) == (3, 4, 4)
    assert len(built.notes) == 2


def test_padding_keeps_the_picture() -> None:
    png = png_bytes(from_ink(scribble(np.random.default_rng(0), 3)))
    longer = pad_png(png, len(png) + 100)
    assert len(longer) == len(png) + 100
    import io

    with Picture.open(io.BytesIO(longer)) as picture, Picture.open(io.BytesIO(png)) as before:
        picture.load()
        assert (np.asarray(picture) == np.asarray(before)).all()
    with pytest.raises(ValueError, match="don't fit"):
        pad_png(png, len(png) + 11)


def test_a_folder_that_holds_something_is_left_alone(batch: Path, data: Path, artists: Path) -> None:
    with pytest.raises(UsageError, match="holds files already"):
        make_batch(data, batch, dict.fromkeys(DataFolder(data).items(), 3), SCHEME, Look(), ArtistsFolder(artists))


def test_nothing_is_left_behind_when_a_picture_is_broken(tmp_path: Path) -> None:
    data = make_data(tmp_path / "data", shapes=3, views=1)
    artists = make_artists(tmp_path / "artists", data)
    (data / "views/shape_1_0/drawings/3.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"3\.png"):
        make_batch(
            data,
            tmp_path / "b",
            dict.fromkeys(DataFolder(data).items(), 3),
            SCHEME,
            Look(16, 16),
            ArtistsFolder(artists),
        )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["artists", "data"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not JSON"),
        ("[]", "no questionnaires"),
        ('{"questionnaires": {"a": {"questions": [{"field": "q01", "sentinel": false, "options": {}}]}}}', "not a key"),
        ('{"questionnaires": {"a": {"questions": [{"field": "q01", "shape": "s", "view": 0, "sentinel": false, '
         '"options": {"v": 8}}]}}}', "not a key"),
    ],
)  # fmt: skip
def test_broken_keys_are_named(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "key.json").write_text(text)
    with pytest.raises(InputError, match=message):
        Key.load(tmp_path)


def test_a_key_with_the_least_is_enough(tmp_path: Path) -> None:
    questions = [
        {"field": "q01", "shape": "s", "view": 0, "sentinel": False, "options": {f"v{i}": i for i in range(8)}},
        {"field": "q02", "sentinel": True, "correct": "w"},
    ]
    (tmp_path / "key.json").write_text(json.dumps({"questionnaires": {"id": {"questions": questions}}}))
    real, sentinel = Key.load(tmp_path).questionnaires["id"].questions
    assert (real.item, real.choice("v3"), real.choice(NONE), real.choice("w")) == (Item("s", "0"), 3, -1, None)
    assert (sentinel.item, sentinel.choice("w"), sentinel.correct) == (None, 0, "w")
