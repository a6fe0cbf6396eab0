//! The run so far, and the viewers that watch it.

use super::protocol::{self, Advertised, StreamChannel};
use super::queue::ClientQueue;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use tungstenite::Bytes;

/// Viewers at once; another one is turned away.
const MOST_VIEWERS: usize = 8;
/// Lines of the log that a late viewer gets.
const LINES: usize = 200;
/// The channel of the log.
const LOG: &str = "/log";

/// What the recorder and the viewers' tasks share.
#[derive(Debug, Default)]
pub(super) struct SharedStream(Mutex<StreamState>);

impl SharedStream {
    pub(super) fn state(&self) -> MutexGuard<'_, StreamState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A channel, and what a late viewer gets of it.
#[derive(Debug)]
struct KnownChannel {
    advertised: Advertised,
    /// Times \[ns\] and messages.
    latest: VecDeque<(u64, Bytes)>,
    /// How many of them are kept.
    keep: usize,
}

/// The run so far, and who watches it.
#[derive(Debug, Default)]
pub(super) struct StreamState {
    name: String,
    /// Names the run among others.
    session: String,
    runs: u64,
    /// In the order of their numbers, which go on from one run to the next.
    channels: Vec<KnownChannel>,
    places: BTreeMap<String, usize>,
    /// Those of channels, in base64.
    schemas: BTreeSet<Arc<str>>,
    /// Number of the first of the channels.
    first: u32,
    pub(super) time: u64,
    pub(super) clients: BTreeMap<u64, Arc<ClientQueue>>,
    next_client: u64,
    /// By viewers that are gone.
    pub(super) left_out: u64,
}

impl StreamState {
    pub(super) fn begin(&mut self, name: &str) {
        let gone: Vec<u32> = self.channels.iter().map(|channel| channel.advertised.id).collect();
        self.first += gone.len() as u32;
        self.channels.clear();
        self.places.clear();
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        self.runs += 1;
        self.session = format!("{}-{}", since.as_millis(), self.runs);
        (self.name, self.time) = (name.to_owned(), 0);
        let info = self.info();
        for queue in self.clients.values() {
            queue.forget(&gone);
            if !gone.is_empty() {
                queue.say(protocol::unadvertise(&gone));
            }
            queue.say_run(info.clone());
        }
    }

    fn info(&self) -> String {
        protocol::server_info(&self.name, &self.session)
    }

    pub(super) fn channel(&mut self, channel: &StreamChannel<'_>) {
        if self.places.contains_key(channel.topic) {
            return;
        }
        let place = self.channels.len();
        let id = self.first + place as u32 + 1;
        let advertised = Advertised::of(id, channel, &mut self.schemas);
        let texts = protocol::advertise([&advertised].into_iter());
        let keep = if channel.topic == LOG { LINES } else { 1 };
        self.channels.push(KnownChannel { advertised, latest: VecDeque::new(), keep });
        self.places.insert(channel.topic.to_owned(), place);
        for queue in self.clients.values() {
            texts.iter().for_each(|text| queue.say(text.clone()));
        }
    }

    pub(super) fn message(&mut self, topic: &str, time: u64, payload: &[u8]) {
        let Some(&place) = self.places.get(topic) else { return };
        let channel = &mut self.channels[place];
        let payload = Bytes::copy_from_slice(payload);
        self.time = self.time.max(time);
        for queue in self.clients.values() {
            queue.put(channel.advertised.id, time, &payload);
        }
        channel.latest.push_back((time, payload));
        if channel.latest.len() > channel.keep {
            channel.latest.pop_front();
        }
    }

    /// A viewer; nothing where there are too many. It is told what there is.
    pub(super) fn join(&mut self) -> Option<(u64, Arc<ClientQueue>)> {
        if self.clients.len() >= MOST_VIEWERS {
            return None;
        }
        let queue = Arc::new(ClientQueue::default());
        queue.say_run(self.info());
        let all = self.channels.iter().map(|channel| &channel.advertised);
        protocol::advertise(all).into_iter().for_each(|text| queue.say(text));
        self.next_client += 1;
        self.clients.insert(self.next_client, Arc::clone(&queue));
        Some((self.next_client, queue))
    }

    pub(super) fn leave(&mut self, client: u64) {
        if let Some(queue) = self.clients.remove(&client) {
            self.left_out += queue.left_out();
        }
    }

    /// Subscribes a channel for a viewer, and gives it what is latest there.
    pub(super) fn subscribe(
        &self,
        queue: &ClientQueue,
        subscription: u32,
        channel: u32,
    ) -> Result<(), String> {
        let place = channel.checked_sub(self.first + 1).map(|place| place as usize);
        let Some(known) = place.and_then(|place| self.channels.get(place)) else {
            return Err(format!("there is no channel {channel}"));
        };
        queue.subscribe(subscription, channel)?;
        for (time, payload) in &known.latest {
            queue.put(channel, *time, payload);
        }
        Ok(())
    }
}
