//! One TLS connection as a link.

use crate::TLS_LOCATOR_PREFIX;
use async_trait::async_trait;
use rustls::pki_types::CertificateDer;
use std::fmt;
use std::io::{self, ErrorKind};
use std::net::{Shutdown, SocketAddr};
use std::os::fd::AsFd;
use std::sync::{Arc, Weak};
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt, ReadHalf, WriteHalf, split};
use tokio::net::TcpStream;
use tokio::sync::Mutex;
use tokio::time::timeout;
use tokio_rustls::TlsStream;
use tokio_util::sync::CancellationToken;
use x509_parser::prelude::{ASN1Time, FromDer, X509Certificate};
use zenoh_link_commons::tls::expiration::{LinkCertExpirationManager, LinkWithCertExpiration};
use zenoh_link_commons::{LinkAuthId, LinkUnicastTrait, get_ip_interface_names};
use zenoh_protocol::core::{Locator, Priority};
use zenoh_protocol::transport::BatchSize;
use zenoh_result::{ZResult, bail, zerror};

/// Longest wait for what a far end still has to take when a link ends.
const CLOSE: Duration = Duration::from_secs(1);

/// A connection with the certificates already exchanged.
pub(crate) struct Link {
    // `split` polls both halves of the session under one lock. The mutexes around the halves keep
    // a message whole where several tasks send.
    reader: Mutex<ReadHalf<TlsStream<TcpStream>>>,
    writer: Mutex<WriteHalf<TlsStream<TcpStream>>>,
    /// The socket below, to end it while the halves are in use.
    socket: std::net::TcpStream,
    /// Cancelled once the link has ended. A reader that fails sends an alert, and is then woken in
    /// the place of a writer that waits for the socket: nothing else would end that writer.
    over: CancellationToken,
    near: (SocketAddr, Locator),
    far: (SocketAddr, Locator),
    /// The common name in the certificate of the far end.
    identity: LinkAuthId,
    expiration: Option<LinkCertExpirationManager>,
}

/// What the certificates of the far end say.
struct FarEnd {
    name: Option<String>,
    /// When the first of them ends.
    until: ASN1Time,
}

impl FarEnd {
    fn read(chain: Option<&[CertificateDer<'_>]>) -> ZResult<Self> {
        let Some((leaf, others)) = chain.and_then(<[_]>::split_first) else {
            bail!("the far end shows no certificate");
        };
        let (_, leaf) = X509Certificate::from_der(leaf)?;
        let name = leaf.subject().iter_common_name().next().and_then(|name| name.as_str().ok());
        let mut until = leaf.validity().not_after;
        for other in others {
            let (_, other) = X509Certificate::from_der(other)?;
            until = until.min(other.validity().not_after);
        }
        Ok(Self { name: name.map(str::to_owned), until })
    }
}

impl Link {
    /// A link over an established session. `expires`: ends with the certificates of the far end.
    pub(crate) fn establish(
        stream: TlsStream<TcpStream>,
        expires: bool,
    ) -> ZResult<Arc<dyn LinkUnicastTrait>> {
        let (socket, session) = stream.get_ref();
        socket.set_nodelay(true)?;
        let far_end = FarEnd::read(session.peer_certificates())?;
        let place = |address: SocketAddr| {
            let locator = Locator::new(TLS_LOCATOR_PREFIX, address.to_string(), "")?;
            ZResult::Ok((address, locator))
        };
        let (near, far) = (place(socket.local_addr()?)?, place(socket.peer_addr()?)?);
        let handle = std::net::TcpStream::from(socket.as_fd().try_clone_to_owned()?);
        let (reader, writer) = split(stream);
        let link = Arc::<Self>::new_cyclic(|link: &Weak<Self>| Self {
            reader: Mutex::new(reader),
            writer: Mutex::new(writer),
            socket: handle,
            over: CancellationToken::new(),
            expiration: expires.then(|| {
                let until = far_end.until.to_datetime();
                let link: Weak<dyn LinkWithCertExpiration> = link.clone();
                LinkCertExpirationManager::new(link, near.0, far.0, TLS_LOCATOR_PREFIX, until)
            }),
            near,
            far,
            identity: LinkAuthId::Tls(far_end.name),
        });
        Ok(link)
    }

