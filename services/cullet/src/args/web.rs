//! Where a page is served.

use std::net::SocketAddr;

/// An address for browsers: `HOST:PORT` of this machine alone, or `tls/HOST:PORT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WebAddress {
    pub(crate) address: SocketAddr,
    /// Whether watchers show certificates there.
    pub(crate) tls: bool,
}

impl WebAddress {
    /// Reads an address; one that other machines reach without TLS is none.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (place, tls) = match text.strip_prefix("tls/") {
            Some(place) => (place, true),
            None => (text, false),
        };
        let place = place
            .strip_prefix("localhost:")
            .map_or_else(|| place.to_owned(), |port| format!("127.0.0.1:{port}"));
        let address: SocketAddr = place.parse().map_err(|_| {
            "it is an IP address with a port, such as 127.0.0.1:8080 or tls/192.168.1.10:8443"
                .to_owned()
        })?;
        if !tls && !address.ip().to_canonical().is_loopback() {
            let port = address.port();
            return Err(format!(
                "other machines can reach this address, and the page would be for whoever asks: \
                 give tls/{address} with --tls and --roles, or an address of this machine alone, \
                 such as 127.0.0.1:{port} (reached from another machine through ssh -L)"
            ));
        }
        Ok(Self { address, tls })
    }
}

/// Reads an address.
pub(crate) fn read_address(text: &str) -> Result<SocketAddr, String> {
    let wanted = |_| "it is an IP address with a port, such as 127.0.0.1:8765".to_owned();
    text.parse().map_err(wanted)
}

/// Reads an address of this machine alone.
pub(crate) fn own_address(text: &str) -> Result<SocketAddr, String> {
    let place = text.strip_prefix("localhost:").map(|port| format!("127.0.0.1:{port}"));
    let address = read_address(place.as_deref().unwrap_or(text))?;
    if address.ip().to_canonical().is_loopback() {
        return Ok(address);
    }
    let port = address.port();
    Err(format!(
        "other machines can reach this address, and the run would be for whoever asks: give one \
         of this machine alone, such as 127.0.0.1:{port} (reached from another machine through \
         ssh -L)"
    ))
}

#[cfg(test)]
mod tests {
    use super::{WebAddress, own_address};

    #[test]
    fn a_run_is_served_on_this_machine_alone() {
        let read = |text: &str| own_address(text).map(|address| address.to_string());
        assert_eq!(read("localhost:0"), Ok("127.0.0.1:0".to_owned()));
        assert_eq!(read("[::1]:80"), Ok("[::1]:80".to_owned()));
        for open in ["0.0.0.0:80", "[::]:80", "192.168.1.10:80"] {
            let why = read(open).expect_err("it is refused");
            assert!(why.contains("whoever asks") && why.contains("127.0.0.1:80"), "{why}");
        }
        assert!(read("tls/127.0.0.1:80").is_err() && read("8765").is_err());
    }

    #[test]
    fn without_tls_a_page_is_for_this_machine_alone() {
        let read = |text: &str| WebAddress::parse(text).map(|it| (it.address.to_string(), it.tls));
        assert_eq!(read("127.0.0.1:80"), Ok(("127.0.0.1:80".to_owned(), false)));
        assert_eq!(read("localhost:80"), Ok(("127.0.0.1:80".to_owned(), false)));
        assert_eq!(read("[::1]:80"), Ok(("[::1]:80".to_owned(), false)));
        assert_eq!(read("tls/0.0.0.0:80"), Ok(("0.0.0.0:80".to_owned(), true)));
        for open in ["0.0.0.0:80", "[::]:80", "192.168.1.10:80"] {
            let why = read(open).expect_err("it is refused");
            assert!(why.contains(&format!("tls/{open}")) && why.contains("127.0.0.1:80"), "{why}");
        }
        assert!(read("example:80").is_err() && read("127.0.0.1").is_err() && read("tls/").is_err());
    }
}
