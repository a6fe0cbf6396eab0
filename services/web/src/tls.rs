//! TLS for watchers on other machines: each shows a certificate of the farm's authority, and the
//! name in it decides whether it may watch.

use crate::stall::StallStream;
use cullet_proto::security::FILES;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::{RootCertStore, ServerConfig};
use std::fmt;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;
use x509_parser::prelude::{FromDer, X509Certificate};

/// What a certificate says of who shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shown {
    /// Its common name.
    pub(crate) name: String,
    /// Until when it is good \[s since 1970\].
    until: i64,
}

impl Shown {
    fn read(der: &[u8]) -> io::Result<Self> {
        let bad = |text: String| io::Error::new(io::ErrorKind::InvalidData, text);
        let (_, read) = X509Certificate::from_der(der).map_err(|error| bad(error.to_string()))?;
        let name = read.subject().iter_common_name().next().and_then(|name| name.as_str().ok());
        let name = name.ok_or_else(|| bad("a certificate without a common name".to_owned()))?;
        Ok(Self { name: name.to_owned(), until: read.validity().not_after.timestamp() })
    }

    /// How long it is good still.
    pub(crate) fn left(&self) -> Duration {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Duration::from_secs(u64::try_from(self.until).unwrap_or(0)).saturating_sub(now)
    }
}

/// Takes TLS connections of those who show a certificate.
pub(crate) struct Acceptor(TlsAcceptor);

impl fmt::Debug for Acceptor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Acceptor")
    }
}

impl Acceptor {
    /// With the identity in a folder: the authority that signs all, its own certificate, its key.
    pub(crate) fn new(folder: &Path) -> Result<Self, String> {
        let [ca, cert, key] = FILES.map(|name| folder.join(name));
        let at = |path: &Path, error: &dyn fmt::Display| format!("{}: {error}", path.display());
        let certificates = |path: &Path| -> Result<Vec<CertificateDer<'static>>, String> {
            let all = CertificateDer::pem_file_iter(path).map_err(|error| at(path, &error))?;
            all.collect::<Result<_, _>>().map_err(|error| at(path, &error))
        };
        let mut roots = RootCertStore::empty();
        for authority in certificates(&ca)? {
            roots.add(authority).map_err(|error| at(&ca, &error))?;
        }
        let secret = PrivateKeyDer::from_pem_file(&key).map_err(|error| at(&key, &error))?;
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let verifier =
            WebPkiClientVerifier::builder_with_provider(Arc::new(roots), Arc::clone(&provider))
                .build()
                .map_err(|error| at(&ca, &error))?;
        let mut config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(|error| error.to_string())?
            .with_client_cert_verifier(verifier)
            .with_single_cert(certificates(&cert)?, secret)
            .map_err(|error| at(&cert, &error))?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self(TlsAcceptor::from(Arc::new(config))))
    }

    pub(crate) async fn accept(
        &self,
        stream: StallStream,
    ) -> io::Result<(TlsStream<StallStream>, Shown)> {
        let stream = self.0.accept(stream).await?;
        let chain = stream.get_ref().1.peer_certificates();
        let first = chain.and_then(<[_]>::first).ok_or(io::ErrorKind::PermissionDenied)?;
        let shown = Shown::read(first)?;
        Ok((stream, shown))
    }
}
