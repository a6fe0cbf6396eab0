//! From Zenoh's configuration to the two ends of a TLS session.

use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::version::TLS13;
use rustls::{ClientConfig, RootCertStore, ServerConfig};
use std::path::Path;
use std::sync::Arc;
use zenoh_link_commons::tcp::TcpSocketConfig;
use zenoh_link_commons::tls::config::{
    TLS_CLOSE_LINK_ON_EXPIRATION, TLS_CONNECT_CERTIFICATE_FILE, TLS_CONNECT_PRIVATE_KEY_FILE,
    TLS_ENABLE_MTLS, TLS_LISTEN_CERTIFICATE_FILE, TLS_LISTEN_PRIVATE_KEY_FILE,
    TLS_ROOT_CA_CERTIFICATE_FILE, TLS_VERIFY_NAME_ON_CONNECT,
};
use zenoh_link_commons::{
    BIND_INTERFACE, BIND_SOCKET, ConfigurationInspector, TCP_SO_RCV_BUF, TCP_SO_SND_BUF, parse_dscp,
};
use zenoh_protocol::core::endpoint::Config;
use zenoh_protocol::core::parameters;
use zenoh_result::{ZResult, bail, zerror};

/// Writes Zenoh's configuration into the parameters of an endpoint.
#[derive(Clone, Copy, Debug, Default)]
pub struct TlsConfigurator;

impl ConfigurationInspector<zenoh_config::Config> for TlsConfigurator {
    fn inspect_config(&self, config: &zenoh_config::Config) -> ZResult<String> {
        let tls = config.transport().link().tls();
        let inline = [
            ("root_ca_certificate_base64", tls.root_ca_certificate_base64()),
            ("listen_private_key_base64", tls.listen_private_key_base64()),
            ("listen_certificate_base64", tls.listen_certificate_base64()),
            ("connect_private_key_base64", tls.connect_private_key_base64()),
            ("connect_certificate_base64", tls.connect_certificate_base64()),
        ];
        if let Some((name, _)) = inline.iter().find(|(_, value)| value.is_some()) {
            bail!("transport/link/tls/{name} is not supported: name a file");
        }
        let texts = [
            (TLS_ROOT_CA_CERTIFICATE_FILE, tls.root_ca_certificate().clone()),
            (TLS_LISTEN_PRIVATE_KEY_FILE, tls.listen_private_key().clone()),
            (TLS_LISTEN_CERTIFICATE_FILE, tls.listen_certificate().clone()),
            (TLS_CONNECT_PRIVATE_KEY_FILE, tls.connect_private_key().clone()),
            (TLS_CONNECT_CERTIFICATE_FILE, tls.connect_certificate().clone()),
            (TLS_ENABLE_MTLS, tls.enable_mtls().map(|on| on.to_string())),
            (TLS_VERIFY_NAME_ON_CONNECT, tls.verify_name_on_connect().map(|on| on.to_string())),
            (TLS_CLOSE_LINK_ON_EXPIRATION, tls.close_link_on_expiration().map(|on| on.to_string())),
            (TCP_SO_RCV_BUF, tls.so_rcvbuf().map(|size| size.to_string())),
            (TCP_SO_SND_BUF, tls.so_sndbuf().map(|size| size.to_string())),
        ];
        let set = texts.iter().filter_map(|(name, value)| Some((*name, value.as_deref()?)));
        Ok(parameters::from_iter(set))
    }
}

/// Should a link end when the certificate of its far end does?
pub(crate) fn ends_with_certificate(config: &Config<'_>) -> ZResult<bool> {
    flag(config, TLS_CLOSE_LINK_ON_EXPIRATION, false)
}

