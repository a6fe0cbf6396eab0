//! What waits for a viewer, bounded.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;
use tungstenite::Bytes;

/// Most bytes of messages that wait for a viewer before those are left out that a newer one of the
/// same channel follows: some seconds of a scene of many pieces. The newest of each channel always
/// waits: it is kept for late viewers anyway, and may never come again.
const MOST_BYTES: usize = 64 << 20;
/// What a message or a text that waits counts for beside its own bytes.
const ENTRY_BYTES: usize = 64;
/// Most bytes of texts that wait for a viewer; one that takes none of them is given up.
const MOST_TEXT_BYTES: usize = 64 << 20;
/// Most texts that wait before warnings are left out.
const MOST_WARNINGS: usize = 1000;
/// Most subscriptions of a viewer.
const MOST_SUBSCRIPTIONS: usize = 4096;

/// The next thing to send.
#[derive(Debug)]
pub(super) enum NextFrame {
    /// A text of the protocol.
    Text(String),
    /// The text by which a run begins, and its time with it.
    Run(String),
    /// A message.
    Message { subscription: u32, time: u64, payload: Bytes },
    /// So many messages were left out in all.
    LeftOut(u64),
    /// The server ends.
    Close,
}

#[derive(Debug)]
struct WaitingMessage {
    subscription: u32,
    time: u64,
    payload: Bytes,
}

impl WaitingMessage {
    fn size(&self) -> usize {
        self.payload.len() + ENTRY_BYTES
    }
}

#[derive(Debug, Default)]
struct Waiting {
    /// Texts, and whether a run begins with one.
    texts: VecDeque<(String, bool)>,
    text_bytes: usize,
    /// In the order in which they came.
    messages: BTreeMap<u64, WaitingMessage>,
    /// Those that a newer one of the same subscription follows.
    superseded: BTreeSet<u64>,
    /// The newest of each subscription, where it still waits.
    newest: BTreeMap<u32, u64>,
    /// How many came.
    count: u64,
    bytes: usize,
    /// Channels by the numbers of subscriptions, and the other way.
    subscriptions: BTreeMap<u32, u32>,
    by_channel: BTreeMap<u32, u32>,
    left_out: u64,
    /// How many of them the viewer knows of.
    said: u64,
    closed: bool,
}

impl Waiting {
    fn put(&mut self, message: WaitingMessage) {
        self.count += 1;
        self.bytes += message.size();
        let before = self.newest.insert(message.subscription, self.count);
        self.superseded.extend(before);
        self.messages.insert(self.count, message);
        while self.bytes > MOST_BYTES
            && let Some(oldest) = self.superseded.pop_first()
        {
            if let Some(oldest) = self.messages.remove(&oldest) {
                self.bytes -= oldest.size();
                self.left_out += 1;
            }
        }
    }

    /// The oldest message.
    fn pop(&mut self) -> Option<WaitingMessage> {
        let (place, message) = self.messages.pop_first()?;
        self.bytes -= message.size();
        if !self.superseded.remove(&place) {
            self.newest.remove(&message.subscription);
        }
        Some(message)
    }

    /// Ends subscriptions; those that there are not are passed over.
    fn end(&mut self, subscriptions: impl Iterator<Item = u32>) {
        let mut ended = BTreeSet::new();
        for subscription in subscriptions {
            if let Some(channel) = self.subscriptions.remove(&subscription) {
                self.by_channel.remove(&channel);
                self.newest.remove(&subscription);
                ended.insert(subscription);
            }
        }
        if ended.is_empty() {
            return;
        }
        self.messages.retain(|_, message| !ended.contains(&message.subscription));
        let messages = &self.messages;
        self.superseded.retain(|place| messages.contains_key(place));
        self.bytes = messages.values().map(WaitingMessage::size).sum();
    }

