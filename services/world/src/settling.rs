//! Bodies that are set down: what a scene puts on something comes to rest first, and that is no
//! impact.
//!
//! A stand-in of convex parts is never quite the body: a statue is put a millimetre above its
//! column or a millimetre into it, drops or is pushed out, and rocks on feet that are not level.
//! All of that is as slow as such a height makes it. A body that falls further before it touches
//! anything, one that the scene throws and one that was struck are none of these.

use crate::motion::Motion;
use std::collections::BTreeMap;

/// A body that moves no further than this before it first touches something is set down \[m\].
const SET_DOWN: f64 = 3e-3;
/// Fastest that a body closes while it settles \[m/s\]: twice the speed at which overlaps are
/// pushed apart. A fall of 8 mm has it.
const SETTLING_SPEED: f64 = 0.4;
/// A body whose surface is slower than this share of the resting speed … \[1\]
const STILL: f64 = 0.5;
/// … for so long has settled \[s\].
const SETTLED: f64 = 0.1;

/// A body of the scene that began at rest and was never struck.
#[derive(Clone, Copy, Debug)]
struct Calm {
    first: Motion,
    touched: bool,
    /// Since when it has been still \[s\]; none: it is not.
    still: Option<f64>,
    settled: bool,
}

/// The bodies that nothing has thrown or struck.
#[derive(Default)]
pub(crate) struct Settling(BTreeMap<u32, Calm>);

impl Settling {
    /// A body of the scene is put in at rest.
    pub(crate) fn put(&mut self, id: u32, first: Motion) {
        self.0.insert(id, Calm { first, touched: false, still: None, settled: false });
    }

    /// A body was struck, or is gone.
    pub(crate) fn end(&mut self, id: u32) {
        self.0.remove(&id);
    }

    /// A body touches another where it is now.
    pub(crate) fn touch(&mut self, id: u32, now: &Motion) {
        let Some(calm) = self.0.get_mut(&id) else {
            return;
        };
        let fell = (now.centre() - calm.first.centre()).norm();
        calm.touched |= fell <= SET_DOWN;
        if !calm.touched {
            self.0.remove(&id);
        }
    }

    /// Slowest approach of a pair that is a hit \[m/s\]; `fixed`: which of them never moves.
    pub(crate) fn least(&self, pair: (u32, u32), fixed: [bool; 2], resting: f64) -> f64 {
        let calm = [self.0.get(&pair.0), self.0.get(&pair.1)];
        let none_struck = calm.iter().zip(fixed).all(|(calm, fixed)| fixed || calm.is_some());
        let settles = calm.iter().flatten().any(|calm| calm.touched && !calm.settled);
        if none_struck && settles { SETTLING_SPEED.max(resting) } else { resting }
    }

    /// Notes which bodies are still; `motion`: of each, and how far it reaches \[m\].
    pub(crate) fn look(
        &mut self,
        now: f64,
        resting: f64,
        motion: impl Fn(u32) -> Option<(Motion, f64)>,
    ) {
        for (&id, calm) in self.0.iter_mut().filter(|(_, calm)| !calm.settled) {
            let Some((motion, reach)) = motion(id) else {
                continue;
            };
            let speed = motion.velocity.norm() + motion.spin.norm() * reach;
            if speed > STILL * resting {
                calm.still = None;
            } else {
                let since = *calm.still.get_or_insert(now);
                calm.settled = now - since >= SETTLED;
            }
        }
    }
}
