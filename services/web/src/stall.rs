//! A connection that knows since when its other end has taken nothing.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;

/// Between two looks.
const LOOK: Duration = Duration::from_millis(500);

/// Since when a connection could not be written to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stall(Arc<Mutex<Option<Instant>>>);

impl Stall {
    /// Until nothing was taken for `most`: nobody reads there.
    pub(crate) async fn wait(&self, most: Duration) {
        let since = || *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        while since().is_none_or(|since| since.elapsed() < most) {
            tokio::time::sleep(LOOK).await;
        }
    }

    fn note<T>(&self, poll: &Poll<T>) {
        let mut since = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match poll {
            Poll::Pending => *since = since.or_else(|| Some(Instant::now())),
            Poll::Ready(_) => *since = None,
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
        self.stall.note(&written);
        written
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_shutdown(context)
    }
}
