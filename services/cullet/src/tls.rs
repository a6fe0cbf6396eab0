//! Identities for a link, and why one is not taken. The transport says only that there is no link:
//! what a certificate lacks is found out here, by looking at it and by a handshake of our own.

use crate::exit::{CommandError, Exit};
use crate::shown::shown;
use cullet_pool::LinkError;
use cullet_proto::security::{self, Rules};
use rustls::pki_types::pem::{self, PemObject};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::{AlertDescription, CertificateError, ClientConfig, ClientConnection, RootCertStore};
use std::ffi::OsString;
use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use x509_parser::prelude::{FromDer, X509Certificate};

/// Longest wait for anything of the handshake.
const WAIT: Duration = Duration::from_secs(2);

/// What a certificate says.
#[derive(Debug)]
pub(crate) struct Certificate {
    /// Its common name.
    pub(crate) name: String,
    /// From when to when it is good \[s since 1970\].
    from: i64,
    until: i64,
}

/// How to connect, and as whom.
#[derive(Debug)]
pub(crate) struct LinkConfig {
    /// Settings of the transport.
    pub(crate) rules: Rules,
    /// As whom.
    pub(crate) name: String,
    /// What is shown.
    pub(crate) certificate: Option<Certificate>,
    folder: PathBuf,
}

impl Certificate {
    /// Reads the certificate in a folder, which must be good now.
    fn read(folder: &Path) -> Result<Self, CommandError> {
        let path = folder.join(security::FILES[1]);
        let wrong = |text: &str| wrong(&path, text);
        let der = CertificateDer::from_pem_file(&path).map_err(|e| wrong(&e.to_string()))?;
        let (_, read) = X509Certificate::from_der(&der).map_err(|e| wrong(&e.to_string()))?;
        let name = read.subject().iter_common_name().next().and_then(|name| name.as_str().ok());
        let name = name.ok_or_else(|| wrong("it has no common name"))?.to_owned();
        let span = read.validity();
        let said =
            Self { name, from: span.not_before.timestamp(), until: span.not_after.timestamp() };
        if said.left() <= 0 {
            return Err(wrong(&format!("the certificate expired on {}", span.not_after)));
        }
        if said.from > now() {
            return Err(wrong(&format!("the certificate is not valid before {}", span.not_before)));
        }
        Ok(said)
    }

    /// How long it is good still \[s\].
    pub(crate) fn left(&self) -> i64 {
        self.until - now()
    }
}

fn now() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() as i64)
}

/// A certificate with those that vouch for it, and its key.
type Identity = (Vec<CertificateDer<'static>>, PrivateKeyDer<'static>);

fn wrong(path: &Path, text: impl std::fmt::Display) -> CommandError {
    let name = path.display().to_string();
    CommandError::new(Exit::Usage, format!("{}: {text}", shown(&name))).at(name)
}

/// Reads the files of an identity. Of one that is not there, is no file, is empty, or is not what
/// its name says, the transport would only make no link.
fn read_identity(folder: &Path) -> Result<Identity, CommandError> {
    let [ca, cert, key] = security::FILES.map(|name| folder.join(name));
    if folder.is_file() {
        let names = security::FILES.join(", ");
        return Err(wrong(folder, format!("it is a file; --tls takes a folder with {names}")));
    }
    let read = |path: &Path, what: &str| -> Result<Vec<u8>, CommandError> {
        let known = std::fs::metadata(path).map_err(|error| CommandError::file(path, error))?;
        if known.is_dir() {
            return Err(wrong(path, format!("it is a folder, not a file with {what}")));
        }
        if !known.is_file() {
            return Err(wrong(path, format!("it is no file with {what}")));
        }
        let bytes = std::fs::read(path).map_err(|error| CommandError::file(path, error))?;
        match bytes.is_empty() {
            true => Err(wrong(path, format!("it is empty; there must be {what} in PEM in it"))),
            false => Ok(bytes),
        }
    };
    let bad = |path: &Path, what: &str, error: pem::Error| {
        let why = match error {
            pem::Error::NoItemsFound => format!("there is no {what} in PEM in it"),
            other => format!("it cannot be read as a {what} in PEM: {other}"),
        };
        wrong(path, why)
    };
    let certificates = |path: &Path| {
        let bytes = read(path, "a certificate")?;
        let all: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&bytes).collect();
        let all = all.and_then(|all| match all.is_empty() {
            true => Err(pem::Error::NoItemsFound),
            false => Ok(all),
        });
        all.map_err(|error| bad(path, "certificate", error))
    };
    let (_authorities, chain) = (certificates(&ca)?, certificates(&cert)?);
    let secret = PrivateKeyDer::from_pem_slice(&read(&key, "a private key")?);
    let secret = secret.map_err(|error| bad(&key, "private key", error))?;
    Ok((chain, secret))
}

/// Whether the key is that of the certificate.
fn fits(folder: &Path, (chain, secret): Identity) -> Result<(), CommandError> {
    let [_, cert, key] = security::FILES;
    let provider = rustls::crypto::ring::default_provider();
    let fits = rustls::sign::CertifiedKey::from_der(chain, secret, &provider);
    let not =
        |error| wrong(&folder.join(key), format!("it is no key of {cert} beside it: {error}"));
    fits.map(drop).map_err(not)
}

