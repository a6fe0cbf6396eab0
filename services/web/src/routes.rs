//! What can be asked for.

use crate::events::{PAGE as PAGE_BYTES, events};
use crate::feed::Feed;
use crate::headers::{DRAWING_POLICY, REPORT_POLICY, is_of_another_site};
use crate::reports::{NoReport, ReportQueue};
use crate::server::{Caller, plain};
use crate::view::{RunView, SHEET, list};
use axum::Router;
use axum::body::Body;
use axum::extract::{Extension, Path, Request, State};
use axum::http::header::{CONTENT_LENGTH, CONTENT_SECURITY_POLICY, CONTENT_TYPE, LINK};
use axum::http::{HeaderName, HeaderValue, Response, StatusCode, Uri};
use axum::middleware::{Next, from_fn};
use axum::routing::get;
use cullet_proto::service::FileInfo;
use futures_util::stream::unfold;
use serde::Serialize;
use std::fs::File;
use std::io::{self, Read};
use tokio::task::spawn_blocking;

const PAGE: &str = include_str!("../assets/page.html");
const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");

/// Who may have the page open at once; further ones are told so.
const WATCHERS: usize = 64;
/// Most bytes of a file of a run that is shown.
const MAX_FILE: u64 = 64 << 20;
/// Bytes of a file that are read ahead of whom they are sent to.
const PIECE: u64 = 256 << 10;
/// What is shown of a run that is over: name of the file, its kind.
const SHOWN: [(&str, &str, &str); 3] = [
    ("picture", SHEET, "image/png"),
    ("film", "preview.gif", "image/gif"),
    ("timeline", "timeline.svg", "image/svg+xml"),
];

/// What answers are made of.
#[derive(Clone, Debug)]
pub(crate) struct Sources {
    pub(crate) feed: Feed,
    pub(crate) reports: ReportQueue,
}

type WebReply = Response<Body>;

/// Every way to ask.
pub(crate) fn routes(sources: Sources) -> Router {
    Router::new()
        .route("/", get(|| asset(PAGE, "text/html; charset=utf-8")))
        .route("/page.css", get(|| asset(STYLE, "text/css; charset=utf-8")))
        .route("/page.js", get(|| asset(SCRIPT, "text/javascript; charset=utf-8")))
        .route("/healthz", get(|| async { plain(StatusCode::OK, "ok\n") }))
        .route("/events", get(watch))
        .route("/api/farm", get(farm))
        .route("/api/runs", get(runs))
        .route("/api/runs/{run}", get(run))
        .route("/api/workers", get(workers))
        .merge(of_runs())
        .fallback(|| async { missing("there is no such page here\n") })
        .with_state(sources)
}

/// What runs left: large, slow to make, and asked for by the page alone.
fn of_runs() -> Router<Sources> {
    Router::new()
        .route("/runs/{run}/report", get(report))
        .route("/runs/{run}/{what}", get(file))
        .route_layer(from_fn(same_site))
}

/// Refuses what a page from elsewhere asks for.
async fn same_site(request: Request, next: Next) -> WebReply {
    if is_of_another_site(request.headers()) {
        let text = "a page from elsewhere asks for this: open it from the farm's page\n";
        return plain(StatusCode::FORBIDDEN, text);
    }
    next.run(request).await
}

async fn asset(text: &'static str, kind: &'static str) -> WebReply {
    of_kind(kind, text)
}

fn of_kind(kind: &'static str, bytes: impl Into<Body>) -> WebReply {
    let mut reply = Response::new(bytes.into());
    reply.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    reply
}

fn missing(text: impl Into<String>) -> WebReply {
    plain(StatusCode::NOT_FOUND, text)
}

fn json(data: &impl Serialize) -> WebReply {
    match serde_json::to_vec(data) {
        Ok(bytes) => of_kind("application/json", bytes),
        Err(error) => plain(StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")),
    }
}

async fn watch(State(sources): State<Sources>, Extension(caller): Extension<Caller>) -> WebReply {
    if sources.feed.watchers() >= WATCHERS {
        let text = format!("{WATCHERS} watch already, which is as many as may\n");
        return plain(StatusCode::SERVICE_UNAVAILABLE, text);
    }
    events(&sources.feed, caller.watching)
}

async fn farm(State(sources): State<Sources>) -> WebReply {
    json(&sources.feed.now().clock)
}

/// A page of the runs by number: `?after=N` begins behind run N, and the header `link` names the
/// next page, if there is one.
async fn runs(State(sources): State<Sources>, uri: Uri) -> WebReply {
    let asked = uri.query().unwrap_or_default();
    let after = match asked.strip_prefix("after=").map(str::parse::<u64>) {
        Some(Ok(after)) => after,
        None if asked.is_empty() => 0,
        _ => return plain(StatusCode::BAD_REQUEST, "ask as in /api/runs?after=7\n"),
    };
    let now = sources.feed.now();
    let (mut bytes, mut last, mut page) = (0, after, Vec::new());
    let mut more = false;
    for (run, view) in now.runs.range(after.saturating_add(1)..) {
        bytes += view.json.len();
        if bytes > PAGE_BYTES && !page.is_empty() {
            more = true;
            break;
        }
        page.push(&view.json);
        last = *run;
    }
    let mut reply = of_kind("application/json", list(page));
    let next = HeaderValue::from_str(&format!("</api/runs?after={last}>; rel=\"next\""));
    if let (true, Ok(next)) = (more, next) {
        reply.headers_mut().insert(LINK, next);
    }
    reply
}

async fn workers(State(sources): State<Sources>) -> WebReply {
    of_kind("application/json", sources.feed.now().workers.json.clone())
}

/// A run by itself, with the files that can be fetched. Its texts are cut as in the list of all.
#[derive(Serialize)]
struct RunWithProducts<'a> {
    #[serde(flatten)]
    run: &'a RunView,
    products: &'a [FileInfo],
}

