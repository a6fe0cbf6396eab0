//! How likely a random walk from a lattice node ends at each label.

/// Labels that a node weighs; the least likely beyond are dropped.
const KEPT: usize = 4;
/// No label.
pub(super) const NONE: u32 = u32::MAX;

/// Of labels whose odds differ by less, a node takes the first. Taking the likelier, nodes in the
/// border itself would take one or the other as chance has it, and the faces would zigzag.
pub(super) const TIE: f64 = 0.2;

/// All sampled pieces together. Each alone would lose to a whole piece where two of them meet, and
/// the whole piece would get a socket for each, with ridges between.
pub(super) const ZONE: u32 = NONE - 1;

/// How likely a walk from a node ends at each label: at most `KEPT`, likeliest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Odds {
    list: [(u32, f64); KEPT],
    count: usize,
}

impl Odds {
    pub(super) fn sure(label: u32) -> Self {
        let mut list = [(0, 0.0); KEPT];
        list[0] = (label, 1.0);
        Self { list, count: 1 }
    }

    /// Of sums in any order, each label once; they are left in another order.
    pub(super) fn of_sums(sums: &mut [(u32, f64)]) -> Self {
        sums.sort_unstable_by(|x, y| y.1.total_cmp(&x.1).then(x.0.cmp(&y.0)));
        let kept = &sums[..sums.len().min(KEPT)];
        let whole: f64 = kept.iter().map(|entry| entry.1).sum();
        let mut odds = Self { count: kept.len(), ..Self::default() };
        for (entry, &(label, sum)) in odds.list.iter_mut().zip(kept) {
            *entry = (label, sum / whole);
        }
        odds
    }

    pub(super) fn list(&self) -> &[(u32, f64)] {
        &self.list[..self.count]
    }

    pub(super) fn of(&self, label: u32) -> f64 {
        self.list().iter().find(|(other, _)| *other == label).map_or(0.0, |&(_, odds)| odds)
    }

    pub(super) fn label(&self) -> u32 {
        let close = |&&(_, odds): &&(u32, f64)| odds > self.list[0].1 - TIE;
        self.list().iter().filter(close).map(|entry| entry.0).min().unwrap_or(NONE)
    }
}

pub(super) fn add(sums: &mut Vec<(u32, f64)>, label: u32, odds: f64) {
    match sums.iter_mut().find(|(other, _)| *other == label) {
        Some(entry) => entry.1 += odds,
        None => sums.push((label, odds)),
    }
}

/// The odds of the nodes that are not sure of their label.
#[derive(Debug)]
pub(super) struct OddsTable {
    /// Where a node's odds are, or `NONE`: it is sure of its label.
    pub(super) slot: Vec<u32>,
    pub(super) odds: Vec<Odds>,
}

impl OddsTable {
    /// All of so many nodes are sure.
    pub(super) fn new(nodes: usize) -> Self {
        Self { slot: vec![NONE; nodes], odds: Vec::new() }
    }

    /// Where pieces meet without a crack between, the shares of a node tell how near the border is.
    pub(super) fn expect(&mut self, node: usize, shares: impl Iterator<Item = (u32, f64)>) {
        let mut sums: Vec<(u32, f64)> = Vec::new();
        shares.for_each(|(label, share)| add(&mut sums, label, share));
        if sums.len() > 1 {
            self.set(node, Odds::of_sums(&mut sums));
        }
    }

    pub(super) fn set(&mut self, node: usize, odds: Odds) {
        self.slot[node] = self.odds.len() as u32;
        self.odds.push(odds);
    }

    /// None if the node is sure of its label.
    pub(super) fn of(&self, node: usize) -> Option<&Odds> {
        let slot = self.slot[node];
        (slot != NONE).then(|| &self.odds[slot as usize])
    }

    /// Labels get other names, which several may share.
    pub(super) fn rename(&mut self, name: impl Fn(u32) -> u32) {
        let mut sums = Vec::new();
        for odds in &mut self.odds {
            sums.clear();
            odds.list().iter().for_each(|&(label, share)| add(&mut sums, name(label), share));
            *odds = Odds::of_sums(&mut sums);
        }
    }
}
