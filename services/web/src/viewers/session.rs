//! One viewer's connection.

use super::protocol;
use super::queue::{ClientQueue, NextFrame};
use super::stream::SharedStream;
use crate::headers::is_this_machine;
use axum::http::header::{HeaderName, ORIGIN, SEC_WEBSOCKET_PROTOCOL};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri};
use futures_util::{Sink, SinkExt, StreamExt};
use protocol::{Request, SUBPROTOCOLS};
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::time::{MissedTickBehavior, interval, timeout};
use tokio_tungstenite::{WebSocketStream, accept_hdr_async_with_config};
use tungstenite::handshake::server::{ErrorResponse, Request as Handshake, Response};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message};

/// Longest wait for a viewer's handshake.
const HEAD: Duration = Duration::from_secs(5);
/// Between two looks at the time, which goes on also where no message comes.
const TICK: Duration = Duration::from_millis(50);
/// Longest text of a viewer \[bytes\]: it subscribes some hundred channels at once.
const MOST_TEXT: usize = 1 << 20;
/// Pages that may watch beside those of this machine: the two viewers as they are served, and as
/// programs.
const VIEWERS: [&str; 3] =
    ["https://app.foxglove.dev", "https://lichtblick-suite.github.io", "file://"];
/// Name of the warning that messages were left out.
const SLOW: &str = "slow";

/// A viewer's place among the others, which is free again when this goes, however that comes.
struct ViewerSeat {
    shared: Arc<SharedStream>,
    client: u64,
}

impl Drop for ViewerSeat {
    fn drop(&mut self) {
        self.shared.state().leave(self.client);
    }
}

/// Speaks with a viewer until one of the two ends it, or this is dropped.
pub(super) async fn talk<S: AsyncRead + AsyncWrite + Unpin>(stream: S, shared: Arc<SharedStream>) {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MOST_TEXT))
        .max_frame_size(Some(MOST_TEXT));
    let greet = accept_hdr_async_with_config(stream, handshake, Some(config));
    let mut socket = match timeout(HEAD, greet).await {
        Ok(Ok(socket)) => socket,
        Ok(Err(error)) => return tracing::debug!("a viewer: {error}"),
        Err(_) => return,
    };
    let joined = shared.state().join();
    let Some((client, queue)) = joined else {
        let text = protocol::warning("full", "there are too many viewers already");
        let _gone = socket.send(Message::text(text)).await;
        let _gone = socket.close(None).await;
        return;
    };
    let seat = ViewerSeat { shared, client };
    if let Err(error) = exchange(&mut socket, &queue, &seat.shared).await {
        tracing::debug!("a viewer: {error}");
    }
}

async fn exchange<S: AsyncRead + AsyncWrite + Unpin>(
    socket: &mut WebSocketStream<S>,
    queue: &ClientQueue,
    shared: &SharedStream,
) -> Result<(), Error> {
    let (mut sender, mut receiver) = socket.split();
    // Both at once: what a viewer asks for is heard while it takes what was sent before.
    let hear = async {
        while let Some(message) = receiver.next().await {
            match message? {
                Message::Text(text) => answer(&text, queue, shared),
                Message::Close(_) => break,
                _ => {}
            }
        }
        Ok::<(), Error>(())
    };
    tokio::select! {
        heard = hear => heard,
        sent = send(&mut sender, queue, shared) => sent,
    }
}

/// Sends what waits, until the server ends.
async fn send(
    sender: &mut (impl Sink<Message, Error = Error> + Unpin),
    queue: &ClientQueue,
    shared: &SharedStream,
) -> Result<(), Error> {
    let mut tick = interval(TICK);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut told: Option<u64> = None;
    loop {
        let next = tokio::select! {
            biased;
            next = queue.next() => next,
            _ = tick.tick() => {
                let now = shared.state().time;
                // Where messages wait, the time is theirs.
                if queue.is_empty() && told.is_none_or(|told| told < now) {
                    told = Some(now);
                    sender.send(Message::binary(protocol::time(now))).await?;
                }
                continue;
            }
        };
        match next {
            NextFrame::Text(text) => sender.send(Message::text(text)).await?,
            NextFrame::Run(text) => {
                // A new run begins at zero; within one, no time is before another.
                told = None;
                sender.send(Message::text(text)).await?;
            }
            NextFrame::LeftOut(count) => {
                let text = format!("this viewer is too slow: {count} messages were left out");
                sender.send(Message::text(protocol::warning(SLOW, &text))).await?;
            }
            NextFrame::Message { subscription, time, payload } => {
                if told.is_none_or(|told| told < time) {
                    told = Some(time);
                    sender.feed(Message::binary(protocol::time(time))).await?;
                }
                let frame = protocol::message(subscription, time, &payload);
                sender.send(Message::binary(frame)).await?;
            }
            NextFrame::Close => {
                sender.close().await?;
                // The viewer closes too: until then what was sent may still be on its way.
                return std::future::pending().await;
            }
        }
    }
}

