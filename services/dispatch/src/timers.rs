//! When to look at which job. Setting a time costs the same however many jobs there are: nothing is
//! searched and nothing is taken out. A job is woken at the earliest time that was set for it since
//! it was woken last, and whoever wakes it sets the next. So a renewal, which puts an end off,
//! costs nothing here, and an end that comes sooner is found at its time.

use crate::event::Millis;
use std::collections::BTreeMap;

/// Times are kept by so many bits less, in no order within that: 32 ms.
const COARSE: u32 = 5;
const NEVER: Millis = Millis::MAX;

#[derive(Debug, Default)]
pub(crate) struct Timers {
    /// By coarse time: when, and where the job is. What is not as in `armed` is over.
    slots: BTreeMap<Millis, Vec<(Millis, usize)>>,
    /// When the job at each place is woken.
    armed: Vec<Millis>,
}

impl Timers {
    /// The job at this place is woken by then, or, without a time, not at all.
    pub(crate) fn set(&mut self, place: usize, at: Option<Millis>) {
        if place >= self.armed.len() {
            self.armed.resize(place + 1, NEVER);
        }
        match at {
            None => self.armed[place] = NEVER,
            Some(at) if at < self.armed[place] => {
                self.armed[place] = at;
                self.slots.entry(at >> COARSE).or_default().push((at, place));
            }
            Some(_) => {}
        }
    }

    /// The places whose jobs are woken now, in no order.
    pub(crate) fn due(&mut self, now: Millis) -> Vec<usize> {
        let mut due = Vec::new();
        while let Some(mut slot) =
            self.slots.first_entry().filter(|slot| *slot.key() <= now >> COARSE)
        {
            let armed = &mut self.armed;
            slot.get_mut().retain(|&(at, place)| {
                let stands = armed[place] == at;
                if stands && at <= now {
                    armed[place] = NEVER;
                    due.push(place);
                }
                stands && at > now
            });
            if !slot.get().is_empty() {
                break;
            }
            slot.remove();
        }
        due
    }
}