    /// What was written goes out first, as far as the far end takes it soon. Whoever still reads or
    /// writes then fails.
    async fn end(&self) -> ZResult<()> {
        let last = async { self.writer.lock().await.shutdown().await };
        let ended = timeout(CLOSE, self.unless_over(last)).await;
        self.over.cancel();
        // Fails where the far end has ended the connection already.
        self.socket.shutdown(Shutdown::Both).ok();
        match ended {
            Ok(ended) => Ok(ended?),
            Err(_) => bail!("{self}: the far end does not take the end of what was sent"),
        }
    }

    async fn unless_over<T>(&self, act: impl Future<Output = io::Result<T>>) -> io::Result<T> {
        let done = self.over.run_until_cancelled(act).await;
        done.unwrap_or_else(|| Err(io::Error::new(ErrorKind::NotConnected, "the link has ended")))
    }

    /// The outcome of reading. A session of which a record is missing or damaged cannot go on.
    fn read_with<T>(&self, read: io::Result<T>) -> ZResult<T> {
        read.map_err(|error| {
            self.over.cancel();
            self.failed("reading", &error)
        })
    }

    fn failed(&self, what: &str, error: &io::Error) -> zenoh_result::Error {
        tracing::trace!("{what} on the TLS link {self}: {error}");
        zerror!("{error}").into()
    }
}

#[async_trait]
impl LinkUnicastTrait for Link {
    async fn write(&self, buffer: &[u8], _: Option<Priority>) -> ZResult<usize> {
        let write = async {
            let mut writer = self.writer.lock().await;
            let length = writer.write(buffer).await?;
            writer.flush().await?;
            Ok(length)
        };
        self.unless_over(write).await.map_err(|error| self.failed("writing", &error))
    }

    async fn write_all(&self, buffer: &[u8], _: Option<Priority>) -> ZResult<()> {
        // Unflushed, the end of a message would wait in the session for the next one.
        let write = async {
            let mut writer = self.writer.lock().await;
            writer.write_all(buffer).await?;
            writer.flush().await
        };
        self.unless_over(write).await.map_err(|error| self.failed("writing", &error))
    }

    async fn read(&self, buffer: &mut [u8], _: Option<Priority>) -> ZResult<usize> {
        let read = async { self.reader.lock().await.read(buffer).await };
        self.read_with(self.unless_over(read).await)
    }

    async fn read_exact(&self, buffer: &mut [u8], _: Option<Priority>) -> ZResult<()> {
        let read = async { self.reader.lock().await.read_exact(buffer).await };
        self.read_with(self.unless_over(read).await.map(|_| ()))
    }

    async fn close(&self) -> ZResult<()> {
        let Some(expiration) = &self.expiration else { return self.end().await };
        if !expiration.set_closing() {
            // Its certificate has ended, and so is the link already.
            return expiration.wait_for_expiration_task().await;
        }
        expiration.cancel_expiration_task();
        let ended = self.end().await;
        expiration.wait_for_expiration_task().await?;
        ended
    }

    fn get_mtu(&self) -> BatchSize {
        BatchSize::MAX
    }

    fn get_src(&self) -> &Locator {
        &self.near.1
    }

    fn get_dst(&self) -> &Locator {
        &self.far.1
    }

    fn is_reliable(&self) -> bool {
        true
    }

    fn is_streamed(&self) -> bool {
        true
    }

    fn get_interface_names(&self) -> Vec<String> {
        get_ip_interface_names(&self.near.0)
    }

    fn get_auth_id(&self) -> &LinkAuthId {
        &self.identity
    }

    #[cfg(all(feature = "uring", target_os = "linux"))]
    fn get_fd(&self) -> ZResult<std::os::fd::RawFd> {
        bail!("a TLS link has no descriptor to read from")
    }
}

#[async_trait]
impl LinkWithCertExpiration for Link {
    async fn expire(&self) -> ZResult<()> {
        match &self.expiration {
            Some(expiration) if expiration.set_closing() => self.end().await,
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} => {}", self.near.0, self.far.0)
    }
}
