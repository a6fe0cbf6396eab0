//! The HTTP server of metrics and health. Whatever a stranger sends is bounded: connections,
//! bytes and number of headers, time. One connection carries one request and no body.

use hyper::body::{Body, Incoming};
use hyper::header::{ALLOW, CONTENT_TYPE, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::{poll_fn, ready};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::oneshot;
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{sleep, timeout};

/// Connections at once: the next one takes the place of the oldest, which has had its time. So
/// those who hold connections open keep nobody out.
const CONNECTIONS: usize = 64;
/// Most bytes of a request's first line and headers.
const HEAD_BYTES: usize = 16 << 10;
/// Most headers of a request.
const HEADERS: usize = 64;
/// Longest wait for the whole of them.
const HEAD: Duration = Duration::from_secs(5);
/// Longest life of a connection.
const LIFE: Duration = Duration::from_secs(10);
/// After an answer, what a client still sends is read and thrown away for so long and up to so many
/// bytes: closed at once, the connection would be reset, and the answer might be lost.
const LINGER: (Duration, usize) = (Duration::from_millis(500), 256 << 10);
/// How long requests at hand may take when the server ends.
const LAST: Duration = Duration::from_millis(500);
/// Before the next connection is taken, where there was no descriptor for one.
const PAUSE: Duration = Duration::from_millis(50);

/// What a path is answered: status and text.
pub(super) type Answers = dyn Fn(&str) -> (StatusCode, String) + Send + Sync;

/// The server; it ends when dropped.
pub(super) struct Server {
    stop: Option<oneshot::Sender<Infallible>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens, and answers in a thread of its own.
    pub(super) fn start(address: SocketAddr, answers: Arc<Answers>) -> io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let listener = runtime.block_on(TcpListener::bind(address))?;
        let (stop, stopped) = oneshot::channel();
        let work = move || runtime.block_on(serve(listener, answers, stopped));
        let thread = std::thread::Builder::new().name("cullet-metrics".into()).spawn(work)?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.take();
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

async fn serve(
    listener: TcpListener,
    answers: Arc<Answers>,
    mut stopped: oneshot::Receiver<Infallible>,
) {
    let (mut tasks, mut open) = (JoinSet::new(), VecDeque::<AbortHandle>::new());
    loop {
        tokio::select! {
            _ = &mut stopped => break,
            Some(_) = tasks.join_next() => open.retain(|task| !task.is_finished()),
            taken = listener.accept() => match taken {
                Ok((stream, _)) => {
                    if open.len() >= CONNECTIONS {
                        drop_oldest(&mut open);
                    }
                    let connection = timeout(LIFE, talk(stream, Arc::clone(&answers)));
                    open.push_back(tasks.spawn(async { drop(connection.await) }));
                }
                Err(error) => {
                    tracing::debug!("metrics: {error}");
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

fn drop_oldest(open: &mut VecDeque<AbortHandle>) {
    if let Some(oldest) = open.pop_front() {
        oldest.abort();
    }
}

/// One connection: a request, its answer, the end.
async fn talk(stream: TcpStream, answers: Arc<Answers>) {
    let answer =
        move |request: Request<Incoming>| ready(Ok::<_, Infallible>(respond(&request, &*answers)));
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD)
        .keep_alive(false)
        .max_headers(HEADERS)
        .max_header_size(HEAD_BYTES)
        .max_buf_size(HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service_fn(answer));
    if let Err(error) = poll_fn(|context| connection.poll_without_shutdown(context)).await {
        tracing::debug!("metrics: {error}");
    }
    linger(connection.into_parts().io.into_inner()).await;
}

async fn linger(mut stream: TcpStream) {
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

fn respond(request: &Request<Incoming>, answers: &Answers) -> Response<String> {
    let known = matches!(*request.method(), Method::GET | Method::HEAD);
    let (status, text) = match (request.body().is_end_stream(), known) {
        (false, _) => (StatusCode::PAYLOAD_TOO_LARGE, "no bodies are taken here\n".to_owned()),
        (true, false) => (StatusCode::METHOD_NOT_ALLOWED, "there is GET and HEAD\n".to_owned()),
        (true, true) => answers(request.uri().path()),
    };
    let mut response = Response::new(text);
    *response.status_mut() = status;
    let kind = HeaderValue::from_static("text/plain; version=0.0.4; charset=utf-8");
    response.headers_mut().insert(CONTENT_TYPE, kind);
    if status == StatusCode::METHOD_NOT_ALLOWED {
        response.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
    }
    response
}
