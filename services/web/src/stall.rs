//! A connection that knows since when its other end has taken nothing, or hardly anything.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;

/// Between two looks.
const LOOK: Duration = Duration::from_millis(500);

/// Least that is taken while more waits, in the time in which something must be \[bytes\]: who
/// takes a few bytes now and then keeps what waits for it as well as one who takes nothing.
const LEAST: usize = 16 << 10;

/// Since when a connection could not be written to, and what was taken since.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stall(Arc<Mutex<Option<(Instant, usize)>>>);

impl Stall {
    /// Until less than [`LEAST`] was taken for `most`: nobody reads there.
    pub(crate) async fn wait(&self, most: Duration) {
        while !self.is_over(Instant::now(), most) {
            tokio::time::sleep(LOOK).await;
        }
    }

    /// Whether less than [`LEAST`] was taken for `most` by `now`; where it was more, that time
    /// starts anew.
    fn is_over(&self, now: Instant, most: Duration) -> bool {
        let mut behind = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match *behind {
            Some((since, taken)) if now.duration_since(since) >= most => {
                *behind = Some((now, 0));
                taken < LEAST
            }
            _ => false,
        }
    }

    /// A write of `wanted` bytes came to that: it is behind until one is taken whole.
    fn note(&self, now: Instant, wanted: usize, poll: &Poll<io::Result<usize>>) {
        let mut behind = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match poll {
            Poll::Ready(Ok(count)) if *count < wanted => {
                let (_, taken) = behind.get_or_insert((now, 0));
                *taken += count;
            }
            Poll::Ready(_) => *behind = None,
            Poll::Pending => drop(behind.get_or_insert((now, 0))),
        }
    }
}

/// A connection whose writes are watched.
#[derive(Debug)]
pub(crate) struct StallStream {
    inner: TcpStream,
    stall: Stall,
}

impl StallStream {
    pub(crate) fn new(inner: TcpStream, stall: Stall) -> Self {
        Self { inner, stall }
    }
}

impl AsyncRead for StallStream {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_read(context, buffer)
    }
}

impl AsyncWrite for StallStream {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.inner).poll_write(context, bytes);
        self.stall.note(Instant::now(), bytes.len(), &written);
        written
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::{LEAST, Stall};
    use std::task::Poll;
    use std::time::{Duration, Instant};

    /// Whether a reader that takes so much at each of some times [s] of much more is sent away when
    /// it is looked at.
    fn sent_away(taken: &[(u64, usize)], looks: &[u64]) -> Vec<bool> {
        let (stall, begun) = (Stall::default(), Instant::now());
        let at = |second: u64| begun + Duration::from_secs(second);
        let mut left = taken;
        let mut look = |second: &u64| {
            while let [(when, count), rest @ ..] = left
                && when <= second
            {
                stall.note(at(*when), 1 << 20, &Poll::Ready(Ok(*count)));
                left = rest;
            }
            stall.is_over(at(*second), Duration::from_secs(10))
        };
        looks.iter().map(&mut look).collect()
    }

    #[test]
    fn a_reader_that_takes_little_is_sent_away_and_one_that_takes_enough_stays() {
        let few = [(0, LEAST / 2), (5, LEAST / 2 - 1)];
        assert_eq!(sent_away(&few, &[0, 9, 10]), [false, false, true]);
        let enough = [(0, LEAST / 2), (5, LEAST / 2)];
        assert_eq!(sent_away(&enough, &[0, 9, 10, 19]), [false; 4]);
        // What it took then counts for that time alone.
        assert_eq!(sent_away(&enough, &[10, 20]), [false, true]);
        assert_eq!(sent_away(&[(0, 0)], &[9, 10]), [false, true]);
    }

    #[test]
    fn a_write_that_is_taken_whole_is_not_waited_for() {
        let (stall, begun) = (Stall::default(), Instant::now());
        let late = begun + Duration::from_secs(60);
        stall.note(begun, 64, &Poll::Pending);
        stall.note(begun, 64, &Poll::Ready(Ok(64)));
        assert!(!stall.is_over(late, Duration::from_secs(10)));
        stall.note(begun, 64, &Poll::Pending);
        assert!(stall.is_over(late, Duration::from_secs(10)));
    }
}
