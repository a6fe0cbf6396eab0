//! The HTTP server of the page, and of metrics and health. Whatever a stranger sends is bounded:
//! connections, bytes and number of headers, time. One connection carries one request, without a
//! body, and what it asks for is to read.

use crate::stall::{Stall, StallStream};
use crate::tls::{Acceptor, Shown};
use axum::body::Body;
use axum::http::header::{ALLOW, CONTENT_TYPE};
use axum::http::{HeaderValue, Method, Request, Response, StatusCode};
use futures_util::FutureExt;
use hyper::body::{Body as _, Incoming};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::oneshot;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{sleep, timeout};

/// Connections at once, without those of watchers: the next one takes the place of the oldest,
/// which has had its time. So those who hold connections open keep nobody out.
const CONNECTIONS: usize = 64;
/// Most bytes of a request's first line and headers.
const HEAD_BYTES: usize = 16 << 10;
/// Most headers of a request.
const HEADERS: usize = 64;
/// Longest wait for the whole of them, and for a TLS handshake before them.
const HEAD: Duration = Duration::from_secs(5);
/// Longest life of a connection that asks for metrics.
const TEXT_LIFE: Duration = Duration::from_secs(10);
/// After an answer, what a client still sends is read and thrown away for so long and up to so many
/// bytes: closed at once, the connection would be reset, and the answer might be lost.
const LINGER: (Duration, usize) = (Duration::from_millis(500), 256 << 10);
/// How long requests at hand may take when the server ends.
const LAST: Duration = Duration::from_millis(500);
/// Before the next connection is taken, where there was no descriptor for one.
const PAUSE: Duration = Duration::from_millis(50);
/// Between looks whether a watcher still watches.
const LOOK: Duration = Duration::from_millis(500);
/// Threads on which files are read and reports waited for.
const BLOCKING: usize = 8;

/// Who asks: what is known of a connection.
#[derive(Clone, Debug)]
pub(crate) struct Caller {
    /// The certificate that it showed, where it had to show one.
    pub(crate) shown: Option<Shown>,
    /// Set while it is sent events.
    pub(crate) watching: Arc<AtomicBool>,
}

/// An answer that is on its way.
pub(crate) type Answer = Pin<Box<dyn Future<Output = Response<Body>> + Send>>;
/// What is answered.
pub(crate) type Answers = dyn Fn(Request<Body>, Caller) -> Answer + Send + Sync;
/// What a path is answered: a status and a text.
pub type TextAnswers = dyn Fn(&str) -> (u16, String) + Send + Sync;

/// How a server is set up.
pub(crate) struct ServerSetup {
    /// What its thread is called.
    pub(crate) name: &'static str,
    /// Longest life of a connection that is not a watcher's.
    pub(crate) life: Duration,
    /// Longest time for which a reader may take nothing of what waits for it.
    pub(crate) stall: Duration,
    pub(crate) tls: Option<Acceptor>,
    pub(crate) answers: Box<Answers>,
}

/// A server; it ends when dropped.
#[derive(Debug)]
pub(crate) struct HttpServer {
    address: SocketAddr,
    stop: Option<oneshot::Sender<Infallible>>,
    thread: Option<JoinHandle<()>>,
}

impl HttpServer {
    /// Listens, and answers in a thread of its own.
    pub(crate) fn start(address: SocketAddr, setup: ServerSetup) -> io::Result<Self> {
        let runtime =
            Builder::new_current_thread().max_blocking_threads(BLOCKING).enable_all().build()?;
        let listener = runtime.block_on(TcpListener::bind(address))?;
        let address = listener.local_addr()?;
        let (stop, stopped) = oneshot::channel();
        let name = setup.name.to_owned();
        let work = move || {
            runtime.block_on(serve(listener, Arc::new(setup), stopped));
            // Who waits for a report waits in vain.
            runtime.shutdown_timeout(LAST);
        };
        let thread = std::thread::Builder::new().name(name).spawn(work)?;
        Ok(Self { address, stop: Some(stop), thread: Some(thread) })
    }