/// The end that accepts connections, and takes only certificates of its authority.
pub(crate) fn server(config: &Config<'_>) -> ZResult<Arc<ServerConfig>> {
    mutual(config)?;
    let (chain, key) = identity(config, TLS_LISTEN_CERTIFICATE_FILE, TLS_LISTEN_PRIVATE_KEY_FILE)?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let roots = Arc::new(authority(config)?);
    let verifier =
        WebPkiClientVerifier::builder_with_provider(roots, Arc::clone(&provider)).build()?;
    let server = ServerConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&TLS13])?
        .with_client_cert_verifier(verifier)
        .with_single_cert(chain, key)?;
    Ok(Arc::new(server))
}

/// The end that connects, and trusts only certificates of its authority for the host it asked for.
pub(crate) fn client(config: &Config<'_>) -> ZResult<Arc<ClientConfig>> {
    mutual(config)?;
    if !flag(config, TLS_VERIFY_NAME_ON_CONNECT, true)? {
        bail!("{TLS_VERIFY_NAME_ON_CONNECT}=false is not supported: a host must show its name");
    }
    let (chain, key) =
        identity(config, TLS_CONNECT_CERTIFICATE_FILE, TLS_CONNECT_PRIVATE_KEY_FILE)?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let client = ClientConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&TLS13])?
        .with_root_certificates(authority(config)?)
        .with_client_auth_cert(chain, key)?;
    Ok(Arc::new(client))
}

/// Options of the socket below.
pub(crate) fn sockets<'a>(config: &'a Config<'_>) -> ZResult<TcpSocketConfig<'a>> {
    if config.get(BIND_SOCKET).is_some() {
        bail!("{BIND_SOCKET} is not supported on TLS links");
    }
    let size = |name: &str| -> ZResult<Option<u32>> {
        let parse = |text: &str| {
            text.parse::<u32>().map_err(|error| zerror!("{name}={text:?}: {error}").into())
        };
        config.get(name).map(parse).transpose()
    };
    let (send, receive) = (size(TCP_SO_SND_BUF)?, size(TCP_SO_RCV_BUF)?);
    let interface = config.get(BIND_INTERFACE);
    Ok(TcpSocketConfig::new(send, receive, interface, None, parse_dscp(config)?))
}

fn mutual(config: &Config<'_>) -> ZResult<()> {
    if !flag(config, TLS_ENABLE_MTLS, false)? {
        bail!("{TLS_ENABLE_MTLS}=false is not supported: both ends must show a certificate");
    }
    Ok(())
}

fn flag(config: &Config<'_>, name: &str, default: bool) -> ZResult<bool> {
    let Some(text) = config.get(name) else { return Ok(default) };
    Ok(text.parse().map_err(|_| zerror!("{name}={text:?} is neither true nor false"))?)
}

/// The file that a parameter names.
fn file<'a>(config: &'a Config<'_>, name: &str) -> ZResult<&'a Path> {
    let path = config.get(name).ok_or_else(|| zerror!("{name} is missing"))?;
    Ok(Path::new(path))
}

fn certificates(path: &Path) -> ZResult<Vec<CertificateDer<'static>>> {
    let wrong = |error| zerror!("{}: {error}", path.display());
    let read = CertificateDer::pem_file_iter(path).map_err(wrong)?;
    let chain = read.collect::<Result<Vec<_>, _>>().map_err(wrong)?;
    if chain.is_empty() {
        bail!("{}: no certificate is in it", path.display());
    }
    Ok(chain)
}

fn identity(
    config: &Config<'_>,
    certificate: &str,
    key: &str,
) -> ZResult<(Vec<CertificateDer<'static>>, PrivateKeyDer<'static>)> {
    let chain = certificates(file(config, certificate)?)?;
    let path = file(config, key)?;
    let key = PrivateKeyDer::from_pem_file(path)
        .map_err(|error| zerror!("{}: {error}", path.display()))?;
    Ok((chain, key))
}

fn authority(config: &Config<'_>) -> ZResult<RootCertStore> {
    let path = file(config, TLS_ROOT_CA_CERTIFICATE_FILE)?;
    let mut roots = RootCertStore::empty();
    for certificate in certificates(path)? {
        roots.add(certificate).map_err(|error| zerror!("{}: {error}", path.display()))?;
    }
    Ok(roots)
}
