//! The coordinator's end of the transport.

use super::config::PoolConfig;
use super::election::{Announcement, Standing};
use super::error::LinkError;
use super::input::PoolInput;
use cullet_proto::security::Rules;
use cullet_proto::transport::Patience;
use cullet_proto::{WorkerId, keys, transport};
use std::io::ErrorKind;
use std::net::{TcpListener, TcpStream, ToSocketAddrs};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::Duration;
use zenoh::Wait;
use zenoh::query::Queryable;
use zenoh::sample::SampleKind;

/// Where a pool listens if no endpoint is given.
const LOOPBACK: &str = "tcp/127.0.0.1:0";
/// A router that cannot be connected to within this is reported.
const CONNECT: Duration = Duration::from_secs(7);
/// Longest look at a place to which no link came about.
const LOOK: Duration = Duration::from_secs(2);
/// How the transport says that it did not connect in time.
const UNABLE: &str = "Unable to connect";
/// Free ports tried: one that is free when asked for may be gone when it is wanted.
const MAX_PORTS: usize = 8;

/// An open transport. Dropping it closes it.
pub(super) struct Transport {
    session: zenoh::Session,
    endpoint: String,
    /// What answers workers; `None`: nobody any more.
    queryable: Option<Queryable<()>>,
    /// The claim to the coordinator's name, where others may come to have it too.
    standing: Option<Standing>,
}

impl Transport {
    pub(super) fn listen(
        config: &PoolConfig,
        coordinator: &WorkerId,
        inputs: &SyncSender<PoolInput>,
    ) -> Result<Self, LinkError> {
        let (session, endpoint) = match &config.router {
            Some(router) => {
                let session = connected(router, config.patience, &config.rules, CONNECT)?;
                (session, router.clone())
            }
            None => {
                let asked = config.listen.as_deref().unwrap_or(LOOPBACK);
                listening(asked, config.patience, &config.rules)?
            }
        };
        // Nobody else comes to a pool at a port of its own.
        let shared = config.router.is_some() || config.listen.is_some();
        let standing = shared.then(|| {
            let (inputs, patience) = (inputs.clone(), config.patience);
            let leave =
                move || !matches!(inputs.try_send(PoolInput::Leave), Err(TrySendError::Full(_)));
            Standing::take(&session, coordinator, patience, leave)
        });
        let standing = standing.transpose()?;
        let failed = |text: String| LinkError::Listen { endpoint: endpoint.clone(), text };
        let queryable = Some(declare(&session, coordinator, inputs).map_err(failed)?);
        Ok(Self { session, endpoint, queryable, standing })
    }

    /// What tells whether there is another of this name.
    pub(super) fn announcement(&self) -> Announcement {
        self.standing.as_ref().map(Standing::announcement).unwrap_or_default()
    }

    /// Answers no worker any more: another does.
    pub(super) fn stop_answering(&mut self) {
        self.queryable = None;
    }

    pub(super) fn endpoint(&self) -> &str {
        &self.endpoint
    }

    pub(super) fn session(&self) -> &zenoh::Session {
        &self.session
    }

    pub(super) fn close(self) {
        drop((self.queryable, self.standing));
        if let Err(error) = self.session.close().wait() {
            tracing::warn!("closing the link: {error}");
        }
    }
}

/// A session that others connect to, and where.
pub(super) fn listening(
    asked: &str,
    patience: Patience,
    rules: &Rules,
) -> Result<(zenoh::Session, String), LinkError> {
    let tries = if asked.ends_with(":0") { MAX_PORTS } else { 1 };
    let mut last = None;
    for _ in 0..tries {
        let endpoint = concrete(asked)?;
        let mut settings = transport::router(&endpoint, patience);
        settings.extend(rules.iter().cloned());
        match open(&settings) {
            Ok(session) => return Ok((session, endpoint)),
            Err(text) => last = Some(LinkError::Listen { endpoint, text }),
        }
    }
    let text = "no free port".to_owned();
    Err(last.unwrap_or(LinkError::Listen { endpoint: asked.to_owned(), text }))
}

