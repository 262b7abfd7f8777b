"""What came back, from files: results read into votes, and which items are still short of them."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from dataset_tools.questionnaires.identical_drawings import items_to_ask_about
from dataset_tools.questionnaires.questionnaire import Key
from dataset_tools.votes.answer_file import Ingested, read_rows
from dataset_tools.votes.reliability import assess, counted
from dataset_tools.votes.results_csv import Answered, Problem, read_csv_results
from dataset_tools.votes.results_sqlite import is_database, read_site_results
from dataset_tools.votes.votes import ITEM, ingest, read_votes
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import NeuralContoursError


def ingest_results(batch_dir: Path, results: Sequence[Path], out: Path) -> Ingested:
    """Read results files into a vote file.

    Raises:
        InputError: The batch has no key, `out` isn't a vote file, or nothing could be read from any file.
    """
    return ingest(read_results(results), Key.load(batch_dir), out)


def read_results(results: Iterable[Path]) -> Iterator[Answered | Problem]:
    """The rows of all results files; a file that can't be read at all is a problem like a row that can't."""
    for path in results:
        try:
            yield from read_site_results(path) if is_database(path) else read_csv_results(path)
        except NeuralContoursError as error:
            yield Problem(str(path), str(error).removeprefix(f"{path}: "))


def workers_of(files: Iterable[Path]) -> frozenset[str]:
    """Who took part, from files of votes or answers and sites' databases.

    Raises:
        InputError: One can't be read.
    """
    return frozenset(worker for path in files for worker in _workers(path))


def _workers(path: Path) -> Iterator[str]:
    if is_database(path):
        return (answered.worker for answered in read_site_results(path))
    return (row["worker"] for _, row in read_rows(path, ("worker",), (), "a file of votes or answers"))


def top_up_needs(data_dir: Path, votes: Path, wanted: int) -> dict[Item, int]:
    """How many votes of reliable participants each item still lacks; items that lack none are left out.

    Raises:
        InputError: A file can't be read.
    """
    everything = read_votes(votes)
    have = counted(everything, assess(everything)).groupby(ITEM).size()
    items = items_to_ask_about(DataFolder(data_dir))
    short = {item: wanted - int(have.get((item.shape, item.view), 0)) for item in items}
    return {item: lacking for item, lacking in short.items() if lacking > 0}