    /// Where it listens.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for HttpServer {
    fn drop(&mut self) {
        self.stop.take();
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

/// A server of short texts over plain HTTP; it ends when dropped.
#[derive(Debug)]
pub struct TextServer(#[allow(dead_code, reason = "it serves until dropped")] HttpServer);

impl TextServer {
    /// Listens, and answers in a thread of its own, called `name`.
    ///
    /// # Errors
    /// The address is not to be had, or a thread.
    pub fn start(
        name: &'static str,
        address: SocketAddr,
        answers: Arc<TextAnswers>,
    ) -> io::Result<Self> {
        let answer = move |request: Request<Body>, _: Caller| -> Answer {
            let (status, text) = answers(request.uri().path());
            let status = StatusCode::from_u16(status).unwrap_or(StatusCode::OK);
            Box::pin(std::future::ready(plain(status, text)))
        };
        let (life, answers) = (TEXT_LIFE, Box::new(answer));
        let setup = ServerSetup { name, life, stall: life, tls: None, answers };
        HttpServer::start(address, setup).map(Self)
    }
}

/// A text as an answer.
pub(crate) fn plain(status: StatusCode, text: impl Into<String>) -> Response<Body> {
    let mut response = Response::new(Body::from(text.into()));
    *response.status_mut() = status;
    let kind = HeaderValue::from_static("text/plain; version=0.0.4; charset=utf-8");
    response.headers_mut().insert(CONTENT_TYPE, kind);
    response
}

/// A connection that is open.
struct Open {
    task: AbortHandle,
    watching: Arc<AtomicBool>,
}

async fn serve(
    listener: TcpListener,
    setup: Arc<ServerSetup>,
    mut stopped: oneshot::Receiver<Infallible>,
) {
    let (mut tasks, mut open) = (JoinSet::new(), VecDeque::<Open>::new());
    loop {
        tokio::select! {
            _ = &mut stopped => break,
            Some(_) = tasks.join_next() => open.retain(|one| !one.task.is_finished()),
            taken = listener.accept() => match taken {
                Ok((stream, _)) => {
                    let strangers = open.iter().filter(|one| !is_set(&one.watching)).count();
                    if strangers >= CONNECTIONS {
                        drop_oldest(&mut open);
                    }
                    let watching = Arc::default();
                    let talk = talk(stream, Arc::clone(&setup), Arc::clone(&watching));
                    open.push_back(Open { task: tasks.spawn(talk), watching });
                }
                Err(error) => {
                    tracing::debug!("{}: {error}", setup.name);
                    drop_oldest(&mut open);
                    sleep(PAUSE).await;
                }
            },
        }
    }
    drop(listener);
    let rest = async { while tasks.join_next().await.is_some() {} };
    drop(timeout(LAST, rest).await);
}

fn is_set(flag: &AtomicBool) -> bool {
    flag.load(Ordering::Relaxed)
}

fn drop_oldest(open: &mut VecDeque<Open>) {
    if let Some(oldest) = open.iter().position(|one| !is_set(&one.watching))
        && let Some(one) = open.remove(oldest)
    {
        one.task.abort();
    }
}

/// One connection, as long as it may live and somebody reads what is sent.
async fn talk(stream: TcpStream, setup: Arc<ServerSetup>, watching: Arc<AtomicBool>) {
    let stall = Stall::default();
    let stream = StallStream::new(stream, stall.clone());
    let old = async {
        sleep(setup.life).await;
        while is_set(&watching) {
            sleep(LOOK).await;
        }
    };
    let caller = Caller { shown: None, watching: Arc::clone(&watching) };
    tokio::select! {
        () = greet(stream, &setup, caller) => {}
        () = stall.wait(setup.stall) => {
            tracing::debug!("{}: one that took nothing is sent away", setup.name);
        }
        () = old => {}
    }
}

async fn greet(stream: StallStream, setup: &Arc<ServerSetup>, mut caller: Caller) {
    let Some(tls) = &setup.tls else {
        return speak(stream, setup, caller).await;
    };
    match timeout(HEAD, tls.accept(stream)).await {
        Ok(Ok((stream, shown))) => {
            let left = shown.left();
            caller.shown = Some(shown);
            // A link ends with its certificate.
            drop(timeout(left, speak(stream, setup, caller)).await);
        }
        Ok(Err(error)) => tracing::debug!("{}: {error}", setup.name),
        Err(_) => {}
    }
}

/// A request, its answer, the end.
async fn speak<S: AsyncRead + AsyncWrite + Unpin>(
    stream: S,
    setup: &Arc<ServerSetup>,
    caller: Caller,
) {
    let shared = Arc::clone(setup);
    let answer = move |request: Request<Incoming>| {
        respond(request, &*shared.answers, caller.clone()).map(Ok::<_, Infallible>)
    };
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD)
        .keep_alive(false)
        .max_headers(HEADERS)
        .max_header_size(HEAD_BYTES)
        .max_buf_size(HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service_fn(answer));
    if let Err(error) = poll_fn(|context| connection.poll_without_shutdown(context)).await {
        tracing::debug!("{}: {error}", setup.name);
    }
    linger(connection.into_parts().io.into_inner()).await;
}

async fn linger<S: AsyncRead + AsyncWrite + Unpin>(mut stream: S) {
    if stream.shutdown().await.is_err() {
        return;
    }
    let (time, mut left) = LINGER;
    let rest = async {
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = stream.read(&mut bytes).await {
            left = left.saturating_sub(count);
            if left == 0 {
                break;
            }
        }
    };
    drop(timeout(time, rest).await);
}

fn respond(request: Request<Incoming>, answers: &Answers, caller: Caller) -> Answer {
    let known = matches!(*request.method(), Method::GET | Method::HEAD);
    let response = match (request.body().is_end_stream(), known) {
        (false, _) => plain(StatusCode::PAYLOAD_TOO_LARGE, "no bodies are taken here\n"),
        (true, false) => {
            let mut no = plain(StatusCode::METHOD_NOT_ALLOWED, "there is GET and HEAD\n");
            no.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
            no
        }
        (true, true) => return answers(request.map(|_| Body::empty()), caller),
    };
    Box::pin(std::future::ready(response))
}
