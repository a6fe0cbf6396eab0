//! Labels for the nodes that have none: the likeliest end of a random walk (L. Grady, Random Walks
//! for Image Segmentation, 2006), so the border between two labels is a smooth surface where both
//! are equally likely.

use super::nodes::{DAMAGED, LatticeNodes};
use super::odds::{NONE, Odds, TIE, ZONE, add};
use std::collections::BTreeMap;

/// Walks are followed this many edges around the first guess of the border; farther off, the guess
/// stands.
const REACH: usize = 5;
/// Drawn pieces that came within this many edges of a node are asked which is the nearest; where
/// none did, those within `REACH`.
const BESIDE: usize = 2;
/// Gauss-Seidel sweeps, to and fro: enough for bands of six nodes, a start in wider ones.
const SWEEPS: usize = 24;
/// The nearest that the edge of damage may lie to a damaged node \[spacings\].
const CLOSEST: f64 = 0.2;

/// A border may be crossed this far beyond the ends of an edge \[spacings\].
const BEYOND: f64 = 0.3;

/// A step of a walk: to a node that is sure of its label, or to one with odds, and how likely.
#[derive(Clone, Copy, Debug)]
enum WalkStep {
    Label(u32, f64),
    Slot(u32, f64),
}

impl LatticeNodes {
    /// Gives every node a label, and a time of damage.
    pub(crate) fn fill(&mut self) {
        self.reach.clone_from(&self.label);
        // Labels must not leap across gaps between legs while there is a way through the body.
        self.carry(|nodes, i, j| nodes.is_inside(i) && nodes.is_inside(j) && nodes.connects(i, j));
        self.carry(|nodes, i, j| !(nodes.is_inside(i) && nodes.is_inside(j)));
        self.carry(|_, _, _| true);
        self.damage.carry_times(&self.lattice);
        self.walk();
    }

    /// Carries labels outward along the edges that `passes`, each node taking the first to come.
    fn carry(&mut self, passes: impl Fn(&Self, usize, usize) -> bool) {
        let mut queue: Vec<usize> =
            (0..self.lattice.len()).filter(|&i| self.reach[i] != NONE).collect();
        let mut head = 0;
        while head < queue.len() {
            let i = queue[head];
            head += 1;
            for j in self.lattice.beside(i) {
                if self.reach[j] == NONE && passes(self, i, j) {
                    self.reach[j] = self.reach[i];
                    queue.push(j);
                }
            }
        }
    }

    fn walk(&mut self) {
        let unsure: Vec<usize> =
            self.border().into_iter().filter(|&i| self.label[i] == NONE).collect();
        let first = self.odds.odds.len();
        for &i in &unsure {
            self.odds.set(i, Odds::sure(self.sampled.class(self.reach[i])));
        }
        let (mut ways, mut starts) = (Vec::new(), vec![0]);
        for &i in &unsure {
            ways.extend(self.ways(i));
            starts.push(ways.len());
        }
        let mut sums = Vec::new();
        for sweep in 0..SWEEPS {
            for k in 0..unsure.len() {
                let slot = if sweep % 2 == 0 { k } else { unsure.len() - 1 - k };
                let ways = &ways[starts[slot]..starts[slot + 1]];
                if !ways.is_empty() {
                    self.odds.odds[first + slot] = self.mean(ways, &mut sums);
                }
            }
        }
        let zone: Vec<(usize, Option<u32>)> = unsure
            .iter()
            .zip(&self.odds.odds[first..])
            .filter(|(_, odds)| odds.label() == ZONE)
            .map(|(&i, _)| (i, self.nearest_sampled(i)))
            .collect();
        for (&i, odds) in unsure.iter().zip(&self.odds.odds[first..]) {
            self.reach[i] = if odds.label() == ZONE { self.reach[i] } else { odds.label() };
        }
        for (i, ball) in zone {
            if let Some(ball) = ball {
                self.sampled.ball[i] = ball;
                self.reach[i] = self.sampled.label[ball as usize];
            }
        }
    }

    /// The nearest of the sampled pieces that first came to the nodes around.
    fn nearest_sampled(&self, i: usize) -> Option<u32> {
        let node = self.lattice.node(i);
        let place = self.lattice.place(node) / self.sampled.cell;
        [BESIDE, REACH].into_iter().find_map(|radius| {
            let near = self.lattice.around(node, radius).map(|j| self.reach[j]);
            let mut near: Vec<u32> =
                near.filter(|&label| self.sampled.class(label) == ZONE).collect();
            near.sort_unstable();
            near.dedup();
            let balls = (0..).zip(&self.sampled.label);
            let balls = balls.filter(|(_, label)| near.binary_search(label).is_ok());
            self.sampled.rubble.nearest(balls.map(|entry| entry.0), &place)
        })
    }

    /// Nodes within `REACH` edges of one where labels change, in order.
    fn border(&self) -> Vec<usize> {
        let n = self.lattice.len();
        let mut distance = vec![usize::MAX; n];
        let mixed = |i: usize| self.lattice.beside(i).any(|j| self.reach[j] != self.reach[i]);
        let mut queue: Vec<usize> = (0..n).filter(|&i| mixed(i)).collect();
        queue.iter().for_each(|&i| distance[i] = 0);
        let mut head = 0;
        while head < queue.len() {
            let i = queue[head];
            head += 1;
            for j in self.lattice.beside(i) {
                if distance[j] == usize::MAX && distance[i] < REACH {
                    distance[j] = distance[i] + 1;
                    queue.push(j);
                }
            }
        }
        queue.sort_unstable();
        queue
    }

