//! The page where it is served: address, identity, who may see it.

use crate::feed::Feed;
use crate::headers::{guard, is_this_machine};
use crate::pictures::{Illustrator, PictureThreads};
use crate::reports::{ReportQueue, Reports};
use crate::routes::{Sources, routes};
use crate::server::{Answer, Caller, HttpServer, ServerSetup, plain};
use crate::tls::Acceptor;
use axum::body::Body;
use axum::http::{Request, StatusCode};
use cullet_proto::WorkerId;
use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tower::ServiceExt;

/// Longest life of a connection that is not a watcher's: a report may have to be made first.
const LIFE: Duration = Duration::from_secs(180);
/// Longest time for which a reader may take nothing of what waits for it.
const STALL: Duration = Duration::from_secs(20);

/// How the page is served.
#[derive(Clone, Debug)]
pub struct WebConfig {
    /// Where.
    pub address: SocketAddr,
    /// With TLS, and for whom; without it the address is of this machine alone.
    pub identity: Option<WebIdentity>,
    /// Who draws.
    pub illustrator: Arc<dyn Illustrator>,
}

/// Who the server is, and who may watch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WebIdentity {
    /// Folder with `ca.pem`, `cert.pem` and `key.pem`.
    pub folder: PathBuf,
    /// Names of the certificates that may watch.
    pub watchers: BTreeSet<WorkerId>,
}

/// Why the page is not served.
#[derive(Debug, thiserror::Error)]
pub enum WebError {
    /// Other machines could watch, whoever they are.
    #[error(
        "the page at {address}: other machines can reach this address, and there is no TLS; serve \
         it with TLS, or at an address of this machine alone, such as 127.0.0.1:{}",
        .address.port()
    )]
    Open {
        /// The address.
        address: SocketAddr,
    },
    /// The address cannot be had, or a thread or a folder.
    #[error("the page at {address}: {text}")]
    Unserved {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        text: String,
    },
}

/// The page; it ends when dropped.
#[derive(Debug)]
pub struct Website {
    server: Option<HttpServer>,
    reports: Arc<Reports>,
    feed: Feed,
    _pictures: PictureThreads,
}

impl Website {
    /// Serves the page of a feed.
    ///
    /// # Errors
    /// [`WebError`].
    pub fn serve(config: WebConfig, feed: Feed) -> Result<Self, WebError> {
        Self::start(config, feed, STALL)
    }

    pub(crate) fn start(config: WebConfig, feed: Feed, stall: Duration) -> Result<Self, WebError> {
        let WebConfig { address, identity, illustrator } = config;
        if identity.is_none() && !address.ip().to_canonical().is_loopback() {
            return Err(WebError::Open { address });
        }
        let unserved = |text: String| WebError::Unserved { address, text };
        let failed = |error: std::io::Error| unserved(error.to_string());
        let reports = Arc::new(Reports::new(Arc::clone(&illustrator)).map_err(failed)?);
        let tls = identity.as_ref().map(|who| Acceptor::new(&who.folder)).transpose();
        let tls = tls.map_err(unserved)?;
        let queue = ReportQueue::start(Arc::clone(&reports)).map_err(failed)?;
        let router = routes(Sources { feed: feed.clone(), reports: queue });
        let watchers = identity.map(|who| who.watchers);
        let answer = move |mut request: Request<Body>, caller: Caller| -> Answer {
            if let Err((status, text)) = admit(&request, &caller, watchers.as_ref()) {
                return Box::pin(std::future::ready(plain(status, text)));
            }
            request.extensions_mut().insert(caller);
            let answer = router.clone().oneshot(request);
            Box::pin(async move {
                let Ok(mut response) = answer.await;
                guard(response.headers_mut());
                response
            })
        };
        let (name, answers) = ("cullet-web", Box::new(answer));
        let setup = ServerSetup { name, life: LIFE, stall, tls, answers };
        let server = Some(HttpServer::start(address, setup).map_err(failed)?);
        let pictures = PictureThreads::start(feed.clone(), illustrator).map_err(failed)?;
        Ok(Self { server, reports, feed, _pictures: pictures })
    }

    /// Where it is served.
    #[must_use]
    pub fn address(&self) -> Option<SocketAddr> {
        self.server.as_ref().map(HttpServer::address)
    }
}

impl Drop for Website {
    fn drop(&mut self) {
        self.reports.stop();
        self.feed.leave();
        self.server.take();
    }
}

/// Whether a question may be answered: the certificate that was shown is that of somebody who may
/// watch; without one the question was for this machine, by a name of its own.
fn admit(
    request: &Request<Body>,
    caller: &Caller,
    watchers: Option<&BTreeSet<WorkerId>>,
) -> Result<(), (StatusCode, String)> {
    let Some(watchers) = watchers else {
        if is_this_machine(request.headers()) {
            return Ok(());
        }
        let text = "ask for localhost or 127.0.0.1: this page is for this machine alone\n";
        return Err((StatusCode::MISDIRECTED_REQUEST, text.to_owned()));
    };
    let name = caller.shown.as_ref().map_or("", |shown| &shown.name);
    if WorkerId::new(name).is_ok_and(|name| watchers.contains(&name)) {
        return Ok(());
    }
    let text = format!(
        "the certificate is of {name:?}, which may not watch: roles must name it among users or \
         operators\n"
    );
    Err((StatusCode::FORBIDDEN, text))
}
