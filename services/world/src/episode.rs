//! Contact episodes: from the first fast touch until the pair no longer closes (F37–F39).
//!
//! A pair's impulse is summed over all contact points and steps of one episode and judged once, so
//! that four contact points are one hit and the step does not decide.

use crate::exchange::{Exchange, Received};
use crate::motion::Motion;
use crate::rigid::Contact;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// A pair that closes.
#[derive(Clone, Debug)]
pub(crate) struct Episode {
    pub(crate) number: u64,
    /// When it began \[s\].
    pub(crate) opened: f64,
    /// Motion of the lower and higher id at the first touch.
    pub(crate) first: [Motion; 2],
    /// Closing speed before the first touch \[m/s\].
    pub(crate) closing_speed: f64,
    /// Σ of the impulses on the higher id \[N·s\].
    pub(crate) on_b: Vec3,
    /// Σ sizes of the impulses \[N·s\].
    pub(crate) impulse: f64,
    /// Σ impulse · point \[N·s·m\].
    pub(crate) moment: Vec3,
    /// What the weight alone pressed \[N·s\].
    pub(crate) weight: f64,
    /// What the lower and the higher id received.
    pub(crate) exchanged: [Exchange; 2],
    /// Kinetic energy that the contact took out of the pair \[J\].
    pub(crate) dissipated: f64,
    /// Was the pair in contact in the last step, and how fast did it close after it \[m/s\]?
    pub(crate) closing_after: Option<f64>,
}

impl Episode {
    /// Unit direction of the push on the higher id, if it has one.
    pub(crate) fn normal(&self) -> Option<Vec3> {
        self.on_b.try_normalize(0.0)
    }

    /// Impulse of the hit without the pair's weight \[N·s\].
    pub(crate) fn net_impulse(&self) -> f64 {
        (self.on_b.norm() - self.weight).max(0.0)
    }

    /// Where they touched, weighted by impulse \[m\].
    pub(crate) fn point(&self) -> Vec3 {
        self.moment / self.impulse
    }

    /// Takes in one more step of the pair's contact.
    pub(crate) fn add(&mut self, contact: &Contact, weight: f64, received: &[Received; 2]) {
        self.impulse += contact.impulse;
        self.on_b += contact.on_b;
        self.moment += contact.moment;
        self.weight += weight;
        for (sum, side) in self.exchanged.iter_mut().zip(received) {
            sum.add(&side.exchange);
            self.dissipated += side.taken;
        }
        self.closing_after = Some(contact.closing_speed_after());
    }

    /// Is it over: the pair parted, or no longer closes, or the longest episode has passed?
    pub(crate) fn over(&self, now: f64, resting_speed: f64, longest: f64) -> bool {
        // A step counts as past when it is so up to rounding.
        let late = now - self.opened >= longest * (1.0 - 1e-9);
        late || self.closing_after.is_none_or(|speed| speed <= resting_speed)
    }
}

/// The pairs that are in an episode, and those that had one lately.
#[derive(Default)]
pub(crate) struct Episodes {
    pub(crate) open: BTreeMap<(u32, u32), Episode>,
    /// When the pair's last episode was judged \[s\], and how fast it had closed \[m/s\].
    judged: BTreeMap<(u32, u32), (f64, f64)>,
    next: u64,
}

impl Episodes {
    /// May a new episode of this pair begin? Within `pause` \[s\] of its last only if it is no mere
    /// echo: if it closes at least half as fast.
    pub(crate) fn ready(&self, pair: (u32, u32), now: f64, pause: f64, speed: f64) -> bool {
        self.judged.get(&pair).is_none_or(|(then, last)| now - then >= pause || speed >= 0.5 * last)
    }

    /// Expects word of every open pair's contact in the step that begins.
    pub(crate) fn begin_step(&mut self) {
        self.open.values_mut().for_each(|episode| episode.closing_after = None);
    }

    /// Begins an episode.
    pub(crate) fn open(
        &mut self,
        contact: &Contact,
        opened: f64,
        first: [Motion; 2],
        closing_speed: f64,
    ) {
        let episode = Episode {
            number: self.next,
            opened,
            first,
            closing_speed,
            on_b: Vec3::zeros(),
            impulse: 0.0,
            moment: Vec3::zeros(),
            weight: 0.0,
            exchanged: [Exchange::zero(); 2],
            dissipated: 0.0,
            closing_after: None,
        };
        self.next += 1;
        self.open.insert((contact.a, contact.b), episode);
    }

    /// Takes out the episodes that are over, in pair order, and forgets pauses that have run out.
    pub(crate) fn take_over(
        &mut self,
        now: f64,
        resting: f64,
        longest: f64,
    ) -> Vec<((u32, u32), Episode)> {
        self.judged.retain(|_, (then, _)| now - *then < longest);
        let over: Vec<(u32, u32)> = self
            .open
            .iter()
            .filter(|(_, episode)| episode.over(now, resting, longest))
            .map(|(pair, _)| *pair)
            .collect();
        over.into_iter()
            .filter_map(|pair| {
                let episode = self.open.remove(&pair)?;
                self.judged.insert(pair, (now, episode.closing_speed));
                Some((pair, episode))
            })
            .collect()
    }

    /// Forgets all pairs of a body that is gone.
    pub(crate) fn forget(&mut self, id: u32) {
        self.open.retain(|&(a, b), _| a != id && b != id);
        self.judged.retain(|&(a, b), _| a != id && b != id);
    }
}
