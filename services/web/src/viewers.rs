//! A run as it is recorded, for viewers: the server's side of Foxglove's WebSocket protocol, which
//! Foxglove and Lichtblick speak.
//!
//! Channels, schemas and messages are those of the recording, byte for byte, so that its layout
//! fits. Whoever records never waits: a message goes into a queue of bounded size for each viewer
//! that subscribed its channel, and what does not fit is left out and said: the oldest that a newer
//! one of the same channel follows. Who comes late gets the last message of each channel: for
//! drawings, that is all that there is to see.

mod protocol;
mod queue;
mod session;
#[cfg(test)]
mod tests;

pub use protocol::StreamChannel;

use crate::stall::{Stall, StallStream};
use protocol::Advertised;
use queue::ClientQueue;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::convert::Infallible;
use std::io;
use std::net::{self, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::net::TcpListener;
use tokio::runtime::Builder;
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use tungstenite::Bytes;

/// Viewers at once; another one is turned away.
const MOST_VIEWERS: usize = 8;
/// Connections at once, viewers among them; more are closed.
const CONNECTIONS: usize = 32;
/// Longest time for which a viewer may take nothing of what waits for it.
const STALL: Duration = Duration::from_secs(20);
/// How long viewers may take for what waits for them when the server ends.
const LAST: Duration = Duration::from_millis(500);
/// Before the next connection is taken, where there was no descriptor for one.
const PAUSE: Duration = Duration::from_millis(50);
/// Between looks whether viewers have all.
const LOOK: Duration = Duration::from_millis(20);
/// Lines of the log that a late viewer gets.
const LINES: usize = 200;
/// The channel of the log.
const LOG: &str = "/log";

/// A server of a run, or of runs one after another; it ends when dropped.
#[derive(Debug)]
pub struct ViewerServer {
    shared: Arc<SharedStream>,
    address: SocketAddr,
    stop: Option<oneshot::Sender<Infallible>>,
    thread: Option<JoinHandle<()>>,
}

impl ViewerServer {
    /// Listens, and serves in a thread of its own. Viewers must connect to this machine by a name
    /// that no other machine has, so the address should be one of the loopback.
    ///
    /// # Errors
    /// The address is not to be had, or a thread.
    pub fn start(address: SocketAddr) -> io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let listener = net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let shared = Arc::new(SharedStream::default());
        let (stop, stopped) = oneshot::channel();
        let serving = Arc::clone(&shared);
        let work = move || {
            runtime.block_on(async {
                match TcpListener::from_std(listener) {
                    Ok(listener) => serve(listener, serving, stopped).await,
                    Err(error) => tracing::error!("viewers: {error}"),
                }
            });
        };
        let thread = std::thread::Builder::new().name("cullet-viewers".to_owned()).spawn(work)?;
        Ok(Self { shared, address, stop: Some(stop), thread: Some(thread) })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A run of that name begins: viewers forget the one before.
    pub fn begin(&self, name: &str) {
        self.shared.state().begin(name);
    }

    /// The run has a channel; known ones are passed over.
    pub fn channel(&self, channel: &StreamChannel<'_>) {
        self.shared.state().channel(channel);
    }

    /// A message of a channel, at a simulated time \[ns\]. Never waits for a viewer.
    pub fn message(&self, topic: &str, time: u64, payload: &[u8]) {
        self.shared.state().message(topic, time, payload);
    }

    /// How many viewers there are.
    #[must_use]
    pub fn viewers(&self) -> usize {
        self.shared.state().clients.len()
    }

    /// How many messages were left out because viewers took them too slowly.
    #[must_use]
    pub fn left_out(&self) -> u64 {
        let state = self.shared.state();
        state.left_out + state.clients.values().map(|queue| queue.left_out()).sum::<u64>()
    }

    /// Waits until viewers have what waits for them, for so long at most.
    pub fn drain(&self, most: Duration) {
        let since = Instant::now();
        let waits = || self.shared.state().clients.values().any(|queue| !queue.is_empty());
        while since.elapsed() < most && waits() {
            std::thread::sleep(LOOK);
        }
    }
}

impl Drop for ViewerServer {
    fn drop(&mut self) {
        self.stop.take();
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

/// What the recorder and the viewers' tasks share.
#[derive(Debug, Default)]
pub(crate) struct SharedStream(Mutex<StreamState>);

impl SharedStream {
    fn state(&self) -> MutexGuard<'_, StreamState> {
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
struct StreamState {
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
    time: u64,
    clients: BTreeMap<u64, Arc<ClientQueue>>,
    next_client: u64,
    /// By viewers that are gone.
    left_out: u64,
}

impl StreamState {
    fn begin(&mut self, name: &str) {
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

    fn channel(&mut self, channel: &StreamChannel<'_>) {
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

    fn message(&mut self, topic: &str, time: u64, payload: &[u8]) {
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
    fn join(&mut self) -> Option<(u64, Arc<ClientQueue>)> {
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

    fn leave(&mut self, client: u64) {
        if let Some(queue) = self.clients.remove(&client) {
            self.left_out += queue.left_out();
        }
    }

    /// Subscribes a channel for a viewer, and gives it what is latest there.
    fn subscribe(
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

async fn serve(
    listener: TcpListener,
    shared: Arc<SharedStream>,
    mut stopped: oneshot::Receiver<Infallible>,
) {
    let mut tasks = JoinSet::new();
    loop {
        tokio::select! {
            _ = &mut stopped => break,
            Some(_) = tasks.join_next() => {}
            taken = listener.accept() => match taken {
                Ok(_) if tasks.len() >= CONNECTIONS => {}
                Ok((stream, _)) => {
                    let _small_messages_wait = stream.set_nodelay(true);
                    let shared = Arc::clone(&shared);
                    tasks.spawn(async move {
                        let stall = Stall::default();
                        let stream = StallStream::new(stream, stall.clone());
                        tokio::select! {
                            () = session::talk(stream, shared) => {}
                            () = stall.wait(STALL) => tracing::debug!("a viewer took nothing"),
                        }
                    });
                }
                Err(error) => {
                    tracing::debug!("viewers: {error}");
                    sleep(PAUSE).await;
                }
            },
        }
    }
    drop(listener);
    shared.state().clients.values().for_each(|queue| queue.close());
    let rest = async { while tasks.join_next().await.is_some() {} };
    drop(timeout(LAST, rest).await);
}
