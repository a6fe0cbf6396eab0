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
mod stream;
#[cfg(test)]
mod tests;

pub use protocol::StreamChannel;

use crate::stall::{Stall, StallStream};
use std::convert::Infallible;
use std::io;
use std::net::{self, SocketAddr};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use stream::SharedStream;
use tokio::net::TcpListener;
use tokio::runtime::Builder;
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

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
