//! Pairs of bodies that rest on one another, and what each of their last steps did.

use crate::exchange::Received;
use crate::rigid::Contact;
use std::collections::BTreeMap;

/// A step, and what the lower and the higher id of a pair received in it.
type Carried = (u64, [Received; 2]);

/// Pairs that rest, and what each of their last steps did.
#[derive(Default)]
pub(crate) struct Resting {
    pairs: BTreeMap<(u32, u32), Vec<Carried>>,
}

impl Resting {
    pub(crate) fn add(&mut self, contact: &Contact, step: u64, received: [Received; 2]) {
        self.pairs.entry((contact.a, contact.b)).or_default().push((step, received));
    }

    /// Forgets steps before `first`.
    pub(crate) fn forget(&mut self, first: u64) {
        self.pairs.retain(|_, steps| {
            steps.retain(|(step, _)| *step >= first);
            !steps.is_empty()
        });
    }

    /// Did the pair touch after `step`, and what did its body get beyond what it got at `step`?
    pub(crate) fn since(&self, body: u32, other: u32, step: u64) -> Option<Received> {
        let side = usize::from(body > other);
        let steps = self.pairs.get(&(body.min(other), body.max(other)))?;
        let steady = steps.iter().rev().find(|(at, _)| *at <= step);
        let back = steady.map_or_else(Received::zero, |(_, got)| got[side].scaled(-1.0));
        let mut later = steps.iter().filter(|(at, _)| *at > step).peekable();
        later.peek()?;
        Some(later.fold(Received::zero(), |mut sum, (_, got)| {
            sum.add(&got[side]);
            sum.add(&back);
            sum
        }))
    }
}

impl Resting {
    /// Who touches a body.
    pub(crate) fn partners(&self, body: u32) -> impl Iterator<Item = u32> + '_ {
        let other = move |&(a, b): &(u32, u32)| match body {
            id if id == a => Some(b),
            id if id == b => Some(a),
            _ => None,
        };
        self.pairs.keys().filter_map(other)
    }
}