    /// A viewer that takes no texts is given up: what waits for it goes, and nothing is added.
    fn say(&mut self, text: String, begins: bool) {
        if self.closed {
            return;
        }
        self.text_bytes += text.len() + ENTRY_BYTES;
        self.texts.push_back((text, begins));
        if self.text_bytes > MOST_TEXT_BYTES {
            self.closed = true;
            self.texts.clear();
            self.text_bytes = 0;
            self.by_channel.clear();
            let all = std::mem::take(&mut self.subscriptions);
            self.left_out += self.messages.len() as u64;
            self.messages.clear();
            self.superseded.clear();
            self.newest.clear();
            self.bytes = 0;
            tracing::debug!("a viewer of {} channels took no texts", all.len());
        }
    }
}

/// A viewer's queue: texts first, for a message is of a channel that it was told of.
#[derive(Debug, Default)]
pub(super) struct ClientQueue {
    waiting: Mutex<Waiting>,
    wake: Notify,
}

impl ClientQueue {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn say(&self, text: String) {
        self.waiting().say(text, false);
        self.wake.notify_one();
    }

    /// The text by which a run begins.
    pub(super) fn say_run(&self, text: String) {
        self.waiting().say(text, true);
        self.wake.notify_one();
    }

    /// A text that a viewer caused; none is kept for one that reads none of them.
    pub(super) fn warn(&self, text: String) {
        if self.waiting().texts.len() < MOST_WARNINGS {
            self.say(text);
        }
    }

    /// A message of a channel, if that is subscribed.
    pub(super) fn put(&self, channel: u32, time: u64, payload: &Bytes) {
        let mut waiting = self.waiting();
        let Some(&subscription) = waiting.by_channel.get(&channel) else { return };
        waiting.put(WaitingMessage { subscription, time, payload: payload.clone() });
        drop(waiting);
        self.wake.notify_one();
    }

    pub(super) fn subscribe(&self, subscription: u32, channel: u32) -> Result<(), String> {
        let mut waiting = self.waiting();
        if waiting.closed {
            return Err("this connection ends".to_owned());
        }
        if waiting.subscriptions.len() >= MOST_SUBSCRIPTIONS {
            return Err(format!("at most {MOST_SUBSCRIPTIONS} subscriptions are taken"));
        }
        if waiting.subscriptions.contains_key(&subscription) {
            return Err(format!("there is a subscription {subscription} already"));
        }
        if let Some(other) = waiting.by_channel.get(&channel) {
            return Err(format!("the subscription {other} has the channel {channel} already"));
        }
        waiting.subscriptions.insert(subscription, channel);
        waiting.by_channel.insert(channel, subscription);
        Ok(())
    }

    pub(super) fn unsubscribe(&self, subscriptions: &[u32]) {
        self.waiting().end(subscriptions.iter().copied());
    }

    /// These channels are no more.
    pub(super) fn forget(&self, channels: &[u32]) {
        let mut waiting = self.waiting();
        let of = |channel: &u32| waiting.by_channel.get(channel).copied();
        let gone: Vec<u32> = channels.iter().filter_map(of).collect();
        waiting.end(gone.into_iter());
    }

    pub(super) fn left_out(&self) -> u64 {
        self.waiting().left_out
    }

    pub(super) fn is_empty(&self) -> bool {
        let waiting = self.waiting();
        waiting.texts.is_empty() && waiting.messages.is_empty()
    }

    pub(super) fn close(&self) {
        self.waiting().closed = true;
        self.wake.notify_one();
    }

    fn take(&self) -> Option<NextFrame> {
        let mut waiting = self.waiting();
        if let Some((text, begins)) = waiting.texts.pop_front() {
            waiting.text_bytes -= text.len() + ENTRY_BYTES;
            return Some(if begins { NextFrame::Run(text) } else { NextFrame::Text(text) });
        }
        if waiting.left_out > waiting.said {
            waiting.said = waiting.left_out;
            return Some(NextFrame::LeftOut(waiting.said));
        }
        if let Some(message) = waiting.pop() {
            let WaitingMessage { subscription, time, payload } = message;
            return Some(NextFrame::Message { subscription, time, payload });
        }
        waiting.closed.then_some(NextFrame::Close)
    }