    /// The steps of a walk from a node. Walks stay inside the body, where they start there, and end
    /// at the edge of the damage, which lies between nodes.
    fn ways(&self, i: usize) -> impl Iterator<Item = WalkStep> {
        let open =
            move |&j: &usize| !self.is_inside(i) || (self.is_inside(j) && self.connects(i, j));
        self.lattice.beside(i).filter(open).map(move |j| {
            let weight = 1.0 / self.gap(i, j);
            match self.odds.slot[j] {
                NONE => WalkStep::Label(self.sampled.class(self.reach[j]), weight),
                slot => WalkStep::Slot(slot, weight),
            }
        })
    }

    /// The mean of what the neighbours expect.
    fn mean(&self, ways: &[WalkStep], sums: &mut Vec<(u32, f64)>) -> Odds {
        sums.clear();
        for way in ways {
            match *way {
                WalkStep::Label(label, weight) => add(sums, label, weight),
                WalkStep::Slot(slot, weight) => {
                    for &(label, odds) in self.odds.odds[slot as usize].list() {
                        add(sums, label, weight * odds);
                    }
                }
            }
        }
        Odds::of_sums(sums)
    }

    /// Where the edge of the damage lies on the way from `i` to `j` \[spacings\]; 1 if it does not.
    fn gap(&self, i: usize, j: usize) -> f64 {
        if !(self.is_damaged(i) && self.is_sound(j)) {
            return 1.0;
        }
        let (here, there) = (self.damage.broken[i], self.damage.broken[j]);
        ((here - DAMAGED) / (here - there)).clamp(CLOSEST, 1.0)
    }

    fn odds_of(&self, i: usize, label: u32) -> f64 {
        match self.odds.of(i) {
            None => f64::from(u8::from(self.reach[i] == label)),
            Some(odds) => odds.of(self.sampled.class(label)),
        }
    }

    /// Where on the edge from `i` to `j`, of different labels, both are equally likely: 0 at `i`.
    pub(super) fn crossing(&self, i: usize, j: usize) -> f64 {
        if let Some((one, two)) = self.sampled.pair(i, j) {
            let [from, to] =
                [i, j].map(|n| self.lattice.place(self.lattice.node(n)) / self.sampled.cell);
            return self.sampled.rubble.crossing(one, two, &from, &to);
        }
        let (a, b) = (self.reach[i], self.reach[j]);
        let here = self.odds_of(i, a) - self.odds_of(i, b);
        let there = self.odds_of(j, b) - self.odds_of(j, a);
        let middle = if here + there > TIE { here / (here + there) } else { 0.5 };
        let middle = middle.clamp(-BEYOND, 1.0 + BEYOND);
        if self.is_damaged(i) && self.is_sound(j) {
            middle * self.gap(i, j)
        } else if self.is_damaged(j) && self.is_sound(i) {
            1.0 - (1.0 - middle) * self.gap(j, i)
        } else {
            middle
        }
    }

    /// The area \[m²\] that each two labels share inside the body, in whole squares of the lattice.
    pub(crate) fn shared(&self) -> BTreeMap<(u32, u32), f64> {
        let square = self.lattice.spacing * self.lattice.spacing;
        let mut shared = BTreeMap::new();
        for i in (0..self.lattice.len()).filter(|&i| self.is_inside(i)) {
            for j in self.lattice.beside(i).filter(|&j| j > i) {
                let (a, b) = (self.reach[i], self.reach[j]);
                if a != b && self.is_inside(j) && self.connects(i, j) {
                    *shared.entry((a.min(b), a.max(b))).or_insert(0.0) += square;
                }
            }
        }
        shared
    }

    /// Gives label `l` the name `groups[l]`, then numbers the names that are left 0, 1, 2, ….
    pub(crate) fn rename(&mut self, groups: &[u32]) {
        let mut names = groups.to_vec();
        names.sort_unstable();
        names.dedup();
        let rank = |l: u32| match l {
            ZONE | NONE => l,
            _ => names.partition_point(|&other| other < groups[l as usize]) as u32,
        };
        let drawn = self.sampled.label.iter_mut();
        for label in self.label.iter_mut().chain(&mut self.reach).chain(drawn) {
            *label = rank(*label);
        }
        self.odds.rename(rank);
        for i in (0..self.lattice.len()).filter(|&i| self.sampled.ball[i] == NONE) {
            let Some(label) = self.odds.of(i).map(Odds::label) else {
                continue;
            };
            self.reach[i] = if label == ZONE { self.reach[i] } else { label };
        }
        let mut all_drawn = vec![true; names.len()];
        for (old, drawn) in self.sampled.whole.iter().enumerate() {
            all_drawn[rank(old as u32) as usize] &= drawn;
        }
        self.sampled.whole = if self.sampled.whole.is_empty() { Vec::new() } else { all_drawn };
        self.labels = names.len() as u32;
    }
}
