"""`ncontours crowd serve`: the site of our own."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dataset_tools.cli import options
from ncmodel.cli.common import emit
from ncmodel.errors import ArgumentError

if TYPE_CHECKING:
    from dataset_tools.site.server import Addresses


def serve(
    batch_dir: options.BatchDir,
    db: Annotated[Path, typer.Option(help="Database of answers; made if there is none.")],
    port: Annotated[int, typer.Option(help="Port to listen on; 0 takes a free one.", min=0, max=65535)] = 8000,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    public_url: Annotated[
        str, typer.Option(help="The address that participants use, where a proxy stands before.")
    ] = "",
    proxies: Annotated[
        int, typer.Option(help="Proxies before the site that add to X-Forwarded-For; 0 believes nobody.", min=0, max=9)
    ] = 0,
    parameters: Annotated[
        str, typer.Option(help="Recruiting parameters in the link; the first says who the participant is.")
    ] = "PROLIFIC_PID,STUDY_ID,SESSION_ID",
    open_to_all: Annotated[bool, typer.Option(help="Let people without that parameter take part.")] = False,
    completion_code: Annotated[str, typer.Option(help="Code to show at the end.")] = "",
    completion_url: Annotated[
        str, typer.Option(help="Where the end page leads; {code} is the code.")
    ] = "https://app.prolific.com/submissions/complete?cc={code}",
    consent: Annotated[Path | None, typer.Option(help="Text file of the consent page, a paragraph a line.")] = None,
    contact: Annotated[str, typer.Option(help="Whom participants ask.")] = "",
    places: Annotated[int, typer.Option(help="Participants wanted for each questionnaire.", min=1)] = 1,
    abandoned_after: Annotated[
        float, typer.Option(help="Minutes after which an idle questionnaire is given away.")
    ] = 60.0,
    replace_unreliable: Annotated[
        bool, typer.Option(help="Offer unreliable participants' questionnaires again.")
    ] = False,
    taken_part: Annotated[
        list[Path] | None,
        typer.Option(
            help="Votes, answers or database of an earlier round, whose participants can't again; repeatable."
        ),
    ] = None,
    signed_links: Annotated[bool, typer.Option(help="Let in only people with a link that `crowd links` made.")] = False,
    token_file: Annotated[
        Path | None, typer.Option(help="File with the requester's token; DB.token by default.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print where it listens as one JSON object.")] = False,
) -> None:
    """Serve a batch as a web site of its own, for participants of Prolific or anybody with the link."""
    from dataset_tools.site.database import Policy
    from dataset_tools.site.participant_pages import CONSENT, Settings
    from dataset_tools.site.server import SiteFiles, read_consent, read_token, site_parameters
    from dataset_tools.site.server import serve as serve_site
    from dataset_tools.votes.ingest import workers_of

    if abandoned_after <= 0:
        raise ArgumentError("abandoned_after", str(abandoned_after), "minutes > 0")
    files = SiteFiles(batch_dir, db, token_file or _token_of(db))
    settings = Settings(
        parameters=site_parameters(parameters),
        open_to_all=open_to_all,
        completion_code=completion_code,
        completion_url=completion_url,
        consent=read_consent(consent) if consent else CONSENT,
        contact=contact,
        public_url=public_url.rstrip("/"),
        proxies=proxies,
        link_token=read_token(files.token) if signed_links else "",
    )
    policy = Policy(places, 60 * abandoned_after, replace_unreliable, workers_of(taken_part or ()))

    def announce(found: "Addresses") -> None:
        if as_json:
            emit(found.record(), as_json)
            sys.stdout.flush()
        else:
            sys.stderr.write(found.text() + "\n")

    serve_site(files, settings, policy, host, port, announce)


def links(
    db: Annotated[Path, typer.Option(help="Database of the site that is served, or will be.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="CSV file of participants and links to write.")],
    base_url: Annotated[str, typer.Option(help="Address of the site.")],
    participants: Annotated[Path | None, typer.Option(help="Text file with a participant's number a line.")] = None,
    count: Annotated[int, typer.Option(help="Make up so many numbers instead.", min=0, max=100_000)] = 0,
    parameter: Annotated[str, typer.Option(help="First of the site's recruiting parameters.")] = "PROLIFIC_PID",
    token_file: Annotated[
        Path | None, typer.Option(help="File with the requester's token; DB.token by default.")
    ] = None,
) -> None:
    """Make links for participants of your own, each for one person, for `crowd serve --signed-links`."""
    from dataset_tools.site.links import made_up, read_workers, write_links
    from dataset_tools.site.server import read_token

    if (participants is None) == (count == 0):
        raise ArgumentError("count", str(count), "either that or --participants")
    workers = read_workers(participants) if participants else made_up(count)
    write_links(output, base_url, parameter, workers, read_token(token_file or _token_of(db)))
    typer.echo(f"{len(workers)} links in {output}", err=True)


def backup(
    db: Annotated[Path, typer.Argument(help="Database of a site.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="File to copy it to.")],
) -> None:
    """Copy a site's database, whole, while the site runs, too."""
    from dataset_tools.votes.results_sqlite import back_up

    sent = back_up(db, output)
    typer.echo(f"{output}: {sent} questionnaires that were sent", err=True)


def _token_of(db: Path) -> Path:
    return db.with_name(db.name + ".token")