/// The link to an endpoint; `folder`: with the identity in it. Who asks is who was named, else who
/// the certificate names, else `other`.
pub(crate) fn link(
    folder: Option<&Path>,
    endpoint: &str,
    named: Option<&str>,
    other: &str,
) -> Result<LinkConfig, CommandError> {
    let certificate = match (folder, endpoint.starts_with("tls/")) {
        (None, false) => None,
        (None, true) => {
            return Err(CommandError::new(Exit::Usage, "a tls/ endpoint needs --tls DIR"));
        }
        (Some(_), false) => {
            let typed = |arg: OsString| arg.to_string_lossy().starts_with("--tls");
            let text = match std::env::args_os().any(typed) {
                true => "--tls needs an endpoint tls/HOST:PORT".to_owned(),
                false => format!("CULLET_TLS is set, and {endpoint} is no endpoint tls/HOST:PORT"),
            };
            return Err(CommandError::new(Exit::Usage, text));
        }
        (Some(folder), true) => {
            let identity = read_identity(folder)?;
            let certificate = Certificate::read(folder)?;
            fits(folder, identity)?;
            Some(certificate)
        }
    };
    let shown = certificate.as_ref().map(|certificate| certificate.name.as_str());
    let name = named.or(shown).unwrap_or(other).to_owned();
    let rules = folder.map(security::identity).unwrap_or_default();
    Ok(LinkConfig {
        rules,
        name,
        certificate,
        folder: folder.map(Path::to_owned).unwrap_or_default(),
    })
}

impl LinkConfig {
    pub(crate) fn is_tls(&self) -> bool {
        self.certificate.is_some()
    }

    /// Why there is no link or no answer, as far as it can be told.
    pub(crate) fn trouble(&self, error: &LinkError, endpoint: &str) -> CommandError {
        let why = match (error, &self.certificate) {
            (LinkError::Connect { .. }, Some(_)) => self.refusal(endpoint),
            (LinkError::Silent { .. }, Some(certificate)) => Some(format!(
                "either none is there, or {:?} may not ask: the certificate is of {:?}, and roles \
                 must name it among users or operators",
                self.name, certificate.name
            )),
            _ => None,
        };
        let exit = crate::exit::refused(error);
        why.map_or(exit, |why| {
            CommandError::new(Exit::Unreachable, format!("{error}: {why}")).at(endpoint)
        })
    }

    /// Why the other side and this one do not take each other's certificates; nothing if they do,
    /// or if nobody is there.
    pub(crate) fn refusal(&self, endpoint: &str) -> Option<String> {
        if !self.is_tls() {
            return None;
        }
        let place = endpoint.strip_prefix("tls/")?;
        let place = place.split(['?', '#']).next()?;
        let host = place.rsplit_once(':')?.0.trim_matches(['[', ']']);
        let error = handshake(&self.folder, place, host).err()?;
        let tls = error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>());
        tls.map(|error| self.words(error, host))
    }

    fn words(&self, error: &rustls::Error, host: &str) -> String {
        let ca = self.folder.join(security::FILES[0]);
        match error {
            rustls::Error::InvalidCertificate(why) => match why {
                CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
                    "its certificate has expired".to_owned()
                }
                CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
                    "its certificate is not valid yet".to_owned()
                }
                CertificateError::UnknownIssuer | CertificateError::BadSignature => {
                    format!("its certificate is not of the authority in {}", ca.display())
                }
                CertificateError::NotValidForName
                | CertificateError::NotValidForNameContext { .. } => {
                    format!("its certificate is not good for the host {host:?}")
                }
                other => format!("its certificate is not taken: {other}"),
            },
            rustls::Error::AlertReceived(alert) => match alert {
                AlertDescription::CertificateExpired => {
                    "it says that our certificate has expired or is not valid yet".to_owned()
                }
                AlertDescription::UnknownCA | AlertDescription::DecryptError => {
                    "it says that our certificate is not of its authority".to_owned()
                }
                other => format!("it does not take our certificate: {other:?}"),
            },
            other => format!("TLS: {other}"),
        }
    }
}

/// A handshake as the transport makes it. With TLS 1.3 a certificate of ours that is not taken is
/// told only after it: that is waited for.
fn handshake(folder: &Path, place: &str, host: &str) -> io::Result<()> {
    let [ca, cert, key] = security::FILES.map(|name| folder.join(name));
    let mut roots = RootCertStore::empty();
    for authority in CertificateDer::pem_file_iter(&ca).map_err(io::Error::other)? {
        roots.add(authority.map_err(io::Error::other)?).map_err(io::Error::other)?;
    }
    let chain: Result<Vec<_>, _> =
        CertificateDer::pem_file_iter(&cert).map_err(io::Error::other)?.collect();
    let key = PrivateKeyDer::from_pem_file(&key).map_err(io::Error::other)?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(io::Error::other)?
        .with_root_certificates(roots)
        .with_client_auth_cert(chain.map_err(io::Error::other)?, key)
        .map_err(io::Error::other)?;
    let name = ServerName::try_from(host.to_owned()).map_err(io::Error::other)?;
    let mut tls = ClientConnection::new(Arc::new(config), name).map_err(io::Error::other)?;
    let address = place.to_socket_addrs()?.next().ok_or(ErrorKind::NotFound)?;
    let mut socket = TcpStream::connect_timeout(&address, WAIT)?;
    socket.set_read_timeout(Some(WAIT))?;
    socket.set_write_timeout(Some(WAIT))?;
    while tls.is_handshaking() {
        tls.complete_io(&mut socket)?;
    }
    // Whatever comes now comes after our certificate was looked at.
    match tls.read_tls(&mut socket) {
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(()),
        Err(error) => Err(error),
        Ok(_) => tls.process_new_packets().map(|_| ()).map_err(io::Error::other),
    }
}
