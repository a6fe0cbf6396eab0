//! Connecting and accepting.

use crate::config;
use crate::link::Link;
use async_trait::async_trait;
use rustls::pki_types::ServerName;
use std::collections::VecDeque;
use std::fmt;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream, lookup_host};
use tokio::task::AbortHandle;
use tokio::time::{sleep, timeout};
use tokio_rustls::{TlsAcceptor, TlsConnector, TlsStream};
use zenoh_link_commons::tcp::get_tcp_addrs;
use zenoh_link_commons::{
    LinkManagerUnicastTrait, LinkUnicast, ListenersUnicastIP, NewLinkChannelSender,
};
use zenoh_protocol::core::endpoint::Address;
use zenoh_protocol::core::{EndPoint, Locator};
use zenoh_result::{ZResult, zerror};
use zenoh_runtime::ZRuntime;

/// Longest handshake.
const HANDSHAKE: Duration = Duration::from_secs(10);
/// Most handshakes at once: a stranger who never ends any takes no more than these.
const HANDSHAKES: usize = 256;
/// Wait after a connection could not be accepted, as where descriptors are short.
const PAUSE: Duration = Duration::from_millis(100);

/// Makes links and listens for them.
pub struct LinkManagerUnicastTls {
    links: NewLinkChannelSender,
    listeners: ListenersUnicastIP,
}

impl fmt::Debug for LinkManagerUnicastTls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LinkManagerUnicastTls").finish_non_exhaustive()
    }
}

impl LinkManagerUnicastTls {
    /// New links of listeners go to `links`.
    pub fn new(links: NewLinkChannelSender) -> Self {
        Self { links, listeners: ListenersUnicastIP::new() }
    }
}

/// The host of an address `HOST:PORT`.
fn host<'a>(address: &'a Address<'_>) -> ZResult<&'a str> {
    let (host, _) = address
        .as_str()
        .rsplit_once(':')
        .ok_or_else(|| zerror!("{address} is no address HOST:PORT"))?;
    Ok(host)
}

async fn resolve(address: &Address<'_>) -> ZResult<SocketAddr> {
    let first = lookup_host(address.as_str()).await?.next();
    Ok(first.ok_or_else(|| zerror!("{address} has no address"))?)
}

#[async_trait]
impl LinkManagerUnicastTrait for LinkManagerUnicastTls {
    async fn new_link(&self, endpoint: EndPoint) -> ZResult<LinkUnicast> {
        let (address, settings) = (endpoint.address(), endpoint.config());
        let name = ServerName::try_from(host(&address)?.trim_matches(['[', ']']))
            .map_err(|error| zerror!("{address}: {error}"))?
            .to_owned();
        let connector = TlsConnector::from(config::client(&settings)?);
        let sockets = config::sockets(&settings)?;
        let expires = config::ends_with_certificate(&settings)?;
        let places = get_tcp_addrs(endpoint.address()).await?;
        let (socket, ..) = sockets.new_link_first_reachable(places).await?;
        let stream = timeout(HANDSHAKE, connector.connect(name, socket))
            .await
            .map_err(|_| zerror!("{address}: no handshake within {HANDSHAKE:?}"))?
            .map_err(|error| zerror!("{address}: {error}"))?;
        Ok(LinkUnicast::from(Link::establish(TlsStream::Client(stream), expires)?))
    }

    async fn new_listener(&self, endpoint: EndPoint) -> ZResult<Locator> {
        let (address, settings) = (endpoint.address(), endpoint.config());
        let acceptor = TlsAcceptor::from(config::server(&settings)?);
        let expires = config::ends_with_certificate(&settings)?;
        let place = resolve(&address).await?;
        let (listener, place) = config::sockets(&settings)?
            .new_listener(&place)
            .map_err(|error| zerror!("cannot listen on {address}: {error}"))?;
        let host = host(&address)?;
        let at = format!("{host}:{}", place.port());
        let locator = Locator::new(endpoint.protocol(), at, endpoint.metadata())?;
        let open = EndPoint::new(
            locator.protocol(),
            locator.address(),
            locator.metadata(),
            endpoint.config(),
        )?;
        let token = self.listeners.token.child_token();
        let (links, over) = (self.links.clone(), token.clone());
        let task = async move {
            tokio::select! {
                () = over.cancelled() => {}
                () = accept(listener, acceptor, links, expires) => {}
            }
            Ok(())
        };
        self.listeners.add_listener(open, place, task, token).await?;
        Ok(locator)
    }

    async fn del_listener(&self, endpoint: &EndPoint) -> ZResult<()> {
        let place = resolve(&endpoint.address()).await?;
        self.listeners.del_listener(place).await
    }

    async fn get_listeners(&self) -> Vec<EndPoint> {
        self.listeners.get_endpoints()
    }

    async fn get_locators(&self) -> Vec<Locator> {
        self.listeners.get_locators()
    }

    async fn get_locators_noloopback(&self) -> Vec<Locator> {
        self.listeners.get_locators_noloopback()
    }
}

/// Accepts connections for ever. Handshakes run beside each other, so that who does not end one
/// keeps nobody waiting; where there are too many the oldest, which has had its time, makes room.
async fn accept(
    listener: TcpListener,
    acceptor: TlsAcceptor,
    links: NewLinkChannelSender,
    expires: bool,
) {
    let mut greetings = VecDeque::<AbortHandle>::new();
    loop {
        let (socket, from) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!("cannot accept a connection: {error}");
                greetings.pop_front().iter().for_each(AbortHandle::abort);
                sleep(PAUSE).await;
                continue;
            }
        };
        greetings.retain(|greeting| !greeting.is_finished());
        if greetings.len() >= HANDSHAKES {
            greetings.pop_front().iter().for_each(AbortHandle::abort);
        }
        let (acceptor, links) = (acceptor.clone(), links.clone());
        let greeting = ZRuntime::Acceptor.spawn(greet(socket, acceptor, expires));
        greetings.push_back(greeting.abort_handle());
        ZRuntime::Acceptor.spawn(async move {
            match greeting.await {
                Ok(Ok(link)) => {
                    if let Err(error) = links.send_async(link).await {
                        tracing::warn!("a link from {from} comes too late: {error}");
                    }
                }
                Ok(Err(error)) => tracing::debug!("no TLS link from {from}: {error}"),
                Err(_) => tracing::debug!("no TLS link from {from}: it made room for others"),
            }
        });
    }
}

async fn greet(socket: TcpStream, acceptor: TlsAcceptor, expires: bool) -> ZResult<LinkUnicast> {
    let stream = timeout(HANDSHAKE, acceptor.accept(socket))
        .await
        .map_err(|_| zerror!("no handshake within {HANDSHAKE:?}"))??;
    Ok(LinkUnicast::from(Link::establish(TlsStream::Server(stream), expires)?))
}
