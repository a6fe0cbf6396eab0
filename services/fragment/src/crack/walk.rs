//! Labels for the nodes that have none: the likeliest end of a random walk (L. Grady, Random Walks
//! for Image Segmentation, 2006), so the border between two labels is a smooth surface where both
//! are equally likely.

use super::{DAMAGED, NONE, Nodes};
use std::collections::BTreeMap;

/// Labels that a node weighs; the least likely beyond are dropped.
const KEPT: usize = 4;
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

/// Of labels whose odds differ by less, a node takes the first. Taking the likelier, nodes in the
/// border itself would take one or the other as chance has it, and the faces would zigzag.
const TIE: f64 = 0.2;
/// A border may be crossed this far beyond the ends of an edge \[spacings\].
const BEYOND: f64 = 0.3;

/// All drawn pieces together. Each alone would lose to a whole piece where two of them meet, and
/// the whole piece would get a socket for each, with ridges between.
pub(super) const ZONE: u32 = NONE - 1;

/// How likely a walk from a node ends at each label: at most `KEPT`, likeliest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Odds {
    list: [(u32, f64); KEPT],
    count: usize,
}

impl Odds {
    fn sure(label: u32) -> Self {
        let mut list = [(0, 0.0); KEPT];
        list[0] = (label, 1.0);
        Self { list, count: 1 }
    }

    /// Of sums in any order, each label once; they are left in another order.
    fn of_sums(sums: &mut [(u32, f64)]) -> Self {
        sums.sort_unstable_by(|x, y| y.1.total_cmp(&x.1).then(x.0.cmp(&y.0)));
        let kept = &sums[..sums.len().min(KEPT)];
        let whole: f64 = kept.iter().map(|entry| entry.1).sum();
        let mut odds = Self { count: kept.len(), ..Self::default() };
        for (entry, &(label, sum)) in odds.list.iter_mut().zip(kept) {
            *entry = (label, sum / whole);
        }
        odds
    }

    fn list(&self) -> &[(u32, f64)] {
        &self.list[..self.count]
    }

    fn of(&self, label: u32) -> f64 {
        self.list().iter().find(|(other, _)| *other == label).map_or(0.0, |&(_, odds)| odds)
    }

    fn label(&self) -> u32 {
        let close = |&&(_, odds): &&(u32, f64)| odds > self.list[0].1 - TIE;
        self.list().iter().filter(close).map(|entry| entry.0).min().unwrap_or(NONE)
    }
}

fn add(sums: &mut Vec<(u32, f64)>, label: u32, odds: f64) {
    match sums.iter_mut().find(|(other, _)| *other == label) {
        Some(entry) => entry.1 += odds,
        None => sums.push((label, odds)),
    }
}

/// A step of a walk: to a node that is sure of its label, or to one with odds, and how likely.
#[derive(Clone, Copy, Debug)]
enum Way {
    Label(u32, f64),
    Slot(u32, f64),
}

