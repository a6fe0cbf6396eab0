//! A proxy that stands for a bad link: it is slow, goes silent, cuts connections, turns bits over.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

/// Blocks of so many bytes are large.
const LARGE: usize = 4_096;

/// A line that is slow catches up with so much.
const SLACK: Duration = Duration::from_millis(20);

/// What a proxy does to what passes.
#[derive(Default)]
pub(crate) struct Weather {
    /// Nothing passes, and nothing is closed: as when a cable is pulled.
    pub(crate) silent: AtomicBool,
    /// What each block waits \[ms\].
    pub(crate) delay: AtomicU64,
    /// How far away the other end is: what each byte takes one way, others with it \[ms\].
    pub(crate) lag: AtomicU64,
    /// Most bytes a second and way; 0 is no limit.
    pub(crate) rate: AtomicU64,
    /// Bits to turn over still.
    pub(crate) flips: AtomicU64,
    /// Bits turned over.
    pub(crate) flipped: AtomicU64,
    /// Bytes that have passed.
    pub(crate) passed: AtomicU64,
    /// Both ends of what is open, by number.
    open: Mutex<BTreeMap<u64, [TcpStream; 2]>>,
}

impl Weather {
    /// Closes all connections at once; returns how many there were.
    pub(crate) fn cut(&self) -> usize {
        let all = std::mem::take(&mut *self.open.lock().expect("a list"));
        all.values().flatten().for_each(|stream| drop(stream.shutdown(Shutdown::Both)));
        all.len()
    }

    /// Carries bytes one way until either end closes. `begins`: from the end that connects, which
    /// on a long way it has not done before there was an answer.
    fn carry(&self, number: u64, mut from: TcpStream, to: TcpStream, begins: bool) {
        let lag = Duration::from_millis(self.lag.load(Ordering::SeqCst));
        let mut to = Far::new(to, lag, if begins { 2 * lag } else { Duration::ZERO });
        let mut block = [0; 16_384];
        let mut count = 0_u64;
        // When the line is free again: who sleeps too long catches up.
        let mut free = Instant::now();
        while let Ok(length) = from.read(&mut block) {
            if length == 0 {
                break;
            }
            while self.silent.load(Ordering::SeqCst) {
                sleep(Duration::from_millis(5));
            }
            sleep(Duration::from_millis(self.delay.load(Ordering::SeqCst)));
            if let rate @ 1.. = self.rate.load(Ordering::SeqCst) {
                let late = Instant::now().checked_sub(SLACK).unwrap_or(free);
                free = free.max(late) + Duration::from_nanos(length as u64 * 1_000_000_000 / rate);
                sleep(free.saturating_duration_since(Instant::now()));
            }
            // One in the middle of a large block, which is most likely a number that a message
            // carries; with many in one message the message would not decode at all.
            if length >= LARGE && self.flips.load(Ordering::SeqCst) > 0 {
                if count % 12 == 5 {
                    self.flips.fetch_sub(1, Ordering::SeqCst);
                    self.flipped.fetch_add(1, Ordering::SeqCst);
                    block[length / 2] ^= 1 << (count % 8);
                }
                count += 1;
            }
            self.passed.fetch_add(length as u64, Ordering::SeqCst);
            if to.write(&block[..length]).is_err() {
                break;
            }
        }
        from.shutdown(Shutdown::Both).ok();
        to.close();
        self.open.lock().expect("a list").remove(&number);
    }
}

/// The far end of a way.
enum Far {
    Here(TcpStream),
    /// Blocks on their way, with the time at which they are there.
    Away {
        road: Sender<(Instant, Vec<u8>)>,
        lag: Duration,
        first: Duration,
    },
}

impl Far {
    /// `first`: what the first block takes beyond the others.
    fn new(to: TcpStream, lag: Duration, first: Duration) -> Self {
        if lag.is_zero() {
            return Self::Here(to);
        }
        let (road, blocks) = channel::<(Instant, Vec<u8>)>();
        spawn(move || {
            let mut to = to;
            for (due, block) in blocks {
                sleep(due.saturating_duration_since(Instant::now()));
                if to.write_all(&block).is_err() {
                    break;
                }
            }
            to.shutdown(Shutdown::Both).ok();
        });
        Self::Away { road, lag, first }
    }

    fn write(&mut self, block: &[u8]) -> std::io::Result<()> {
        match self {
            Self::Here(to) => to.write_all(block),
            Self::Away { road, lag, first } => {
                let due = Instant::now() + *lag + std::mem::take(first);
                road.send((due, block.to_vec())).map_err(std::io::Error::other)
            }
        }
    }

    /// What is on its way arrives before the end.
    fn close(self) {
        if let Self::Here(to) = self {
            to.shutdown(Shutdown::Both).ok();
        }
    }
}

/// A proxy before `endpoint`, and where it listens.
pub(crate) fn proxy(endpoint: &str) -> (Arc<Weather>, String) {
    let weather = Arc::new(Weather::default());
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let (kind, target) = endpoint.split_once('/').expect("an endpoint");
    let here = format!("{kind}/{}", listener.local_addr().expect("an address"));
    let (kept, target) = (weather.clone(), target.to_owned());
    spawn(move || {
        for (number, near) in (0..).zip(listener.incoming().flatten()) {
            let Ok(far) = TcpStream::connect(&target) else {
                continue;
            };
            let twin = |stream: &TcpStream| stream.try_clone().expect("a second handle");
            let ends = [twin(&near), twin(&far)];
            kept.open.lock().expect("a list").insert(number, ends);
            let (up, down) = (kept.clone(), kept.clone());
            let (near_too, far_too) = (twin(&near), twin(&far));
            spawn(move || up.carry(number, near, far, true));
            spawn(move || down.carry(number, far_too, near_too, false));
        }
    });
    (weather, here)
}
