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
    token_file: Annotated[
        Path | None, typer.Option(help="File with the requester's token; DB.token by default.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print where it listens as one JSON object.")] = False,
) -> None:
    """Serve a batch as a web site of its own, for participants of Prolific or anybody with the link."""
    from dataset_tools.site.database import Policy
    from dataset_tools.site.participant_pages import CONSENT, Settings
    from dataset_tools.site.server import SiteFiles, read_consent, site_parameters
    from dataset_tools.site.server import serve as serve_site
    from dataset_tools.votes.ingest import workers_of

    if abandoned_after <= 0:
        raise ArgumentError("abandoned_after", str(abandoned_after), "minutes > 0")
    settings = Settings(
        parameters=site_parameters(parameters),
        open_to_all=open_to_all,
        completion_code=completion_code,
        completion_url=completion_url,
        consent=read_consent(consent) if consent else CONSENT,
        contact=contact,
        public_url=public_url.rstrip("/"),
        proxies=proxies,
    )
    files = SiteFiles(batch_dir, db, token_file or db.with_name(db.name + ".token"))
    policy = Policy(places, 60 * abandoned_after, replace_unreliable, workers_of(taken_part or ()))

    def announce(found: "Addresses") -> None:
        if as_json:
            emit(found.record(), as_json)
            sys.stdout.flush()
        else:
            sys.stderr.write(found.text() + "\n")

    serve_site(files, settings, policy, host, port, announce)
