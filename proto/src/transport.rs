//! How the two ends tune their transport, as pairs of path and JSON value: plain data, so that both
//! ends agree and this crate needs no transport.

use crate::chunks::MAX_MESSAGE;

/// Patience of a transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// A link that is silent this long is dead \[ms\].
    pub lease_ms: u64,
    /// A message that cannot be queued within this closes the link \[ms\]: it bounds how long a
    /// sender blocks; 1 MiB in it is the slowest link served.
    pub wait_before_close_ms: u64,
    /// First pause before connecting again \[ms\].
    pub retry_ms: u64,
    /// Longest pause before connecting again \[ms\].
    pub retry_max_ms: u64,
    /// A link that is not made within this is tried anew \[ms\]: what was sent into a hole is sent
    /// again ever more rarely, and a hole may heal at any time. A link with TLS takes four ways
    /// there and back: to connect, to shake hands, to begin, to open.
    pub open_ms: u64,
}

impl Patience {
    /// For real runs.
    #[must_use]
    pub const fn production() -> Self {
        Self {
            lease_ms: 5_000,
            wait_before_close_ms: 3_000,
            retry_ms: 200,
            retry_max_ms: 800,
            open_ms: 6_000,
        }
    }

    /// For tests.
    #[must_use]
    pub const fn test() -> Self {
        Self {
            lease_ms: 1_000,
            wait_before_close_ms: 1_000,
            retry_ms: 50,
            retry_max_ms: 200,
            open_ms: 1_000,
        }
    }
}

/// Settings of a worker that connects to `endpoints`, for ever.
#[must_use]
pub fn worker(endpoints: &[String], patience: Patience) -> Vec<(&'static str, String)> {
    let mut all = visitor(endpoints, patience);
    all.push(("connect/timeout_ms", "-1".into()));
    all.push(("connect/exit_on_failure", "false".into()));
    all
}

/// Settings of a client that connects to `endpoints`, or fails within `timeout_ms`.
#[must_use]
pub fn client(
    endpoints: &[String],
    patience: Patience,
    timeout_ms: u64,
) -> Vec<(&'static str, String)> {
    let mut all = visitor(endpoints, patience);
    all.push(("connect/timeout_ms", timeout_ms.to_string()));
    all.push(("connect/exit_on_failure", "true".into()));
    all
}

fn visitor(endpoints: &[String], patience: Patience) -> Vec<(&'static str, String)> {
    let mut all = common(patience);
    all.push(("mode", "\"client\"".into()));
    all.push(("connect/endpoints", list(endpoints)));
    all.push(("listen/endpoints", "[]".into()));
    let Patience { retry_ms, retry_max_ms, open_ms, .. } = patience;
    let retry = format!(
        "{{\"period_init_ms\":{retry_ms},\"period_max_ms\":{retry_max_ms},\
         \"period_increase_factor\":2}}"
    );
    all.push(("connect/retry", retry));
    all.push(("transport/unicast/open_timeout", open_ms.to_string()));
    all
}

/// Settings of a router, or of a coordinator that is one, that listens on `endpoint`.
#[must_use]
pub fn router(endpoint: &str, patience: Patience) -> Vec<(&'static str, String)> {
    let mut all = common(patience);
    all.push(("mode", "\"router\"".into()));
    all.push(("listen/endpoints", list(&[endpoint.to_owned()])));
    all.push(("listen/exit_on_failure", "true".into()));
    all
}

fn common(patience: Patience) -> Vec<(&'static str, String)> {
    let close_us = patience.wait_before_close_ms * 1_000;
    vec![
        ("scouting/multicast/enabled", "false".into()),
        // Nobody is scouted for: a router would wait half a second for whom it finds.
        ("scouting/delay", "0".into()),
        ("scouting/gossip/enabled", "false".into()),
        ("timestamping/enabled", "false".into()),
        ("adminspace/enabled", "false".into()),
        ("transport/link/tx/lease", patience.lease_ms.to_string()),
        (
            "transport/link/tx/queue/congestion_control/block/wait_before_close",
            close_us.to_string(),
        ),
        ("transport/link/rx/max_message_size", MAX_MESSAGE.to_string()),
    ]
}

/// What a transport says is wrong, without the places in its own source.
#[must_use]
pub fn plain(error: &str) -> String {
    let mut text = error.to_owned();
    while let Some(start) = text.find(" at /") {
        let Some(end) = text[start..].find(".rs:").map(|at| start + at + 4) else {
            break;
        };
        let digits = text[end..].bytes().take_while(u8::is_ascii_digit).count();
        let dot = usize::from(text[end + digits..].starts_with('.'));
        text.replace_range(start..end + digits + dot, "");
    }
    text
}

fn list(endpoints: &[String]) -> String {
    let quoted: Vec<_> = endpoints.iter().map(|e| format!("{e:?}")).collect();
    format!("[{}]", quoted.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_told_without_places_in_others_source() {
        let said = "no listener: [127.0.0.1:1: in use (os error 98) at /a/b-1.0/src/tcp.rs:61.] \
                    at /c/unicast.rs:338.";
        assert_eq!(plain(said), "no listener: [127.0.0.1:1: in use (os error 98)]");
        assert_eq!(plain("nobody is at /home"), "nobody is at /home");
    }

    #[test]
    fn endpoints_are_quoted() {
        let all = worker(&["tcp/127.0.0.1:1".into(), "a\"b".into()], Patience::test());
        let given = all.iter().find(|(path, _)| *path == "connect/endpoints");
        assert_eq!(given.map(|(_, v)| v.as_str()), Some(r#"["tcp/127.0.0.1:1","a\"b"]"#));
    }
}
