//! What a meeting does to the ways of those that touch.

use super::sweep::SweptBody;
use rapier3d_f64::math::Vector;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// So many impulses are given at a meeting, at most: where a light body is caught between heavy
/// ones, more would stop what the solver will not stop either.
const MOST: usize = 400;

/// Two bodies that touch since they met in this step.
pub(super) struct Touch {
    pub(super) a: usize,
    pub(super) b: usize,
    /// Unit, from `a` to `b`.
    pub(super) normal: Vector,
    /// Must the engine still find them in contact when the next step begins? Then they go on
    /// together; otherwise they lose what closes, and slide.
    pub(super) together: bool,
    /// By how much they may sink into each other within a step \[m\].
    pub(super) slack: f64,
}

/// All that touch since they met, and those of each body.
pub(super) struct Touches {
    all: Vec<Touch>,
    of: Vec<Vec<usize>>,
}

impl Touches {
    pub(super) fn new(bodies: usize) -> Self {
        Self { all: Vec::new(), of: vec![Vec::new(); bodies] }
    }

    /// Two have met: takes out of their ways what closes, or all that parts them from each other,
    /// then likewise from all that are pushed against others by that. Impulses are opposite and act
    /// through the centres, so that the middle of all masses keeps its way. Returns the new ways
    /// over a whole step.
    pub(super) fn meet(
        &mut self,
        touch: Touch,
        bodies: &[SweptBody<'_>],
        share: f64,
    ) -> BTreeMap<usize, Vector> {
        let (a, b, new) = (touch.a, touch.b, self.all.len());
        self.all.push(touch);
        self.of[a].push(new);
        self.of[b].push(new);
        let mut along = Along { bodies, new: BTreeMap::new(), left: 1.0 - share };
        for k in [a, b].into_iter().filter(|&k| bodies[k].ease > 0.0) {
            along.new.insert(k, bodies[k].along());
        }
        let mut queue = VecDeque::from([new]);
        let mut queued = BTreeSet::from([new]);
        let mut fresh = true;
        for _ in 0..MOST {
            let Some(k) = queue.pop_front() else { break };
            queued.remove(&k);
            let touch = &self.all[k];
            if !along.part(touch, std::mem::take(&mut fresh)) {
                continue;
            }
            let ends = [touch.a, touch.b].into_iter().filter(|&end| bodies[end].ease > 0.0);
            for &other in ends.flat_map(|end| &self.of[end]) {
                if other != k && queued.insert(other) {
                    queue.push_back(other);
                }
            }
        }
        // Whatever is left over, nothing goes on into what is fixed.
        let moved: Vec<usize> = along.new.keys().copied().collect();
        for touch in moved.iter().flat_map(|&k| &self.of[k]).map(|&k| &self.all[k]) {
            if bodies[touch.a].ease == 0.0 || bodies[touch.b].ease == 0.0 {
                along.part(touch, false);
            }
        }
        along.new
    }
}

/// The ways as they are being changed.
struct Along<'a> {
    bodies: &'a [SweptBody<'a>],
    new: BTreeMap<usize, Vector>,
    /// What is left of the step \[1\].
    left: f64,
}

impl Along<'_> {
    fn of(&self, k: usize) -> Vector {
        self.new.get(&k).copied().unwrap_or_else(|| self.bodies[k].along())
    }

    /// Takes out what closes between two, if it is more than they may sink, or if they have just
    /// met.
    fn part(&mut self, touch: &Touch, new: bool) -> bool {
        let (a, b, n) = (touch.a, touch.b, touch.normal);
        let between = self.of(a) - self.of(b);
        let closing = between.dot(n);
        let least = if new { 0.0 } else { touch.slack };
        if closing * self.left <= least && !(new && touch.together) {
            return false;
        }
        let [one, two] = [a, b].map(|k| self.bodies[k].ease);
        let gone = if touch.together { between } else { n * closing };
        let push = gone / (one + two);
        for (k, ease) in [(a, -one), (b, two)].into_iter().filter(|(_, ease)| *ease != 0.0) {
            let way = self.of(k) + push * ease;
            self.new.insert(k, way);
        }
        true
    }
}
