//! What a browser is told beside an answer, and whether a question came to the right place.

use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, REFERRER_POLICY};
use axum::http::header::{X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use std::net::IpAddr;

/// From where a browser asks.
const SEC_FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// The page takes nothing but what comes from here, and is shown in no other page.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";
/// A report has its scripts and pictures in itself. It is shut off from the page: even a script
/// that got into it could ask for nothing.
pub(crate) const REPORT_POLICY: &str = "sandbox allow-scripts allow-downloads; \
    default-src 'none'; script-src 'unsafe-inline' blob:; style-src 'unsafe-inline'; \
    img-src data: blob:; connect-src data: blob:; worker-src blob:; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'none'";
/// The same of a drawing.
pub(crate) const DRAWING_POLICY: &str =
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'";

/// Tells the browser what holds for every answer.
pub(crate) fn guard(headers: &mut HeaderMap) {
    let all: [(HeaderName, &'static str); 6] = [
        (CACHE_CONTROL, "no-store"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ];
    for (name, value) in all {
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    }
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(POLICY));
}

/// Whether the host that was asked for is this machine by a name that no other machine has. A page
/// from elsewhere whose name was made to lead here is asked for by that name.
pub(crate) fn is_this_machine(headers: &HeaderMap) -> bool {
    let mut hosts = headers.get_all(HOST).into_iter();
    let (Some(host), None) = (hosts.next(), hosts.next()) else { return false };
    let Ok(host) = host.to_str() else { return false };
    let name = match host.strip_prefix('[') {
        Some(rest) => match rest.split_once(']') {
            Some((name, "")) => name,
            Some((name, port)) if port.strip_prefix(':').is_some_and(is_port) => name,
            _ => return false,
        },
        None => match host.split_once(':') {
            Some((name, port)) if is_port(port) => name,
            Some(_) => return false,
            None => host,
        },
    };
    name.eq_ignore_ascii_case("localhost")
        || name.parse::<IpAddr>().is_ok_and(|address| address.to_canonical().is_loopback())
}

/// Whether a page from elsewhere asks, as its browser says: for a file of a run in a frame or as a
/// picture, or by a link.
pub(crate) fn is_of_another_site(headers: &HeaderMap) -> bool {
    headers.get_all(SEC_FETCH_SITE).into_iter().any(|site| site == "cross-site")
}

fn is_port(text: &str) -> bool {
    text.parse::<u16>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::{HOST, HeaderMap, HeaderValue, is_this_machine};

    #[test]
    fn only_names_of_this_machine_are_this_machine() {
        let is = |hosts: &[&str]| {
            let mut headers = HeaderMap::new();
            for host in hosts {
                headers.append(HOST, HeaderValue::from_str(host).expect("a header"));
            }
            is_this_machine(&headers)
        };
        for good in ["127.0.0.1", "127.0.0.1:8080", "localhost:1", "LOCALHOST", "[::1]:8080"] {
            assert!(is(&[good]), "{good}");
        }
        let bad = [
            "evil.example",
            "evil.example:8080",
            "127.0.0.1.evil.example",
            "localhost.evil.example:8080",
            "10.0.0.5:8080",
            "[::1",
            "[::1]x",
            "[::1]:x",
            "[fe80::1]:80",
            "127.0.0.1:80:80",
            "",
            "0.0.0.0",
        ];
        for bad in bad {
            assert!(!is(&[bad]), "{bad}");
        }
        assert!(!is(&[]) && !is(&["localhost", "localhost"]));
    }
}