fn number(text: &str) -> Result<u64, Box<WebReply>> {
    text.parse().map_err(|_| Box::new(missing("a run is named by its number\n")))
}

fn no_run(run: u64) -> WebReply {
    missing(format!("there is no run {run}\n"))
}

async fn run(State(sources): State<Sources>, Path(run): Path<String>) -> WebReply {
    let run = match number(&run) {
        Ok(run) => run,
        Err(reply) => return *reply,
    };
    match sources.feed.run(run) {
        Some((view, _)) => json(&RunWithProducts { run: &view, products: &view.files }),
        None => no_run(run),
    }
}

async fn report(State(sources): State<Sources>, Path(run): Path<String>) -> WebReply {
    let run = match number(&run) {
        Ok(run) => run,
        Err(reply) => return *reply,
    };
    let Some((view, _)) = sources.feed.run(run) else { return no_run(run) };
    match sources.reports.page(view).await {
        Ok(page) => guarded(of_file("text/html; charset=utf-8", page), REPORT_POLICY),
        Err(no @ NoReport::Unfinished { .. }) => missing(format!("{no}\n")),
        Err(no @ NoReport::Busy { .. }) => {
            plain(StatusCode::SERVICE_UNAVAILABLE, format!("{no}\n"))
        }
        Err(no) => plain(StatusCode::UNPROCESSABLE_ENTITY, format!("{no}\n")),
    }
}

fn guarded(mut reply: WebReply, policy: &'static str) -> WebReply {
    let headers = reply.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy));
    // What is shut off by its policy may have no other of this kind: browsers would refuse it.
    let opener = HeaderName::from_static("cross-origin-opener-policy");
    headers.insert(opener, HeaderValue::from_static("unsafe-none"));
    reply
}

/// A picture, a film or a timeline of a run; of one that goes on the newest picture.
async fn file(
    State(sources): State<Sources>,
    Path((run, what)): Path<(String, String)>,
) -> WebReply {
    let run = match number(&run) {
        Ok(run) => run,
        Err(reply) => return *reply,
    };
    let Some((_, name, kind)) = SHOWN.iter().find(|(word, ..)| *word == what) else {
        return missing("there are report, picture, film and timeline of a run\n");
    };
    let Some((view, still)) = sources.feed.run(run) else { return no_run(run) };
    let listed = view.files.iter().any(|file| file.name == *name);
    if let (false, Some(still), true) = (listed, still, *name == SHEET) {
        return of_kind(kind, still.as_ref().clone());
    }
    let Some(folder) = view.folder.clone().filter(|_| listed) else {
        return missing(format!("run {run} has no {what} yet\n"));
    };
    let read = spawn_blocking(move || bounded(&folder.join(name)));
    match read.await {
        Ok(Ok(file)) => guarded(of_file(kind, file), DRAWING_POLICY),
        Ok(Err(error)) => missing(format!("{name} of run {run}: {error}\n")),
        Err(error) => plain(StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")),
    }
}

fn bounded(path: &std::path::Path) -> io::Result<File> {
    let file = cullet_files::regular::open(path)?;
    let length = file.metadata()?.len();
    if length > MAX_FILE {
        let text = format!("it has {length} bytes; {MAX_FILE} are shown at most");
        return Err(io::Error::other(text));
    }
    Ok(file)
}

/// A file that is read as it is sent: whoever takes it slowly holds a piece of it, not all.
fn of_file(kind: &'static str, file: File) -> WebReply {
    let length = file.metadata().map_or(0, |known| known.len());
    let pieces = unfold((file, length), |(mut file, left)| async move {
        if left == 0 {
            return None;
        }
        let read = spawn_blocking(move || {
            let mut piece = Vec::new();
            let read = (&mut file).take(left.min(PIECE)).read_to_end(&mut piece);
            read.map(|_| (piece, file))
        });
        match read.await {
            Ok(Ok((piece, file))) if !piece.is_empty() => {
                let left = left.saturating_sub(piece.len() as u64);
                Some((Ok::<_, io::Error>(piece), (file, left)))
            }
            // It ends before its length: whoever takes it notices.
            _ => None,
        }
    });
    let mut reply = of_kind(kind, Body::from_stream(pieces));
    reply.headers_mut().insert(CONTENT_LENGTH, HeaderValue::from(length));
    reply
}