/// A session that connects within a time, and again for ever once it was connected.
pub(super) fn connected(
    endpoint: &str,
    patience: Patience,
    rules: &Rules,
    within: Duration,
) -> Result<zenoh::Session, LinkError> {
    let endpoints = [endpoint.to_owned()];
    // None at all would be taken for no limit.
    let within = within.max(Duration::from_millis(1));
    let mut settings = transport::client(&endpoints, patience, within.as_millis() as u64);
    settings.extend(rules.iter().cloned());
    let (endpoint, seconds) = (endpoint.to_owned(), within.as_secs_f64());
    open(&settings).map_err(|said| {
        // The transport says no more of it than that it is so.
        let text = if said.contains(UNABLE) { look(&endpoint) } else { said };
        LinkError::Connect { endpoint, seconds, text }
    })
}

/// Why there is no link to an endpoint, as far as a look at the place tells.
fn look(endpoint: &str) -> String {
    let place = endpoint.split_once('/').map_or(endpoint, |(_, place)| place);
    let place = place.split(['?', '#']).next().unwrap_or_default();
    let addresses = match place.to_socket_addrs() {
        Ok(addresses) => addresses,
        Err(error) => return format!("its address is not found: {error}"),
    };
    let mut last = "it has no address".to_owned();
    for address in addresses {
        last = match TcpStream::connect_timeout(&address, LOOK) {
            Ok(_) => {
                return "somebody listens there who makes no such link: no coordinator or router, \
                        one that hangs or is too far away for this time, or one with TLS where \
                        none is asked for (tls/ and tcp/)"
                    .to_owned();
            }
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => {
                "nobody listens there".to_owned()
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => {
                "nothing comes back from there: another address, or a firewall between".to_owned()
            }
            Err(error) => error.to_string(),
        };
    }
    last
}

/// Opens a session with these settings.
fn open(settings: &[(&'static str, String)]) -> Result<zenoh::Session, String> {
    let mut config = zenoh::Config::default();
    for (path, value) in settings {
        config
            .insert_json5(path, value)
            .map_err(|e| transport::plain(&format!("{path} = {value}: {e}")))?;
    }
    zenoh::open(config).wait().map_err(|e| transport::plain(&e.to_string()))
}

/// A port 0 becomes a free one.
fn concrete(asked: &str) -> Result<String, LinkError> {
    let Some(host) = asked.strip_suffix(":0") else {
        return Ok(asked.to_owned());
    };
    let failed =
        |e: std::io::Error| LinkError::Listen { endpoint: asked.to_owned(), text: e.to_string() };
    let address = host.split_once('/').map_or(host, |(_, address)| address);
    let probe = TcpListener::bind(format!("{address}:0")).map_err(failed)?;
    Ok(format!("{host}:{}", probe.local_addr().map_err(failed)?.port()))
}

/// Questions and signs of life go into the queue, or, if it is full, are dropped: the asker asks
/// again. A callback that waits would stop the whole link.
fn declare(
    session: &zenoh::Session,
    coordinator: &WorkerId,
    inputs: &SyncSender<PoolInput>,
) -> Result<Queryable<()>, String> {
    let queue = inputs.clone();
    let queryable = session
        .declare_queryable(keys::worker_rpcs(coordinator))
        .callback(move |query| match queue.try_send(PoolInput::Question(query)) {
            Ok(()) | Err(TrySendError::Disconnected(_)) => {}
            Err(TrySendError::Full(_)) => tracing::warn!("the queue is full: question dropped"),
        })
        .wait()
        .map_err(|e| e.to_string())?;
    let queue = inputs.clone();
    session
        .liveliness()
        .declare_subscriber(keys::workers_live(coordinator))
        .history(true)
        .callback(move |sample| {
            let Some((name, session)) = keys::parse_live(sample.key_expr().as_str()) else {
                return;
            };
            let up = sample.kind() == SampleKind::Put;
            // A lost sign of life costs time, never a result: the lease runs out instead.
            let _full = queue.try_send(PoolInput::Link { name, session, up });
        })
        .background()
        .wait()
        .map_err(|e| e.to_string())?;
    Ok(queryable)
}
