//! Messages of Foxglove's WebSocket protocol: texts as JSON, data in binary frames with numbers in
//! little endian (<https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>).

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::json;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Names of the protocol: that of Foxglove's SDK, and the one that it had before, by which older
/// versions of Lichtblick ask for the same.
pub(crate) const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// What the server says it does beside sending messages: it gives the time.
const CAPABILITIES: [&str; 1] = ["time"];
/// Longest text that tells of channels \[bytes\]; viewers refuse very long ones.
const BATCH: usize = 1 << 20;
/// A binary frame with a message.
const MESSAGE: u8 = 1;
/// A binary frame with the time.
const TIME: u8 = 2;
/// The level of a warning in a status.
const WARNING: u8 = 1;

/// A channel of a recording.
#[derive(Clone, Copy, Debug)]
pub struct StreamChannel<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// Name of its messages' type.
    pub schema_name: &'a str,
    /// That type, as a set of protobuf file descriptors.
    pub schema: &'a [u8],
}

/// A channel as viewers are told of it.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Advertised {
    pub(crate) id: u32,
    topic: String,
    encoding: &'static str,
    schema_name: String,
    /// In base64; one for all channels that have it.
    #[serde(serialize_with = "as_text")]
    schema: Arc<str>,
    schema_encoding: &'static str,
}

impl Advertised {
    /// A channel; `schemas`: those of the others.
    pub(crate) fn of(
        id: u32,
        channel: &StreamChannel<'_>,
        schemas: &mut BTreeSet<Arc<str>>,
    ) -> Self {
        let schema = STANDARD.encode(channel.schema);
        let known = schemas.get(&schema[..]).cloned();
        let schema = known.unwrap_or_else(|| Arc::from(schema));
        schemas.insert(Arc::clone(&schema));
        Self {
            id,
            topic: channel.topic.to_owned(),
            encoding: "protobuf",
            schema_name: channel.schema_name.to_owned(),
            schema,
            schema_encoding: "protobuf",
        }
    }

    /// About how long it is as a text \[bytes\].
    fn length(&self) -> usize {
        self.topic.len() + self.schema_name.len() + self.schema.len() + 128
    }
}

fn as_text<S: Serializer>(text: &Arc<str>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(text)
}

pub(crate) fn server_info(name: &str, session: &str) -> String {
    let name = format!("cullet: {name}");
    let metadata = json!({ "cullet": env!("CARGO_PKG_VERSION") });
    json!({ "op": "serverInfo", "name": name, "capabilities": CAPABILITIES, "metadata": metadata,
            "sessionId": session })
    .to_string()
}

/// Texts of about 1 MB at most that tell of channels.
pub(crate) fn advertise<'a>(channels: impl Iterator<Item = &'a Advertised>) -> Vec<String> {
    let said = |list: &[&Advertised]| json!({ "op": "advertise", "channels": list }).to_string();
    let (mut texts, mut list, mut length) = (Vec::new(), Vec::new(), 0);
    for channel in channels {
        if length + channel.length() > BATCH && !list.is_empty() {
            texts.push(said(&list));
            list.clear();
            length = 0;
        }
        length += channel.length();
        list.push(channel);
    }
    if !list.is_empty() {
        texts.push(said(&list));
    }
    texts
}

pub(crate) fn unadvertise(ids: &[u32]) -> String {
    json!({ "op": "unadvertise", "channelIds": ids }).to_string()
}

/// A warning; one with the same `id` takes the place of the one before.
pub(crate) fn warning(id: &str, text: &str) -> String {
    json!({ "op": "status", "level": WARNING, "message": text, "id": id }).to_string()
}

/// A message for a subscription, at a simulated time \[ns\].
pub(crate) fn message(subscription: u32, time: u64, payload: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(13 + payload.len());
    frame.push(MESSAGE);
    frame.extend(subscription.to_le_bytes());
    frame.extend(time.to_le_bytes());
    frame.extend(payload);
    frame
}

/// The simulated time \[ns\].
pub(crate) fn time(now: u64) -> Vec<u8> {
    let mut frame = vec![TIME];
    frame.extend(now.to_le_bytes());
    frame
}

/// A subscription that a viewer wishes.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscription {
    pub(crate) id: u32,
    pub(crate) channel_id: u32,
}

/// What a viewer says.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(crate) enum Request {
    /// It wants the messages of channels.
    Subscribe { subscriptions: Vec<Subscription> },
    /// It wants them no more.
    #[serde(rename_all = "camelCase")]
    Unsubscribe { subscription_ids: Vec<u32> },
    /// Anything else: to publish, to call, to set. There is nothing of it here.
    #[serde(other)]
    Other,
}