fn answer(text: &str, queue: &ClientQueue, shared: &SharedStream) {
    let wrong = |id: &str, why: &str| queue.warn(protocol::warning(id, why));
    match serde_json::from_str(text) {
        Ok(Request::Subscribe { subscriptions }) => {
            for asked in subscriptions {
                let done = shared.state().subscribe(queue, asked.id, asked.channel_id);
                if let Err(why) = done {
                    wrong("subscribe", &why);
                }
            }
        }
        Ok(Request::Unsubscribe { subscription_ids }) => {
            queue.unsubscribe(&subscription_ids);
        }
        Ok(Request::Other) => wrong("read-only", "a run can only be watched"),
        Err(error) => wrong("request", &format!("this is no request: {error}")),
    }
}

/// Takes a viewer that speaks the protocol, and comes from where it may.
#[allow(clippy::result_large_err, reason = "the library says what is returned")]
fn handshake(asked: &Handshake, mut answer: Response) -> Result<Response, ErrorResponse> {
    let no = |status: StatusCode, why: String| {
        let mut response = ErrorResponse::new(Some(why));
        *response.status_mut() = status;
        response
    };
    let headers = asked.headers();
    if !is_this_machine(headers) {
        let why = "a run is shown on this machine alone\n".to_owned();
        return Err(no(StatusCode::MISDIRECTED_REQUEST, why));
    }
    if let Some(origin) = foreign(headers) {
        let why = format!("pages from {origin} may not watch\n");
        return Err(no(StatusCode::FORBIDDEN, why));
    }
    let Some(chosen) = chosen(headers) else {
        let known = SUBPROTOCOLS.join(" or ");
        let why = format!("ask for the subprotocol {known}\n");
        return Err(no(StatusCode::BAD_REQUEST, why));
    };
    answer.headers_mut().insert(SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(chosen));
    Ok(answer)
}

/// The first of the names of the protocol that a viewer asks for.
fn chosen(headers: &HeaderMap) -> Option<&'static str> {
    let asked = |header: HeaderName| headers.get_all(header).into_iter();
    let lists = asked(SEC_WEBSOCKET_PROTOCOL).filter_map(|list| list.to_str().ok());
    let names: Vec<&str> = lists.flat_map(|list| list.split(',')).map(str::trim).collect();
    SUBPROTOCOLS.into_iter().find(|known| names.contains(known))
}

/// The origin of a page that may not watch. Programs other than browsers have none; any page could
/// otherwise read a run, for browsers let all pages connect.
fn foreign(headers: &HeaderMap) -> Option<String> {
    let may = |origin: &str| {
        let host = origin.parse::<Uri>().ok().and_then(|uri| uri.host().map(str::to_owned));
        let host = host.map(|host| host.trim_matches(['[', ']']).to_owned());
        let here = |host: String| {
            host.eq_ignore_ascii_case("localhost")
                || host.parse::<IpAddr>().is_ok_and(|address| address.to_canonical().is_loopback())
        };
        VIEWERS.contains(&origin) || host.is_some_and(here)
    };
    let mut origins = headers.get_all(ORIGIN).into_iter();
    let strange = origins.find(|origin| !origin.to_str().is_ok_and(may))?;
    Some(String::from_utf8_lossy(strange.as_bytes()).escape_debug().to_string())
}

#[cfg(test)]
mod tests {
    use super::{HeaderMap, HeaderValue, ORIGIN, SEC_WEBSOCKET_PROTOCOL, chosen, foreign};

    #[test]
    fn only_viewers_and_pages_of_this_machine_watch() {
        let refused = |origin: &str| {
            let value = HeaderValue::from_str(origin).expect("a header");
            foreign(&HeaderMap::from_iter([(ORIGIN, value)])).is_some()
        };
        assert!(foreign(&HeaderMap::new()).is_none());
        let good = ["http://localhost:8080", "http://127.0.0.1", "http://[::1]:80"];
        for origin in good.into_iter().chain(super::VIEWERS) {
            assert!(!refused(origin), "{origin}");
        }
        let bad = ["null", "https://evil.example", "http://localhost.evil.example", "", "http://1"];
        for origin in bad {
            assert!(refused(origin), "{origin}");
        }
    }

    #[test]
    fn both_names_of_the_protocol_are_taken() {
        let choose = |asked: &'static str| {
            let value = HeaderValue::from_static(asked);
            chosen(&HeaderMap::from_iter([(SEC_WEBSOCKET_PROTOCOL, value)]))
        };
        assert_eq!(choose("foxglove.websocket.v1"), Some("foxglove.websocket.v1"));
        assert_eq!(choose("x, foxglove.websocket.v1,foxglove.sdk.v1"), Some("foxglove.sdk.v1"));
        assert_eq!(choose("foxglove.websocket.v2"), None);
        assert_eq!(chosen(&HeaderMap::new()), None);
    }
}