    /// Waits for the next thing to send.
    pub(super) async fn next(&self) -> NextFrame {
        loop {
            if let Some(next) = self.take() {
                return next;
            }
            self.wake.notified().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ClientQueue, ENTRY_BYTES, MOST_BYTES, MOST_TEXT_BYTES, NextFrame};
    use tungstenite::Bytes;

    fn times(queue: &ClientQueue) -> Vec<u64> {
        let mut times = Vec::new();
        while let Some(next) = queue.take() {
            if let NextFrame::Message { time, .. } = next {
                times.push(time);
            }
        }
        times
    }

    #[test]
    fn what_does_not_fit_is_left_out_from_the_oldest_on() {
        let queue = ClientQueue::default();
        queue.subscribe(7, 1).expect("the first");
        let third = Bytes::from(vec![0; MOST_BYTES / 3 - ENTRY_BYTES]);
        for time in 0..5 {
            queue.put(1, time, &third);
            queue.put(2, 100 + time, &third);
        }
        assert_eq!(queue.left_out(), 2);
        assert!(matches!(queue.take(), Some(NextFrame::LeftOut(2))), "that is said first");
        assert_eq!(times(&queue), [2, 3, 4]);
        queue.put(1, 9, &Bytes::from(vec![0; 2 * MOST_BYTES]));
        assert_eq!(times(&queue), [9], "a larger one waits alone");
        assert_eq!(queue.left_out(), 2);
        assert!(queue.is_empty());
    }

    /// A late viewer of many still bodies gets each of them, however large they are together, and
    /// the moving ones leave out what is old.
    #[test]
    fn the_newest_of_each_channel_is_never_left_out() {
        let queue = ClientQueue::default();
        let large = Bytes::from(vec![0; MOST_BYTES / 100]);
        for channel in 0..1000 {
            queue.subscribe(channel, channel).expect("it is new");
            queue.put(channel, u64::from(channel), &large);
        }
        assert_eq!(queue.left_out(), 0);
        queue.put(3, 1000, &large);
        queue.put(3, 1001, &large);
        assert_eq!(queue.left_out(), 2, "the older ones of the channel 3");
        assert!(matches!(queue.take(), Some(NextFrame::LeftOut(2))));
        let whole: Vec<u64> = (0..1000).filter(|time| *time != 3).chain([1001]).collect();
        assert_eq!(times(&queue), whole);
        // One that was sent is followed by nothing that would be left out for it.
        queue.put(3, 1002, &large);
        assert_eq!((times(&queue), queue.left_out()), (vec![1002], 2));
        assert_eq!(queue.waiting().bytes, 0);
    }

    #[test]
    fn a_viewer_that_takes_no_texts_is_given_up() {
        let queue = ClientQueue::default();
        queue.subscribe(1, 1).expect("it is new");
        queue.put(1, 1, &Bytes::from_static(b"x"));
        let text = "x".repeat(MOST_TEXT_BYTES / 8);
        for _ in 0..8 {
            queue.say(text.clone());
        }
        queue.put(1, 2, &Bytes::from_static(b"x"));
        assert!(matches!(queue.take(), Some(NextFrame::LeftOut(1))), "what waited");
        assert!(matches!(queue.take(), Some(NextFrame::Close)));
        assert!(queue.subscribe(2, 2).is_err());
    }

    #[test]
    fn subscriptions_come_and_go() {
        let queue = ClientQueue::default();
        let payload = Bytes::from_static(b"x");
        for (subscription, channel) in [(1, 10), (2, 20), (3, 30)] {
            queue.subscribe(subscription, channel).expect("it is new");
        }
        assert_eq!(queue.subscribe(1, 40), Err("there is a subscription 1 already".to_owned()));
        let twice = "the subscription 1 has the channel 10 already".to_owned();
        assert_eq!(queue.subscribe(4, 10), Err(twice));
        queue.put(10, 5, &payload);
        queue.put(20, 6, &payload);
        queue.put(30, 6, &payload);
        queue.unsubscribe(&[3, 3, 7, 8]);
        assert_eq!(times(&queue), [5, 6]);
        queue.put(10, 7, &payload);
        queue.put(20, 8, &payload);
        queue.forget(&[10, 30]);
        assert_eq!(times(&queue), [8]);
        queue.subscribe(3, 30).expect("it was given up");
        queue.put(10, 9, &payload);
        assert!(queue.is_empty());
    }
}