impl Nodes {
    /// Gives every node a label, and a time of damage.
    pub(crate) fn fill(&mut self) {
        self.reach.clone_from(&self.label);
        // Labels must not leap across gaps between legs while there is a way through the body.
        self.carry(|nodes, i, j| nodes.is_inside(i) && nodes.is_inside(j) && nodes.connects(i, j));
        self.carry(|nodes, i, j| !(nodes.is_inside(i) && nodes.is_inside(j)));
        self.carry(|_, _, _| true);
        self.carry_times();
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

    fn carry_times(&mut self) {
        let mut queue: Vec<usize> =
            (0..self.lattice.len()).filter(|&i| self.time[i].is_finite()).collect();
        let mut head = 0;
        while head < queue.len() {
            let i = queue[head];
            head += 1;
            for j in self.lattice.beside(i) {
                if !self.time[j].is_finite() {
                    self.time[j] = self.time[i];
                    queue.push(j);
                }
            }
        }
    }

    /// Where pieces meet without a crack between, the shares of a node tell how near the border is.
    pub(super) fn expect(&mut self, i: usize, shares: impl Iterator<Item = (u32, f64)>) {
        let mut sums: Vec<(u32, f64)> = Vec::new();
        shares.for_each(|(label, share)| add(&mut sums, label, share));
        if sums.len() > 1 {
            self.slot[i] = self.odds.len() as u32;
            self.odds.push(Odds::of_sums(&mut sums));
        }
    }

    fn walk(&mut self) {
        let unsure: Vec<usize> =
            self.border().into_iter().filter(|&i| self.label[i] == NONE).collect();
        let first = self.odds.len();
        for (slot, &i) in unsure.iter().enumerate() {
            self.slot[i] = (first + slot) as u32;
            self.odds.push(Odds::sure(self.class(self.reach[i])));
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
                    self.odds[first + slot] = self.mean(ways, &mut sums);
                }
            }
        }
        let zone: Vec<(usize, Option<u32>)> = unsure
            .iter()
            .zip(&self.odds[first..])
            .filter(|(_, odds)| odds.label() == ZONE)
            .map(|(&i, _)| (i, self.nearest_drawn(i)))
            .collect();
        for (&i, odds) in unsure.iter().zip(&self.odds[first..]) {
            self.reach[i] = if odds.label() == ZONE { self.reach[i] } else { odds.label() };
        }
        for (i, ball) in zone {
            if let Some(ball) = ball {
                self.ball[i] = ball;
                self.reach[i] = self.drawn_label[ball as usize];
            }
        }
    }

    /// What a walk knows a label as.
    fn class(&self, label: u32) -> u32 {
        if self.all_drawn.get(label as usize) == Some(&true) { ZONE } else { label }
    }

    /// The nearest of the drawn pieces that first came to the nodes around.
    fn nearest_drawn(&self, i: usize) -> Option<u32> {
        let node = self.lattice.node(i);
        let place = self.lattice.place(node) / self.cell;
        [BESIDE, REACH].into_iter().find_map(|radius| {
            let near = self.lattice.around(node, radius).map(|j| self.reach[j]);
            let mut near: Vec<u32> = near.filter(|&label| self.class(label) == ZONE).collect();
            near.sort_unstable();
            near.dedup();
            let balls = (0..).zip(&self.drawn_label);
            let balls = balls.filter(|(_, label)| near.binary_search(label).is_ok());
            self.rubble.nearest(balls.map(|entry| entry.0), &place)
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
    fn ways(&self, i: usize) -> impl Iterator<Item = Way> {
        let open =
            move |&j: &usize| !self.is_inside(i) || (self.is_inside(j) && self.connects(i, j));
        self.lattice.beside(i).filter(open).map(move |j| {
            let weight = 1.0 / self.gap(i, j);
            match self.slot[j] {
                NONE => Way::Label(self.class(self.reach[j]), weight),
                slot => Way::Slot(slot, weight),
            }
        })
    }

    /// The mean of what the neighbours expect.
    fn mean(&self, ways: &[Way], sums: &mut Vec<(u32, f64)>) -> Odds {
        sums.clear();
        for way in ways {
            match *way {
                Way::Label(label, weight) => add(sums, label, weight),
                Way::Slot(slot, weight) => {
                    for &(label, odds) in self.odds[slot as usize].list() {
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
        let (here, there) = (self.broken[i], self.broken[j]);
        ((here - DAMAGED) / (here - there)).clamp(CLOSEST, 1.0)
    }

    /// The drawn pieces that two nodes lie in, if both do.
    pub(super) fn drawn(&self, i: usize, j: usize) -> Option<(u32, u32)> {
        let pair = (self.ball[i], self.ball[j]);
        (pair.0 != NONE && pair.1 != NONE).then_some(pair)
    }

    fn odds_of(&self, i: usize, label: u32) -> f64 {
        match self.slot[i] {
            NONE => f64::from(u8::from(self.reach[i] == label)),
            slot => self.odds[slot as usize].of(self.class(label)),
        }
    }

    /// Where on the edge from `i` to `j`, of different labels, both are equally likely: 0 at `i`.
    pub(super) fn crossing(&self, i: usize, j: usize) -> f64 {
        if let Some((one, two)) = self.drawn(i, j) {
            let [from, to] = [i, j].map(|n| self.lattice.place(self.lattice.node(n)) / self.cell);
            return self.rubble.crossing(one, two, &from, &to);
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
        let drawn = self.drawn_label.iter_mut();
        for label in self.label.iter_mut().chain(&mut self.reach).chain(drawn) {
            *label = rank(*label);
        }
        let mut sums = Vec::new();
        for odds in &mut self.odds {
            sums.clear();
            odds.list().iter().for_each(|&(label, share)| add(&mut sums, rank(label), share));
            *odds = Odds::of_sums(&mut sums);
        }
        for i in (0..self.slot.len()).filter(|&i| self.slot[i] != NONE && self.ball[i] == NONE) {
            let label = self.odds[self.slot[i] as usize].label();
            self.reach[i] = if label == ZONE { self.reach[i] } else { label };
        }
        let mut all_drawn = vec![true; names.len()];
        for (old, drawn) in self.all_drawn.iter().enumerate() {
            all_drawn[rank(old as u32) as usize] &= drawn;
        }
        self.all_drawn = if self.all_drawn.is_empty() { Vec::new() } else { all_drawn };
        self.labels = names.len() as u32;
    }
}
